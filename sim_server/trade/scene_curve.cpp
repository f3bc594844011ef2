#include "sim_server/trade/scene_curve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "config/error.h"
#include "config/text_file.h"
#include "config/toml_reader.h"
#include "sim_server/scene/scene_files.h"
#include "sim_server/trade/front.h"
#include "sim_server/trade/scene_medium.h"

namespace palp {

namespace {

const char* const kSupport = "numerics.support_over_spacing";
// Settings that mean the same in every scene: they have no unit.
const char* const kOfEveryScene[] = {"scene.accuracy",
                                     "scene.method",
                                     kSupport,
                                     "numerics.artificial_viscosity",
                                     "numerics.density_diffusion",
                                     "numerics.shift",
                                     "numerics.safety",
                                     "numerics.viscosity",
                                     "numerics.elastic_solver",
                                     "numerics.elastic_rounds",
                                     "numerics.skin_over_spacing",
                                     "numerics.tension"};
// How far a curve is continued past its coarsest point: to this many times its spacing.
constexpr double kContinued = 2;
// Below three spacings surface tension freezes particles on their lattice (solver/plan.cpp).
constexpr double kLeastSupportOfDrops = 3;

// A scene as its file has it, at its coarsest level.
SceneConfig coarsest(const std::string& file) {
  SceneOverrides overrides;
  overrides.accuracy = Accuracy::fast;
  try {
    return load_scene(file, overrides);
  } catch (const ConfigError&) {
    return load_scene(file);  // it may know no spacing for that level
  }
}

std::optional<std::string> value_in(const std::vector<std::string>& settings, const std::string& key) {
  for (auto setting = settings.rbegin(); setting != settings.rend(); ++setting)
    if (key_of(*setting) == key) return value_of(*setting);
  return std::nullopt;
}

// Returns whether two values say the same: "3" and "3.0" do.
bool same_value(const std::string& a, const std::string& b) {
  const std::optional<double> x = parse_number(a), y = parse_number(b);
  return x && y ? *x == *y : a == b;
}

bool file_states(TomlFile& file, const std::string& key) {
  const std::size_t dot = key.find('.');
  return dot != std::string::npos && file.root().table(key.substr(0, dot)).has(key.substr(dot + 1));
}

void check_choosable(const SceneConfig& config, const SceneOverrides& overrides) {
  for (const char* key : {"numerics.spacing", "scene.accuracy"})
    if (value_in(overrides.settings, key))
      throw ConfigError(
          fmt::format("--set {} is given, but a budget or an error chooses that: leave out one of the two", key));
  for (const BodyConfig& body : config.bodies)
    if (!body.shapes.empty() && body.shapes.front().type == ShapeType::particles)
      throw ConfigError(
          fmt::format("{}: the particles of body '{}' are read from a file, which leaves no spacing to "
                      "choose: leave out --budget and --error",
                      body.where, body.name));
}

// Returns the table's scene that serves: the one of the file's name, else the first of its medium.
const TradeScene& serving_scene(const TradeTable& table, const SceneConfig& config) {
  const std::string name = std::filesystem::path(config.path).stem().string(), medium = medium_of(config);
  std::string media;
  const TradeScene* found = nullptr;
  for (const TradeScene& scene : table.scenes) {
    if (scene.name == name) return scene;
    if (!found && scene.medium == medium) found = &scene;
    if (media.find(scene.medium) == std::string::npos) media += (media.empty() ? "" : ", ") + scene.medium;
  }
  if (found) return *found;
  throw ConfigError(fmt::format(
      "{}: no curve for a scene whose medium is {}, as that of {} is; there are curves for {}: give --accuracy or "
      "--spacing instead, or measure one with tools/tradeoff {}",
      table.file, medium, config.path, media, name));
}

// Returns the points that this scene and its command line can have.
std::vector<TradePoint> usable(const std::vector<TradePoint>& points, const SceneConfig& config,
                               const SceneOverrides& overrides, bool own) {
  const bool drops = std::any_of(config.materials.begin(), config.materials.end(),
                                 [](const MaterialConfig& m) { return m.surface_tension > 0 || m.adhesion > 0; });
  const auto fits = [&](const TradePoint& point) {
    const std::string method = value_in(overrides.settings, "scene.method").value_or(to_string(config.method));
    const std::string wanted = overrides.method ? to_string(*overrides.method) : method;
    if (value_in(point.settings, "scene.method").value_or("accurate") != wanted) return false;
    // a step of another rate is another share of a second
    if (const auto rate = value_in(point.settings, "scene.rate_hz"))
      if (!same_value(*rate, fmt::format("{}", config.rate_hz))) return false;
    return std::all_of(point.settings.begin(), point.settings.end(), [&](const std::string& setting) {
      const std::string key = key_of(setting);
      const bool everywhere =
          std::find(std::begin(kOfEveryScene), std::end(kOfEveryScene), key) != std::end(kOfEveryScene);
      const std::optional<std::string> asked = value_in(overrides.settings, key);
      if (asked && !same_value(*asked, value_of(setting))) return false;
      if (!own && drops && key == kSupport && parse_number(value_of(setting)).value_or(0) < kLeastSupportOfDrops)
        return false;
      return own || everywhere || asked.has_value();
    });
  };
  std::vector<TradePoint> left;
  std::copy_if(points.begin(), points.end(), std::back_inserter(left), fits);
  return left;
}

// Leaves to a scene that was not measured what its file states.
void keep_what_the_file_states(const std::string& path, std::vector<TradePoint>& points) {
  TomlFile file = TomlFile::read(path);
  for (TradePoint& point : points) {
    const auto stated = [&](const std::string& setting) {
      return key_of(setting) != "scene.accuracy" && file_states(file, key_of(setting));
    };
    point.settings.erase(std::remove_if(point.settings.begin(), point.settings.end(), stated), point.settings.end());
  }
}

// Returns the points with their spacings scaled, none coarser than `coarsest` [m]: stretches are cut there, or
// continued to there. Where all are coarser, the finest is moved there, its error being no less then.
std::vector<TradePoint> scaled_to(std::vector<TradePoint> points, double scale, double coarsest) {
  for (TradePoint& point : points) point.spacing *= scale;
  std::vector<TradePoint> result;
  for (const TradePoint& point : points)
    if (point.spacing <= coarsest * (1 + 1e-9)) result.push_back(point);
  const auto pairs = stretches(points);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto& [fine, coarse] = pairs[k];
    const bool last = k + 1 == pairs.size() || pairs[k + 1].first.settings != coarse.settings;
    const double end = std::min(coarsest, last ? kContinued * coarse.spacing : coarse.spacing);
    if (end > fine.spacing && (end < coarse.spacing * (1 - 1e-9) || (last && end > coarse.spacing * (1 + 1e-9))))
      result.push_back(along(fine, coarse, end));
  }
  if (!result.empty() || points.empty()) return result;
  TradePoint finest = *std::min_element(points.begin(), points.end(),
                                        [](const TradePoint& a, const TradePoint& b) { return a.spacing < b.spacing; });
  const double dearer = std::pow(finest.spacing / coarsest, 4);  // particles by the third power, sub-steps by the first
  finest.spacing = coarsest;
  for (double* time : {&finest.step, &finest.step_p99, &finest.calm_step}) *time *= dearer;
  return {finest};
}

// Returns whether the scene in a file is palp's own of that name, letter for letter.
bool is_palps_own(const SceneConfig& config, const TradeScene& scene) {
  if (std::filesystem::path(config.path).stem() != scene.name) return false;
  try {
    return coarsest(find_scene_file(scene.name)).hash == config.hash;
  } catch (const ConfigError&) {
    return false;
  }
}

}  // namespace

