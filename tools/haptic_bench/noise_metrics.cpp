// Measures whether what should be calm is: a hand at rest, a minute of use, the age of what is rendered.
#include <fmt/format.h>

#include <cmath>

#include "tools/haptic_bench/bench_scenes.h"
#include "tools/haptic_bench/cells.h"
#include "tools/haptic_bench/series.h"

namespace palp::bench {

namespace {

constexpr double kBuzzHz = 30;  // slower than that is motion

double fast_force(const Trace& trace, double from, double to) {
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    const double part = rms_above(taken(trace, from, to, [a](const Tick& t) { return t.force[a]; }), kBuzzHz);
    sum += part * part;
  }
  return std::sqrt(sum);
}

double travel(const Trace& trace, double from, double to) {
  Eigen::Vector3d size;
  for (int a = 0; a < 3; ++a) size[a] = spread(taken(trace, from, to, [a](const Tick& t) { return t.x[a]; }));
  return size.norm();
}

// Returns the path of half a minute of use over jelly and stone, from and to the place above the jelly.
HandScript round_of_use(const HandModel& hand) {
  HandScript script;
  script.hand = hand;
  script.loop = true;
  double time = 0;
  const auto go = [&](double during, double x, double y, double z) {
    Keyframe k;
    k.time = time += during;
    k.x = {x, y, z};
    script.keyframes.push_back(k);
  };
  go(0, 0, 0, 0);
  go(1.2, 0, 0, 0);
  go(0.8, 0, 0, -0.02);  // into the jelly, and rest
  go(2.0, 0, 0, -0.02);
  for (int k = 0; k < 3; ++k) go(0.4, 0, 0, -0.01), go(0.4, 0, 0, -0.02);
  go(0.8, 0, 0, 0.02);
  go(0.8, kBareX, 0, 0.02);
  for (int k = 0; k < 5; ++k) go(0.2, kBareX, 0, -0.012), go(0.3, kBareX, 0, 0.01);  // taps on stone
  go(0.6, kBareX, 0, -0.02);                                                         // press, rest, slide, rest
  go(3.0, kBareX, 0, -0.02);
  for (int k = 0; k < 3; ++k) go(0.6, kBareX + 0.02, 0.02, -0.02), go(0.6, kBareX - 0.02, -0.02, -0.02);
  go(1.5, kBareX, 0, -0.02);
  go(0.6, kBareX, 0, 0.02);
  for (int k = 0; k < 4; ++k) go(0.4, kBareX, 0.05, 0.03), go(0.4, kBareX, -0.05, 0.03);  // wave
  go(1.0, 0, 0, 0.01);
  go(1.0, 0, 0, 0);
  go(30 - time, 0, 0, 0);
  return script;
}

}  // namespace

std::vector<Row> buzz_rows(const Scenes& scenes, const Cell& cell) {
  std::vector<Row> rows;
  const Trace wall = run(setup_in(scenes.wall, cell, push(cell.hand.model, 0.9, 0.5, {0, 0, -kGap - 0.02}), 5));
  Row r =
      row_in(cell, "resting on a wall, force above 30 Hz, rms", fast_force(wall, 3, 5), "N", "seed: bumps", "< 0.02");
  rows.push_back(judged(cell, r, r.result < 0.02, wall.trouble));
  r = row_in(cell, "resting on a wall, way of the handle", 1e3 * travel(wall, 3, 5), "mm", "", "< 0.01");
  rows.push_back(judged(cell, r, r.result < 0.01, wall.trouble));
  r = row_in(cell, "resting on a wall, share of the stiffness rendered at once",
             mean(taken(wall, 3, 5, [](const Tick& t) { return t.blend; })), "", "rigid: 1", ">= 0.9");
  rows.push_back(judged(cell, r, r.result >= 0.9, wall.trouble));
  const Trace tank = run(setup_in(scenes.tank, cell, push(cell.hand.model, 1, 1, Eigen::Vector3d::Zero()), 5));
  r = row_in(cell, "resting in a tank, force above 30 Hz, rms", fast_force(tank, 3, 5), "N", "", "< 0.02");
  r.note = fmt::format("handle moves {:.2g} mm, mean lift {:.2g} N", 1e3 * travel(tank, 3, 5),
                       mean(taken(tank, 3, 5, [](const Tick& t) { return t.force.z(); })));
  rows.push_back(judged(cell, r, r.result < 0.02, tank.trouble));
  return rows;
}

