#include "tools/stability_map/run_cell.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "config/error.h"
#include "sim_server/scene/particle_count.h"
#include "sim_server/scene/scene_files.h"
#include "sim_server/solver/plan.h"
#include "tools/stability_map/books.h"
#include "tools/stability_map/hands.h"
#include "tools/stability_map/refusals.h"
#include "tools/stability_map/scene_text.h"

namespace palp::stability {
namespace {

constexpr double kWork = 1.5e6;  // of a cell, in visits of a particle with the neighbours of two spacings
constexpr int kChecks = 20;      // of the books

// The work of a haptic step, in visits of a particle by a pass over neighbours within two spacings.
double work_of(const Plan& plan, const Scene& scene) {
  const double n = static_cast<double>(scene.position.size());
  const double neighbors = std::pow(plan.support / scene.spacing / 2, 3);
  const double passes = plan.neighbors ? n * neighbors * (1 + 0.3 * plan.viscous_stages) : 0;
  const double elastic = plan.elastic_count * (1 + 0.5 * plan.elastic_rounds);
  return plan.sub_steps * (passes + elastic + 0.1 * n + 20);
}

Scene open(const Setup& setup, const std::string& folder, const std::string& file) {
  return sample_scene(load_scene(write_scene(setup, folder, file)), particles_in_memory());
}

// Opens the scene of a setup. Where it asks for a share of the limit, its rate is such that one sub-step a haptic step
// is that share; the limit may follow the rate, where a solver is chosen by it.
Scene open_at_share(Setup& setup, const std::string& folder, const std::string& file) {
  if (setup.share <= 0) return open(setup, folder, file);
  const double share = setup.share;
  for (int round = 0; round < 3; ++round) {
    setup.share = 0;
    const Plan plan = make_plan(open(setup, folder, file));
    setup.share = share;
    if (plan.dt_limit < 1e29) setup.rate = 1 / (share * plan.dt_limit);
  }
  return open(setup, folder, file);
}

void judge(const StepOutput& output, const Books& books, CellResult& result) {
  const Balance& b = books.balance();
  result.energy = b.energy;
  result.momentum = b.momentum;
  result.heat = b.heat;
  const auto fault = [&](const std::string& cause, const std::string& text) {
    result.end = End::fault;
    result.cause = cause;
    result.text = text;
  };
  result.end = End::bounded;
  if (!(b.energy <= 1)) return fault("energy created", fmt::format("{:.3g} of what is allowed", b.energy));
  if (!(b.momentum <= 1)) return fault("momentum", fmt::format("{:.3g} of what is allowed", b.momentum));
  if (!(b.heat <= 1)) return fault("temperature past its range", fmt::format("{:.3g} of what is allowed", b.heat));
  if (output.health.ok) return;
  // a run that is stopped before anything was created is refused, if late
  const std::string kind = kind_of_refusal(output.health.cause);
  fault(kind.empty() ? "stopped" : kind, fmt::format("after {:.4g} s: {}", output.time, output.health.cause));
  if (!kind.empty()) result.end = End::refused;
}

void run(const Setup& setup, const Plan& plan, Simulation& simulation, int steps, CellResult& result) {
  Books books(simulation, plan);
  HandPath hand(setup, simulation.scene());
  // a body has all of the push that a fluid gave it once the fluid is about to move again
  const int at_once = simulation.fluid_interval(), every = at_once * std::max(1, steps / kChecks / at_once);
  steps = (steps + at_once - 1) / at_once * at_once;
  bool ok = true;
  for (int k = 0; k < steps && (ok || k % at_once != 0); ++k) {
    const StepOutput& output = simulation.step(hand.at(k));
    ok = ok && output.health.ok;
    books.note(output);
    // where a run is stopped all that is finite is looked at
    const bool whole = k % at_once == at_once - 1;
    if (whole && output.health.non_finite == 0 && (!ok || k + 1 == at_once || k % every == every - 1 || k + 1 == steps))
      books.check(output);
  }
  const StepOutput& output = simulation.output();
  result.steps = static_cast<int>(output.step);
  result.time = output.time;
  judge(output, books, result);
}

void run_or_refuse(const std::string& cell, Backend backend, const RunLimits& limits, const std::string& folder,
                   const std::string& file, CellResult& result) {
  Setup setup = setup_of(cell);
  const Scene scene = open_at_share(setup, folder, file);
  result.particles = scene.position.size();
  const Plan plan = make_plan(scene);
  result.plan = describe(plan, scene);
  result.sub_steps = plan.sub_steps;
  const double work = work_of(plan, scene);
  if (2 * work > limits.most * kWork) {
    result.end = End::too_long;
    return;
  }
  const int steps = std::clamp(static_cast<int>(limits.work * kWork / work), 2,
                               static_cast<int>(kMostSteps * std::max(1.0, limits.work)));
  const auto simulation = make_simulation(scene, backend);
  run(setup, plan, *simulation, steps, result);
}

}  // namespace

CellResult run_cell(const std::string& cell, Backend backend, const RunLimits& limits, const std::string& folder,
                    const std::string& file) {
  using Clock = std::chrono::steady_clock;
  setup_of(cell);  // a name that is none is no refusal of a scene
  const auto begin = Clock::now();
  CellResult result;
  result.cell = cell;
  try {
    run_or_refuse(cell, backend, limits, folder, file, result);
  } catch (const ConfigError& error) {
    result.text = error.what();
    result.cause = kind_of_refusal(result.text);
    result.end = result.cause.empty() ? End::fault : End::refused;
    if (result.cause.empty()) result.cause = "a refusal of no known kind";
  } catch (const std::exception& error) {
    result.text = error.what();
    result.cause = "thrown";
  }
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

const char* to_string(End end) {
  constexpr const char* kNames[] = {"bounded", "refused", "fault", "too long"};
  return kNames[static_cast<int>(end)];
}

}  // namespace palp::stability
