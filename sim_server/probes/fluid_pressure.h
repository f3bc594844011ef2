// The pressure within a fluid, as a gauge or a wall would feel it.
#pragma once

#include <optional>

#include "sim_server/probes/snapshot_points.h"

namespace palp {

// Where a fluid's particles attract each other (physics/cohesion.h), its pressure of state balances that attraction,
// too: by 17 sigma / H, which nobody feels. There the pressure is what both together press through a particle's
// neighbourhood (Irving & Kirkwood 1950): p_i = sum_j V_j ((p_i + p_j) F r^2 - s phi r) / 6; of a solid's particles,
// whose pressure is the fluid's own, p_j = p_i. Elsewhere it is the pressure of state. Host, double precision.
class FluidPressure {
 public:
  explicit FluidPressure(const Scene& scene) : scene_(scene) {}  // keeps a reference

  void load(const Snapshot* snapshot);      // which must outlive what is asked of it
  double of(std::uint32_t particle) const;  // of a fluid [Pa]

 private:
  const Scene& scene_;
  const Snapshot* snapshot_ = nullptr;
  mutable std::optional<SnapshotPoints> points_;  // listed when the first attracted particle is asked for
};

}  // namespace palp
