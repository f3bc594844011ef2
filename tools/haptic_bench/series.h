// The figures that the metrics take from a series sampled once a tick. Pure.
#pragma once

#include <functional>
#include <vector>

#include "tools/haptic_bench/system.h"

namespace palp::bench {

using Series = std::vector<double>;

using OfTick = std::function<double(const Tick&)>;
// Returns the series of a value over the ticks with from <= t < to [s].
Series taken(const Trace& trace, double from, double to, const OfTick& get);

double mean(const Series& s);
double rms(const Series& s);
double spread(const Series& s);  // largest less smallest
// Returns the value that a share of the series does not exceed, 0..1.
double quantile(Series s, double share);
// Returns the amplitude of the sine of this frequency in the series; exact for whole periods.
double amplitude(const Series& s, double hz);
// Returns the rms of all that is faster than hz, a line through the series taken off before.
double rms_above(const Series& s, double hz);

struct SpringDamper {
  double stiffness, damping;
};
// Returns the best fit of force = c - stiffness x - damping v, in the least squares' sense, to the ticks with
// from <= t < to [s]. Each wrench acts until the next tick, and so against what the handle does between the two.
SpringDamper felt(const Trace& trace, double from, double to, const OfTick& force, const OfTick& x, const OfTick& v);

}  // namespace palp::bench
