#include "sim_server/solver/changeable_parameters.h"

#include <fmt/format.h>

#include <optional>
#include <vector>

#include "config/error.h"
#include "config/parameter_ranges.h"

namespace palp {
namespace {

// A parameter and where it lies in a configuration.
struct Place {
  std::string name;
  const ParameterRow* row;
  double* number = nullptr;  // one of the three
  std::optional<double>* setting = nullptr;
  Eigen::Vector3d* vector = nullptr;
};

std::vector<Place> places_in(SceneConfig& c) {
  const auto row = [](const char* key) { return &parameter_row(key); };
  std::vector<Place> places{
      {"gravity", row("gravity"), nullptr, nullptr, &c.gravity},
      {"body_force", row("body_force"), nullptr, nullptr, &c.body_force},
      {"numerics.artificial_viscosity", row("numerics.artificial_viscosity"), nullptr,
       &c.numerics.artificial_viscosity},
      {"numerics.density_diffusion", row("numerics.density_diffusion"), nullptr, &c.numerics.density_diffusion},
  };
  for (MaterialConfig& material : c.materials)
    places.push_back({"material." + material.name + ".viscosity", row("material.viscosity"), &material.viscosity});
  return places;
}

void set(const Place& place, const std::string& value) {
  const std::vector<double> x = parse_parameter(*place.row, place.name, value);
  if (place.vector) *place.vector = {x.at(0), x.at(1), x.at(2)};
  if (place.setting) *place.setting = x.at(0);
  if (place.number) *place.number = x.at(0);
}

std::string text_of(const Place& place) {
  if (place.vector) return fmt::format("{:g} {:g} {:g}", place.vector->x(), place.vector->y(), place.vector->z());
  if (place.setting) return *place.setting ? fmt::format("{:g}", **place.setting) : "";
  return fmt::format("{:g}", *place.number);
}

}  // namespace

void apply_parameter(SceneConfig& config, const std::string& name, const std::string& value) {
  for (const Place& place : places_in(config))
    if (place.name == name) return set(place, value);
  throw ConfigError(
      fmt::format("there is no parameter '{}'; expected gravity, body_force, material.NAME.viscosity, "
                  "numerics.artificial_viscosity or numerics.density_diffusion",
                  name));
}

std::vector<Parameter> parameters_of(const SceneConfig& config) {
  SceneConfig copy = config;
  std::vector<Parameter> out;
  for (const Place& place : places_in(copy)) {
    const Range& range = place.row->range;
    out.push_back({place.name, text_of(place), range.unit, range.min, range.max});
  }
  return out;
}

}  // namespace palp