std::vector<Row> minute_rows(const Scenes& scenes, const Cell& cell, double seconds) {
  const Trace trace = run(setup_in(scenes.elastic, cell, round_of_use(cell.hand.model), seconds));
  double low = 0, linear = 0, angular = 0, active = 0, taken_up = 0, past_arm = 0;
  Series steps, contact;
  const CouplingGains gains = cell.profile.loop.gains;
  for (std::size_t k = 0; k < trace.ticks.size(); ++k) {
    const Tick& t = trace.ticks[k];
    const double e0 = t.put_in[0] - t.port[0], e1 = t.put_in[1] - t.port[1];
    linear = std::min(linear, e0);
    angular = std::min(angular, e1);
    low = std::min(low, e0 + e1);
    taken_up += 1e-3 * (cell.profile.setup<ArmModel>().damping * t.v.squaredNorm() +
                        cell.profile.setup<ArmModel>().angular_damping * t.w.squaredNorm());
    past_arm = std::min(past_arm, e0 + e1 + taken_up);
    active += t.active;
    if (k == 0) continue;
    // what the coupling itself changes by while the hand moves is no step
    const Tick& last = trace.ticks[k - 1];
    const double own = gains.stiffness * (t.x - last.x).norm() + gains.damping * (t.v - last.v).norm();
    steps.push_back(std::max(0.0, (t.force - last.force).norm() - own));
    if (t.force.norm() > 0.5) contact.push_back(steps.back() / t.force.norm());
  }
  std::vector<Row> rows;
  Row r = row_in(cell, fmt::format("{:.0f} s of use, energy shortfall", seconds), 1e3 * low, "mJ",
                 "held wrench -2.5 in 4 s", ">= -1");
  r.note = fmt::format("linear {:.2g}, angular {:.2g} mJ; past the arm's own damping {:.2g} mJ", 1e3 * linear,
                       1e3 * angular, 1e3 * past_arm);
  rows.push_back(judged(cell, r, r.result >= -1, trace.trouble));
  r = row_in(cell, fmt::format("{:.0f} s of use, controller active", seconds),
             100 * active / static_cast<double>(trace.ticks.size()), "% of ticks", "", "< 1");
  rows.push_back(judged(cell, r, r.result < 1, trace.trouble));
  const double p99 = quantile(steps, 0.99), relative = 100 * quantile(contact, 0.99);
  r = row_in(cell, fmt::format("{:.0f} s of use, step of the force beyond the coupling's own, 99 %", seconds), p99, "N",
             "held 0.3 to 0.6 at 2+1 ms", "< 0.05, or 5 %");
  r.note = fmt::format("{:.1f} % of the force, largest {:.2g} N; {} cuts, {} times stale", relative, quantile(steps, 1),
                       trace.report.cuts, trace.report.stale_events);
  rows.push_back(judged(cell, r, p99 < 0.05 || relative < 5, trace.trouble));
  return rows;
}

std::vector<Row> delay_rows(const Scenes& scenes, const Cell& cell) {
  const Trace trace = run(setup_in(scenes.wall, cell, push(cell.hand.model, 1, 1, Eigen::Vector3d::Zero()), 5));
  Series delays;
  for (const Tick& t : trace.ticks)
    if (t.verdict == 0) delays.push_back(1e3 * t.delay);
  std::vector<Row> rows;
  for (const auto& [share, name, most] : {std::tuple(0.5, "median", 2.0), std::tuple(0.99, "99 %", 5.0)}) {
    Row r = row_in(cell, fmt::format("pose read to wrench that answers it, {}", name), quantile(delays, share), "ms",
                   "noticed from 5.5", fmt::format("< {:g} (link of a host, 1 kHz)", most));
    if (cell.rate_hz >= 1000 && cell.link.name == "local") r = judged(cell, r, r.result < most, trace.trouble);
    rows.push_back(r);
  }
  return rows;
}

}  // namespace palp::bench