SceneCurve curve_of(const TradeTable& table, const std::string& scene_file, const SceneOverrides& overrides) {
  const SceneConfig config = coarsest(scene_file);
  check_choosable(config, overrides);
  const TradeScene& measured = serving_scene(table, config);
  SceneCurve curve;
  curve.measured_with = measured.name;
  curve.date = measured.date;
  curve.commit = measured.commit;
  curve.uncertainty = measured.uncertainty;
  curve.own = is_palps_own(config, measured);
  curve.points = usable(measured.points, config, overrides, curve.own);
  if (curve.points.empty())
    throw ConfigError(fmt::format(
        "{}: no point of '{}' has the method, rate and numerics that are asked of {}: leave out --method or --set, or "
        "give --accuracy or --spacing instead of a budget or an error",
        table.file, measured.name, config.path));
  if (curve.own) return curve;
  const SceneConfig reference = coarsest(find_scene_file(measured.name));
  const bool tools = !config.proxies.empty() && !reference.proxies.empty();
  const double here = resolved_length(config, !tools), there = resolved_length(reference, !tools);
  keep_what_the_file_states(config.path, curve.points);
  curve.points = scaled_to(curve.points, here > 0 && there > 0 ? here / there : 1, config.numerics.spacing.value());
  return curve;
}

}  // namespace palp
