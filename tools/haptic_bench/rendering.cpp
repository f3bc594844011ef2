// Measures what the hand should feel, and does: free space, spring and damper, jelly, a current.
#include <fmt/format.h>

#include <cmath>

#include "tools/haptic_bench/bench_scenes.h"
#include "tools/haptic_bench/cells.h"
#include "tools/haptic_bench/series.h"

namespace palp::bench {

namespace {

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX(), kZ = Eigen::Vector3d::UnitZ();

// Returns the static force of the solver on a device that stays at an offset from where the handle was at the start.
double static_force(const Scene& scene, const CouplingGains& gains, const Eigen::Vector3d& offset, double seconds) {
  const auto simulation = make_simulation(scene, Backend::cpu);
  StepInput input{};
  const RigidState start = simulation->output().proxies[0].state;
  input[0].engaged = true;
  input[0].gains = {gains.stiffness, gains.damping, gains.angular_stiffness, gains.angular_damping};
  const long steps = std::lround(seconds * scene.config.rate_hz), ramp = steps / 3;
  double sum = 0;
  for (long k = 0; k < steps; ++k) {
    const double way = std::min(1.0, static_cast<double>(k) / static_cast<double>(ramp));
    input[0].state = start;
    input[0].state.position += way * offset;
    simulation->step(input);
    if (k >= steps - 200) sum += simulation->output().proxies[0].force.z() / 200;
  }
  return sum;
}

}  // namespace

std::vector<Row> drag_rows(const Scenes& scenes, const Cell& cell) {
  constexpr double amplitude_wanted = 0.05, hz = 1;
  const RunSetup s =
      setup_in(scenes.wall, cell, swing(cell.hand.model, Eigen::Vector3d::Zero(), amplitude_wanted * kX, hz, 6), 6);
  const Trace trace = run(s);
  const double reached = amplitude(taken(trace, 2, 6, [](const Tick& t) { return t.x.x(); }), hz);
  const double force = rms(taken(trace, 2, 6, [](const Tick& t) { return t.force.norm(); }));
  Row r = row_in(cell, "force of free motion, 50 mm at 1 Hz, rms", force * amplitude_wanted / reached, "N",
                 "the tool's 0.15 kg alone 0.21", "<= 0.30");
  r.note = fmt::format("measured at {:.0f} mm", 1e3 * reached);
  return {judged(cell, r, r.result <= 0.30, trace.trouble)};
}

std::vector<Row> rendering_rows(const Scenes& scenes, const Cell& cell) {
  std::vector<Row> rows;
  // weak hands reach further, so that each moves the handle by many steps of its encoder and not only friction's
  // bristle
  const double reach = std::max(1.0, kLightGrip.stiffness / cell.hand.model.stiffness);
  const double depth = kGap + reach * 0.015;
  // the hand begins in the wall's reach only after the loop has engaged
  const RunSetup s =
      setup_in(scenes.wall, cell, delayed(swing(cell.hand.model, -depth * kZ, reach * 0.004 * kZ, 2, 6), 1.5), 7.5);
  const Trace trace = run(s);
  const SpringDamper wall = felt(
      trace, 3.5, 7.5, [](const Tick& t) { return t.force.z(); }, [](const Tick& t) { return t.x.z(); },
      [](const Tick& t) { return t.v.z(); });
  const CouplingGains& gains = s.profile.loop.gains;
  rows.push_back(error_row(cell, "spring at a wall", wall.stiffness, gains.stiffness, "just noticed: 23",
                           fmt::format("{:.0f} of {:.0f} N/m", wall.stiffness, gains.stiffness), trace.trouble));
  rows.push_back(error_row(cell, "damper at a wall", wall.damping, gains.damping, "just noticed: 34",
                           fmt::format("{:.1f} of {:.1f} N s/m; a delay of 1 ms takes 1", wall.damping, gains.damping),
                           trace.trouble));

  const RunSetup e = setup_in(scenes.elastic, cell, push(cell.hand.model, 0.9, 0.8, -0.02 * kZ), 4);
  const Trace press = run(e);
  const double z = mean(taken(press, 3.5, 4, [](const Tick& t) { return t.x.z(); }));
  const double force = mean(taken(press, 3.5, 4, [](const Tick& t) { return t.force.z(); }));
  const double exact = static_force(scenes.elastic, gains, z * kZ, 2.5);
  rows.push_back(error_row(cell, "force of jelly", force, exact, "just noticed: 8",
                           fmt::format("{:.3g} of {:.3g} N at {:.2g} mm", force, exact, -1e3 * z), press.trouble));
  return rows;
}

std::vector<Row> current_rows(const Scenes& scenes, const Cell& cell) {
  constexpr double speed = 0.1, hz = 1, seconds = 5;
  const auto moved = [&](const Cell& c, std::string& trouble) {
    RunSetup s = setup_in(scenes.current, c, push(c.hand.model, 1, 1, Eigen::Vector3d::Zero()), seconds);
    s.before_step = [](Simulation& simulation, double t) {
      const double w = 2 * M_PI * hz;
      simulation.set_parameter("body_force", fmt::format("{} 0 0", speed * w * std::cos(w * t)));
    };
    const Trace trace = run(s);
    trouble += trace.trouble;
    return amplitude(taken(trace, 2, seconds, [](const Tick& t) { return t.x.x(); }), hz);
  };
  std::string trouble;
  Cell ideal = cell;
  ideal.rate_hz = 1000;
  ideal.link = link_from("none");
  const double reference = moved(ideal, trouble), here = moved(cell, trouble);
  Row r = row_in(cell, "motion of a hand in a current, kept", here / reference, "", "one-port control 0.62", ">= 0.95");
  r.note = fmt::format("{:.2f} of {:.2f} mm", 1e3 * here, 1e3 * reference);
  return {judged(cell, r, r.result >= 0.95, trouble)};
}

}  // namespace palp::bench
