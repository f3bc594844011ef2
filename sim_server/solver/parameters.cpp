#include "sim_server/solver/parameters.h"

#include <fmt/format.h>

#include <cmath>
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

double number_in(const std::string& name, const std::string& value, double low, double high, const char* unit) {
  const double x = numbers(name, value, 1)[0];
  if (x < low || x > high)
    throw ConfigError(
        fmt::format("parameter {} is {}; expected {:g} to {:g}{}{}", name, value, low, high, *unit ? " " : "", unit));
  return x;
}

Eigen::Vector3d acceleration(const std::string& name, const std::string& value) {
  const std::vector<double> x = numbers(name, value, 3);
  Eigen::Vector3d a(x[0], x[1], x[2]);
  if (a.norm() > 1000) throw ConfigError(fmt::format("parameter {} is {}; expected at most 1000 m/s^2", name, value));
  return a;
}

}  // namespace

void apply_parameter(SceneConfig& config, const std::string& name, const std::string& value) {
  if (name == "gravity") {
    config.gravity = acceleration(name, value);
  } else if (name == "body_force") {
    config.body_force = acceleration(name, value);
  } else if (name == "numerics.artificial_viscosity") {
    config.numerics.artificial_viscosity = number_in(name, value, 0, 1, "");
  } else if (name == "numerics.density_diffusion") {
    config.numerics.density_diffusion = number_in(name, value, 0, 0.5, "");
  } else {
    for (MaterialConfig& material : config.materials)
      if (name == "material." + material.name + ".viscosity") {
        material.viscosity = number_in(name, value, 0, 1e5, "Pa s");
        return;
      }
    throw ConfigError(
        fmt::format("there is no parameter '{}'; expected gravity, body_force, material.NAME.viscosity, "
                    "numerics.artificial_viscosity or numerics.density_diffusion",
                    name));
  }
}

}  // namespace palp
