// The metrics of rotation. Targets are those of the ways at a lever of 0.1 m: 20 N m/rad for 2 kN/m, 0.03 N m for 0.30
// N.
#include <fmt/format.h>

#include <cmath>

#include "tools/haptic_bench/bench_scenes.h"
#include "tools/haptic_bench/cells.h"
#include "tools/haptic_bench/series.h"

namespace palp::bench {

namespace {

constexpr double kLever = 0.1, kLever2 = kLever * kLever;  // [m], [m^2]
const Eigen::Vector3d kTurnAxis = Eigen::Vector3d::UnitZ();

// The hand wants the tool turned 0.2 rad past where the jaws stop it.
Press twist(const Scene& vise, const Cell& cell, double stiffness, double damping, std::uint64_t seed) {
  RunSetup s = setup_in(vise, cell, turned(push(cell.hand.model, 0.9, 0.5, (kFreeTurn + 0.2) * kTurnAxis)), 5.4);
  s.profile.loop.gains.angular_stiffness = stiffness;
  s.profile.loop.gains.angular_damping = damping;
  s.seed = seed;
  Press p = judge(run(s));
  p.share = p.turn_share;
  return p;
}

Row widest_row(const Scene& vise, const Cell& cell, double damping, bool fine) {
  const auto at = [](double stiffness) { return kLever2 * stiffness; };
  const ZWidth z = widest({at(kLeastStiffness), at(kLikelyStiffness), at(kMostStiffness), fine, cell.seeds},
                          [&](double stiffness, int k) {
                            return twist(vise, cell, stiffness, damping, cell.seed + static_cast<std::uint64_t>(k));
                          });
  return width_row(cell, z, 1, fmt::format("largest stable angular stiffness, damping {:g} N m s/rad", damping),
                   "N m/rad", "1 kN/m at 0.1 m: 10", cell.hand.name == "off" ? 10 : 20);
}

}  // namespace

std::vector<Row> torsion_rows(const Scenes& scenes, const Cell& cell, const std::vector<double>& dampings, bool fine) {
  std::vector<Row> rows;
  for (const double damping : dampings) rows.push_back(widest_row(scenes.vise, cell, kLever2 * damping, fine));

  // as at the wall: weak hands reach further, so that each turns the handle by many steps of its encoder
  const double reach = std::max(1.0, kLightGrip.stiffness / cell.hand.model.stiffness);
  const Trace held = run(setup_in(
      scenes.vise, cell,
      delayed(turned(swing(cell.hand.model, (kFreeTurn + reach * 0.15) * kTurnAxis, reach * 0.04 * kTurnAxis, 2, 6)),
              1.5),
      7.5));
  const SpringDamper jaws = felt(
      held, 3.5, 7.5, [](const Tick& t) { return t.torque.z(); }, [](const Tick& t) { return t.turn.z(); },
      [](const Tick& t) { return t.w.z(); });
  const CouplingGains& gains = cell.profile.loop.gains;
  rows.push_back(error_row(cell, "torsion spring in jaws", jaws.stiffness, gains.angular_stiffness, "just noticed: 23",
                           fmt::format("{:.2f} of {:.2f} N m/rad", jaws.stiffness, gains.angular_stiffness),
                           held.trouble));
  rows.push_back(error_row(
      cell, "torsion damper in jaws", jaws.damping, gains.angular_damping, "just noticed: 34",
      fmt::format("{:.3f} of {:.3f} N m s/rad; a delay of 1 ms takes 0.01", jaws.damping, gains.angular_damping),
      held.trouble));

  // a hand that hardly holds on resonates with the arm there: it gets less to do
  constexpr double hz = 1, wanted = 0.5;
  const double asked = cell.hand.name == "off" ? 0.1 : wanted;
  const Trace free = run(setup_in(
      scenes.wall, cell, turned(swing(cell.hand.model, Eigen::Vector3d::Zero(), asked * kTurnAxis, hz, 6)), 6));
  const double reached = amplitude(taken(free, 2, 6, [](const Tick& t) { return t.turn.z(); }), hz);
  const double torque = rms(taken(free, 2, 6, [](const Tick& t) { return t.torque.norm(); }));
  Row r = row_in(cell, "torque of free turning, 0.5 rad at 1 Hz, rms", torque * wanted / reached, "N m",
                 "the tool's inertia alone 0.001", "<= 0.03");
  r.note = fmt::format("measured at {:.2f} rad", reached);
  rows.push_back(judged(cell, r, r.result <= 0.03, free.trouble));
  return rows;
}

}  // namespace palp::bench
