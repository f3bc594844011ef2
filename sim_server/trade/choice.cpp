#include "sim_server/trade/choice.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "config/error.h"
#include "config/quantity.h"
#include "sim_server/scene/scene_files.h"
#include "sim_server/trade/calibration.h"
#include "sim_server/trade/machine_class.h"
#include "sim_server/trade/scene_curve.h"

namespace palp {

namespace {

// The numerics of a point on the command line; what was given there wins.
SceneOverrides with_point(SceneOverrides overrides, const TradePoint& point) {
  overrides.spacing = point.spacing;
  overrides.settings.insert(overrides.settings.begin(), point.settings.begin(), point.settings.end());
  return overrides;
}

std::string asked_for(const ChoiceRequest& request) {
  return request.budget ? "a budget of " + duration_text(*request.budget) : "an error of " + share_text(*request.error);
}

void expect(const MeasuredChoice& chosen, NumericsChoice& choice) {
  choice.expected_step = chosen.point.step;
  choice.expected_step_p99 = chosen.point.step_p99;
  choice.expected_error = chosen.point.error;
  choice.speed = chosen.speed;
}

// Throws ConfigError where an error is asked for that the reference of the curve could not tell.
void expect_told_apart(const std::string& scene_file, const ChoiceRequest& request, const SceneCurve& curve) {
  if (!request.error || *request.error >= curve.uncertainty) return;
  throw ConfigError(fmt::format(
      "{}: an error of {} cannot be told: the force of {} that errors were measured against is itself known within {} "
      "only; ask for that at least, or give a budget",
      scene_file, share_text(*request.error), curve.measured_with, share_text(curve.uncertainty)));
}

// The candidate that was made last, and what its scene will say of the choice: known once it was timed, when the
// simulation already holds the scene.
struct Made {
  std::unique_ptr<Simulation> simulation;
  std::shared_ptr<NumericsChoice> choice;
};

}  // namespace

std::unique_ptr<Simulation> choose_simulation(const std::string& scene_file, const SceneOverrides& overrides,
                                              Backend backend, const ChoiceRequest& request) {
  NumericsChoice frame;
  frame.asked = asked_for(request);
  frame.machine_class = machine_class(backend);
  const TradeTable table = read_trade_table(find_trade_table(frame.machine_class));
  const SceneCurve curve = curve_of(table, scene_file, overrides);
  frame.table = table.file;
  frame.table_date = curve.date;
  frame.table_commit = curve.commit;
  frame.measured_with = curve.measured_with;
  frame.own_curve = curve.own;
  frame.uncertainty = curve.uncertainty;
  expect_told_apart(scene_file, request, curve);
  Made made;
  const auto make = [&](const TradePoint& point) {
    made = {};  // before the next one needs its memory
    const SceneOverrides all = with_point(overrides, point);
    SceneConfig config = load_scene(scene_file, all);
    auto choice = std::make_shared<NumericsChoice>(frame);
    choice->spacing = point.spacing;
    choice->settings = point.settings;
    config.choice = choice;
    made = {make_simulation(sample_scene(config, particles_in_memory()), backend), choice};
  };
  const TimeCandidate time_candidate = [&](const TradePoint& point) {
    make(point);
    return calm_step(*made.simulation);
  };
  const bool trusted = curve.own && table.machine_class == frame.machine_class;
  const MeasuredChoice chosen = choose_measured(curve.points, request, trusted, scene_file, time_candidate);
  if (!made.simulation || made.choice->spacing != chosen.point.spacing ||
      made.choice->settings != chosen.point.settings)
    make(chosen.point);
  made.simulation->reset();
  expect(chosen, *made.choice);
  return std::move(made.simulation);
}

std::string told(const NumericsChoice& choice) {
  return fmt::format(
      "chosen for {}: a spacing of {:.4g} mm{}{}; expected: a step of {} (mean; 99 % within {}), an error of {} of "
      "the force, which is itself known within {}; by the curve of {}{} in {} of {}, this machine ({}) being {:.2f} "
      "times as fast; the same again: "
      "--spacing {:.6g}{}{}",
      choice.asked, 1e3 * choice.spacing, choice.settings.empty() ? "" : " with ", fmt::join(choice.settings, ", "),
      duration_text(choice.expected_step), duration_text(choice.expected_step_p99), share_text(choice.expected_error),
      share_text(choice.uncertainty), choice.measured_with, choice.own_curve ? "" : ", whose medium is the same,",
      choice.table, choice.table_date, choice.machine_class, choice.speed, choice.spacing,
      choice.settings.empty() ? "" : " --set ", fmt::join(choice.settings, " --set "));
}

Json json_of(const std::shared_ptr<const NumericsChoice>& choice) {
  if (!choice) return nullptr;
  Json set = Json::object();
  for (const std::string& setting : choice->settings) set[key_of(setting)] = value_of(setting);
  return {{"asked", choice->asked},
          {"spacing_m", choice->spacing},
          {"set", set},
          {"expected_step_s", choice->expected_step},
          {"expected_step_p99_s", choice->expected_step_p99},
          {"expected_error", choice->expected_error},
          {"reference_uncertainty", choice->uncertainty},
          {"machine_class", choice->machine_class},
          {"speed_over_table", choice->speed},
          {"measured_with", choice->measured_with},
          {"own_curve", choice->own_curve},
          {"table", choice->table},
          {"table_date", choice->table_date},
          {"table_commit", choice->table_commit}};
}

}  // namespace palp
