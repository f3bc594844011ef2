#include "sim_server/solver/parameters.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <sstream>
#include <vector>

#include "config/error.h"

namespace palp {
namespace {

std::vector<double> numbers(const std::string& name, const std::string& value, std::size_t count) {
  std::vector<double> out;
  std::istringstream in(value);
  double x = 0;
  while (in >> x && std::isfinite(x)) out.push_back(x);
  if (out.size() != count || !in.eof())
    throw ConfigError(fmt::format("parameter {} is '{}'; expected {} finite number{} separated by blanks", name, value,
                                  count, count == 1 ? "" : "s"));
  return out;
}

// A parameter, where it lies in a configuration, and what it may be.
struct Row {
  std::string name;
  const char* unit;
  double low, high;
  double* number = nullptr;  // one of the three
  std::optional<double>* setting = nullptr;
  Eigen::Vector3d* vector = nullptr;
};

std::vector<Row> rows_of(SceneConfig& c) {
  constexpr double kMostAcceleration = 1000, kMostViscosity = 1e5;
  std::vector<Row> rows{
      {"gravity", "m/s^2", 0, kMostAcceleration, nullptr, nullptr, &c.gravity},
      {"body_force", "m/s^2", 0, kMostAcceleration, nullptr, nullptr, &c.body_force},
      {"numerics.artificial_viscosity", "", 0, 1, nullptr, &c.numerics.artificial_viscosity},
      {"numerics.density_diffusion", "", 0, 0.5, nullptr, &c.numerics.density_diffusion},
  };
  for (MaterialConfig& material : c.materials)
    rows.push_back({"material." + material.name + ".viscosity", "Pa s", 0, kMostViscosity, &material.viscosity});
  return rows;
}

void set(const Row& row, const std::string& value) {
  const std::vector<double> x = numbers(row.name, value, row.vector ? 3 : 1);
  const double size = row.vector ? std::hypot(x[0], x[1], x[2]) : x[0];
  if (size < row.low || size > row.high)
    throw ConfigError(fmt::format("parameter {} is {}; expected {}{:g}{}{}", row.name, value,
                                  row.vector ? "at most " : fmt::format("{:g} to ", row.low), row.high,
                                  *row.unit ? " " : "", row.unit));
  if (row.vector) *row.vector = {x[0], x[1], x[2]};
  if (row.setting) *row.setting = x[0];
  if (row.number) *row.number = x[0];
}

std::string text_of(const Row& row) {
  if (row.vector) return fmt::format("{:g} {:g} {:g}", row.vector->x(), row.vector->y(), row.vector->z());
  if (row.setting) return *row.setting ? fmt::format("{:g}", **row.setting) : "";
  return fmt::format("{:g}", *row.number);
}

}  // namespace

void apply_parameter(SceneConfig& config, const std::string& name, const std::string& value) {
  for (const Row& row : rows_of(config))
    if (row.name == name) return set(row, value);
  throw ConfigError(
      fmt::format("there is no parameter '{}'; expected gravity, body_force, material.NAME.viscosity, "
                  "numerics.artificial_viscosity or numerics.density_diffusion",
                  name));
}

std::vector<Parameter> parameters_of(const SceneConfig& config) {
  SceneConfig copy = config;
  std::vector<Parameter> out;
  for (const Row& row : rows_of(copy)) out.push_back({row.name, text_of(row), row.unit, row.low, row.high});
  return out;
}

}  // namespace palp
