#include "sim_server/trade/trade_table.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "config/error.h"
#include "config/json_file.h"
#include "config/text_file.h"

namespace palp {

namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{16} << 20;
// A step with the hand in motion over one with the hand at rest, where a table does not have both: a fluid that is
// stirred lists its neighbours more often. 1.3 is the median of what was measured on two cores and on a GPU (1.1
// to 1.6).
constexpr double kStirredOverCalm = 1.3;

// One entry of the file, with its place for messages: "scenes.tray_fluid.points[3]".
struct Entry {
  const std::string& file;
  const Json& json;
  std::string place;

  [[noreturn]] void fault(const std::string& text) const {
    throw ConfigError(fmt::format("{}: {}{}{}; make the table anew with tools/tradeoff", file, place,
                                  place.empty() ? "" : ": ", text));
  }
  std::string inner(const std::string& key) const { return place.empty() ? key : place + "." + key; }
  const Json& at(const char* key) const {
    if (!json.is_object()) fault("is " + std::string(json.type_name()) + ", expected an object");
    const auto found = json.find(key);
    if (found == json.end()) fault(fmt::format("has no '{}'", key));
    return *found;
  }
  bool has(const char* key) const { return json.is_object() && json.contains(key); }
  std::string text(const char* key) const {
    const Json& value = at(key);
    if (!value.is_string() || value.get_ref<const std::string&>().empty())
      fault(fmt::format("{} is {}, expected a text", key, value.dump(-1, ' ', true, Json::error_handler_t::replace)));
    return value.get<std::string>();
  }
  std::string text_or(const char* key, const char* otherwise) const { return has(key) ? text(key) : otherwise; }
  // A finite number above `low`, or from it on, up to `high`.
  double number(const char* key, double low, double high, bool above) const {
    const Json& value = at(key);
    const double x = value.is_number() ? value.get<double>() : std::nan("");
    if (above ? x > low && x <= high : x >= low && x <= high) return x;
    fault(fmt::format("{} is {}, expected a number {} {:g}{} {:g}", key,
                      value.dump(-1, ' ', true, Json::error_handler_t::replace), above ? "above" : "from", low,
                      above ? " and up to" : " to", high));
  }
};

std::vector<std::string> read_settings(const Entry& point) {
  std::vector<std::string> settings;
  if (!point.has("set")) return settings;
  const Json& set = point.at("set");
  if (!set.is_object()) point.fault("set is no object, expected keys of a scene file with their values");
  for (const auto& [key, value] : set.items()) {
    if (!value.is_primitive() || value.is_null() || key.find('=') != std::string::npos)
      point.fault(fmt::format("set has '{}', expected TABLE.KEY with a number, a text, true or false", key));
    settings.push_back(key + "=" + (value.is_string() ? value.get<std::string>() : value.dump()));
  }
  std::sort(settings.begin(), settings.end());
  return settings;
}

TradePoint read_point(const Entry& entry, bool flows) {
  TradePoint point;
  point.spacing = entry.number("spacing_m", 0, 1000, true);
  point.settings = read_settings(entry);
  point.step = entry.number("step_mean_s", 0, 1e4, true);
  point.step_p99 = entry.number("step_p99_s", 0, 1e5, true);
  point.calm_step = entry.has("calm_step_s") ? entry.number("calm_step_s", 0, 1e4, true)
                                             : point.step / (flows ? kStirredOverCalm : 1);
  point.error = entry.number("error", 0, 1000, false);
  if (entry.has("rest_drift_spacings")) point.rest_drift = entry.number("rest_drift_spacings", 0, 1e6, false);
  return point;
}

TradeScene read_scene_entry(const Entry& entry, const std::string& name, const TradeTable& table) {
  TradeScene scene;
  scene.name = name;
  scene.medium = entry.text("medium");
  scene.date = entry.text_or("date", table.date.c_str());
  scene.commit = entry.text_or("commit", table.commit.c_str());
  scene.rule = entry.text_or("rule", "");
  const bool flows = scene.medium != "elastic" && scene.medium != "rigid";
  if (entry.has("reference")) {
    const Entry reference{entry.file, entry.at("reference"), entry.inner("reference")};
    scene.uncertainty = reference.number("uncertainty", 0, 1000, false);
  }
  const Json& points = entry.at("points");
  if (!points.is_array() || points.empty()) entry.fault("points is no list with at least one point");
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Entry point{entry.file, points[k], entry.inner(fmt::format("points[{}]", k))};
    scene.points.push_back(read_point(point, flows));
    if (k > 0 && scene.points[k].step < scene.points[k - 1].step)
      point.fault("costs less than the point before it, expected points in the order of step_mean_s");
  }
  if (entry.has("levels")) {
    const Json& levels = entry.at("levels");
    if (!levels.is_object()) entry.fault("levels is no object, expected a point for each level");
    for (const auto& [level, json] : levels.items())
      scene.levels[level] = read_point({entry.file, json, entry.inner("levels." + level)}, flows);
  }
  return scene;
}

Json parse(const std::string& path) {
  try {
    return Json::parse(read_text_file(path, kMaxFileBytes));
  } catch (const Json::exception& error) {
    throw ConfigError(fmt::format("{}: this is no JSON ({}); make the table anew with tools/tradeoff", path,
                                  std::string(error.what())));
  }
}

}  // namespace

TradeTable read_trade_table(const std::string& path) {
  const Json json = parse(path);
  const Entry root{path, json, ""};
  TradeTable table;
  table.file = path;
  table.machine_class = root.text("class");
  table.hardware = root.text_or("hardware", "");
  table.date = root.text("date");
  table.commit = root.text_or("commit", "");
  const std::string named = std::filesystem::path(path).stem().string();
  if (table.machine_class != named)
    root.fault(fmt::format("class is '{}', expected '{}' as the file is named", table.machine_class, named));
  const Json& scenes = root.at("scenes");
  if (!scenes.is_object() || scenes.empty()) root.fault("scenes is no object with at least one scene");
  for (const auto& [name, scene] : scenes.items())
    table.scenes.push_back(read_scene_entry({path, scene, "scenes." + name}, name, table));
  return table;
}

std::string key_of(const std::string& setting) { return setting.substr(0, setting.find('=')); }

std::string value_of(const std::string& setting) {
  const std::size_t equals = setting.find('=');
  return equals == std::string::npos ? "" : setting.substr(equals + 1);
}

}  // namespace palp
