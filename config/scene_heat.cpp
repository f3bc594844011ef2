#include <fmt/format.h>

#include <algorithm>

#include "config/parameter_ranges.h"
#include "config/scene_reader.h"

namespace palp {

namespace {

constexpr Range kTemperature{"K", 0, 1e5};  // from absolute zero

HeatZoneConfig read_zone(TomlTable& table, const SceneConfig& scene) {
  HeatZoneConfig zone;
  zone.where = table.where();
  std::vector<std::string> taken;
  for (const HeatZoneConfig& other : scene.heat_zones) taken.push_back(other.name);
  zone.name = read_name(table, "heat_zone", taken, false);
  if (const BodyConfig* body = read_body_name(table, scene, Need::optional)) {
    zone.body = body->name;
    if (body->type != BodyKind::rigid && body->type != BodyKind::fixed) {
      table.fault("body",
                  fmt::format("body '{}' has no frame to move with, expected a rigid or static body", body->name));
    }
  }
  zone.position = read_vector(table, "position", "m", zone.position, Need::required);
  zone.orientation = read_orientation(table);
  if (const auto size = table.numbers("size", 3, positive("m"), Need::required))
    zone.size = {(*size)[0], (*size)[1], (*size)[2]};
  zone.power = table.number("power", {"W", 0, 1e9}).value_or(0);
  zone.temperature = table.number("temperature", kTemperature);
  if (table.has("power") && table.has("temperature")) {
    table.fault("power", "both power and temperature are given, expected one of them");
  } else if (!table.has("power") && !table.has("temperature")) {
    table.fault("", "neither power nor temperature is given, expected one of them");
  }
  zone.start = table.number("start", not_negative("s")).value_or(zone.start);
  if (const auto end = table.number("end", positive("s"))) {
    zone.end = *end;
    if (*end <= zone.start) {
      table.fault("end", fmt::format("end is {}, expected more than start, which is {}", *end, zone.start));
    }
  }
  return zone;
}

bool is_warm(const BodyConfig& body) {
  return body.temperature || std::any_of(body.shapes.begin(), body.shapes.end(),
                                         [](const ShapeConfig& shape) { return shape.type == ShapeType::particles; });
}

}  // namespace

bool has_temperature(const SceneConfig& scene) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(), is_warm);
}

void read_heat_keys(TomlTable& table, MaterialConfig& material) {
  material.conductivity = table.number("conductivity", range_of("material.conductivity")).value_or(0);
  material.heat_capacity = table.number("heat_capacity", range_of("material.heat_capacity")).value_or(0);
  material.melting_temperature = table.number("melting_temperature", kTemperature);
  material.latent_heat = table.number("latent_heat", range_of("material.latent_heat")).value_or(0);
  if (table.has("melting_temperature") != table.has("latent_heat")) {
    const bool melts = table.has("melting_temperature");
    table.fault(
        melts ? "melting_temperature" : "latent_heat",
        fmt::format("{} is given without {}, expected both or none", melts ? "melting_temperature" : "latent_heat",
                    melts ? "latent_heat" : "melting_temperature"));
  }
  material.cooking_temperature = table.number("cooking_temperature", kTemperature);
  material.cooking_time =
      table.number("cooking_time", range_of("material.cooking_time")).value_or(material.cooking_time);
  if (table.has("cooking_time") && !table.has("cooking_temperature"))
    table.fault("cooking_time", "cooking_time is given without cooking_temperature, expected both or none");
  if (table.has("cooking_temperature") && !table.has("young_modulus"))
    table.fault("cooking_temperature",
                "cooking_temperature is given without young_modulus, expected that of the cooked material in Pa");
  material.rigid_below = table.number("rigid_below", kTemperature);
  material.rigid_when_set = table.boolean("rigid_when_set").value_or(false);
  if (material.rigid_when_set && !table.has("cooking_temperature"))
    table.fault("rigid_when_set", "rigid_when_set is true, but nothing sets; give a cooking_temperature in K");
  if (material.rigid_below &&
      !(material.young_modulus && (material.melting_temperature || table.has("cooking_temperature"))))
    table.fault("rigid_below",
                "rigid_below is given, but the material does not change state; give it a young_modulus, and a "
                "melting_temperature or a cooking_temperature");
  if (material.rigid_below && material.melting_temperature && *material.rigid_below > *material.melting_temperature)
    table.fault("rigid_below", fmt::format("rigid_below is {}, expected at most the melting_temperature, which is {}",
                                           *material.rigid_below, *material.melting_temperature));
  for (const char* key : {"conductivity", "melting_temperature", "cooking_temperature"}) {
    if (table.has(key) && !table.has("heat_capacity"))
      table.fault(key, fmt::format("{} is given without heat_capacity, expected one in J/(kg K)", key));
  }
}

bool read_hold_temperature(TomlTable& table, const BodyConfig& body) {
  const bool hold = table.boolean("hold_temperature").value_or(false);
  if (hold && !table.has("temperature") && !is_warm(body)) {
    table.fault("hold_temperature", "hold_temperature is true, but the body has no temperature; give it one");
  }
  return hold;
}

void read_heat(TomlTable& root, SceneConfig& scene) {
  TomlTable table = root.table("heat");
  table.set_title("heat");
  HeatConfig& heat = scene.heat;
  heat.loss_to_air = table.number("loss_to_air", {"W/(m^2 K)", 0, 1e9}).value_or(heat.loss_to_air);
  heat.air_temperature = table.number("air_temperature", kTemperature).value_or(heat.air_temperature);
  heat.rate_hz = table.number("rate_hz", {"Hz", 1e-3, 1e6});
  if (table.has("air_temperature") && !(heat.loss_to_air > 0)) {
    table.fault("air_temperature", "air_temperature is given, but loss_to_air is 0; give a coefficient in W/(m^2 K)");
  }
  for (TomlTable& item : root.tables("heat_zone")) scene.heat_zones.push_back(read_zone(item, scene));
  if (has_temperature(scene)) return;
  const std::string missing = " but no body has a temperature; give every body one";
  if (heat.loss_to_air > 0) table.fault("loss_to_air", "loss_to_air is given," + missing);
  if (!scene.heat_zones.empty()) root.fault("heat_zone", "there is a heat_zone," + missing);
}

}  // namespace palp
