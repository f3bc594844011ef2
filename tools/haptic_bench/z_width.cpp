#include "tools/haptic_bench/z_width.h"

#include <fmt/format.h>

#include <cmath>

#include "tools/haptic_bench/bench_scenes.h"
#include "tools/haptic_bench/cells.h"

namespace palp::bench {

namespace {

constexpr double kWait = 0.9;     // until the loop has engaged and the server's hand has taken hold [s]
constexpr double kReach = 0.5;    // the way there [s]
constexpr double kHold = 4;       // [s]
constexpr double kBehind = 0.02;  // the wall [m]

// The rms of a series about its mean, and the frequency that its crossings of the mean give.
struct Wobble {
  double rms = 0, hz = 0;
};

template <class Get>
Wobble wobble(const std::vector<Tick>& ticks, std::size_t first, const Get& get) {
  double mean = 0, sum = 0;
  const double n = static_cast<double>(ticks.size() - first);
  for (std::size_t k = first; k < ticks.size(); ++k) mean += get(ticks[k]) / n;
  int crossings = 0;
  double before = 0;
  for (std::size_t k = first; k < ticks.size(); ++k) {
    const double d = get(ticks[k]) - mean;
    sum += d * d;
    crossings += k > first && d * before < 0;
    if (d != 0) before = d;
  }
  return {std::sqrt(sum / n), 1e3 * crossings / (2 * n)};
}

}  // namespace

Press judge(const Trace& trace) {
  Press p;
  double low = 0;
  for (const Tick& t : trace.ticks) low = std::min(low, t.put_in[0] + t.put_in[1] - t.port[0] - t.port[1]);
  p.shortfall = -low;
  if (!trace.trouble.empty()) {
    p.why = trace.trouble;
    return p;
  }
  const std::size_t first = trace.ticks.size() - 1000;
  double most = -1;
  bool saturated = false, engaged = true;
  for (int a = 0; a < 3; ++a) {
    const Wobble w = wobble(trace.ticks, first, [a](const Tick& t) { return t.x[a]; });
    p.rms = std::hypot(p.rms, w.rms);
    if (w.rms > most) p.hz = w.hz, most = w.rms;
    p.turn_rms = std::hypot(p.turn_rms, wobble(trace.ticks, first, [a](const Tick& t) { return t.turn[a]; }).rms);
  }
  for (std::size_t k = first; k < trace.ticks.size(); ++k) {
    const Tick& t = trace.ticks[k];
    p.share = std::min(p.share, t.share);
    p.turn_share = std::min(p.turn_share, t.turn_share);
    p.delay += 1e-3 * t.delay;
    p.peak_force = std::max(p.peak_force, t.force.norm());
    saturated |= t.force.norm() > 0.999 * trace.force_limit || t.torque.norm() > 0.999 * trace.torque_limit;
    engaged &= t.state == LoopState::engaged || t.state == LoopState::degraded;
  }
  if (!engaged) {
    p.why = fmt::format("the loop is {}", palp::to_string(trace.ticks.back().state));
  } else if (saturated || p.rms > kStableRms || p.turn_rms > kStableTurn) {
    p.why = fmt::format("{:.2g} mm, {:.2g} mrad rms at {:.0f} Hz, up to {:.2g} N", 1e3 * p.rms, 1e3 * p.turn_rms, p.hz,
                        p.peak_force);
  } else {
    p.stable = true;
  }
  return p;
}

RunSetup wall_press(const Scene& wall, const Cell& cell, double stiffness, double damping, std::uint64_t seed) {
  RunSetup s =
      setup_in(wall, cell, push(cell.hand.model, kWait, kReach, {0, 0, -kGap - kBehind}), kWait + kReach + kHold);
  s.profile.loop.gains.stiffness = stiffness;
  s.profile.loop.gains.damping = damping;
  s.seed = seed;
  return s;
}

Press press_wall(const Scene& wall, const Cell& cell, double stiffness, double damping, std::uint64_t seed) {
  return judge(run(wall_press(wall, cell, stiffness, damping, seed)));
}

ZWidth widest(const Search& search, const std::function<Press(double, int)>& press) {
  ZWidth z;
  double share = 1;
  const auto stable = [&](double stiffness, int seed) {
    const Press p = press(stiffness, seed);
    if (p.stable) {
      share = p.share;
      z.delay = std::max(z.delay, p.delay);
    } else {
      z.first_unstable = p;
      z.unstable_at = stiffness;
    }
    return p.stable;
  };
  double low = search.likely;
  if (stable(low, 0)) {
    while (low < search.most && stable(2 * low, 0)) low *= 2;
  } else {
    do low /= 2;
    while (low >= search.least && !stable(low, 0));
    if (low < search.least) return z;
  }
  double rendered = share * low, ratio = std::sqrt(2);
  for (; low < search.most; ratio = std::sqrt(ratio)) {
    if (stable(low * ratio, 0)) low *= ratio, rendered = share * low;
    if (ratio < (search.fine ? 1.1 : 1.2)) break;
  }
  for (int seed = 1; seed < search.seeds; ++seed) {
    while (!stable(low, seed))
      if ((low /= std::sqrt(2)) < search.least) return z;
    rendered = std::min(rendered, share * low);
  }
  z.stiffness = rendered;
  z.asked = low;
  return z;
}

ZWidth z_width(const Scene& wall, const Cell& cell, double damping, bool fine) {
  return widest({kLeastStiffness, kLikelyStiffness, kMostStiffness, fine, cell.seeds}, [&](double stiffness, int k) {
    return press_wall(wall, cell, stiffness, damping, cell.seed + static_cast<std::uint64_t>(k));
  });
}

namespace {

// Returns in words the stiffness that theory allows a spring that is rendered at once, and one that is rendered after
// the delay: b > K (T/2 + t) + |B| with the damping b of arm and hand (Colgate & Schenkel 1997; Diolaiti et al. 2006).
std::string lines(const Cell& cell, double damping, double delay) {
  const double b = cell.profile.setup<ArmModel>().damping + cell.hand.model.damping - damping;
  if (b <= 0) return fmt::format("passive: none, as b < B; hard surface 0.8 to 1");
  return fmt::format("passive: {:.2g} at once, {:.2g} after {:.2g} ms; hard surface 0.8 to 1", 1e-3 * b / 0.5e-3,
                     1e-3 * b / (0.5e-3 + delay), 1e3 * delay);
}

}  // namespace

Row width_row(const Cell& cell, const ZWidth& z, double scale, const std::string& metric, const std::string& unit,
              const std::string& reference, double wanted) {
  Row r = row_in(cell, metric, scale * z.stiffness, unit, reference, fmt::format(">= {:g}", wanted));
  if (cell.variant == Variant::ours) r.pass = r.result >= wanted;
  if (z.asked > 1.01 * z.stiffness) r.note = fmt::format("asked for {:.3g}, lowered for the link; ", scale * z.asked);
  if (z.unstable_at > 0) r.note += fmt::format("at {:.3g}: {}", scale * z.unstable_at, z.first_unstable.why);
  return r;
}

std::vector<Row> z_width_rows(const Scene& wall, const Cell& cell, const std::vector<double>& dampings, bool fine) {
  std::vector<Row> rows;
  for (const double damping : dampings) {
    const ZWidth z = z_width(wall, cell, damping, fine);
    rows.push_back(width_row(cell, z, 1e-3, fmt::format("largest stable stiffness, damping {:g} N s/m", damping),
                             "kN/m", lines(cell, damping, z.delay), cell.hand.name == "off" ? 1 : 2));
  }
  return rows;
}

}  // namespace palp::bench
