#include "config/parameter_ranges.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "config/error.h"
#include "config/text_file.h"

namespace palp {

namespace {

constexpr Range kAcceleration{"m/s^2", -1e5, 1e5};
constexpr Range kSpeed{"m/s", 1e-6, 1e9};
constexpr const char* kOnlySign = "none is negative; the bound only keeps single precision finite";

// clang-format off
const std::vector<ParameterRow> kParameters{
    // key, range of each number, how many, while it runs, why
    {"gravity", kAcceleration, 3, true, "ten thousand times the earth's: past laboratory centrifuges"},
    {"body_force", kAcceleration, 3, true, "as gravity; a channel of 10 um needs 1e4 m/s^2 for 0.1 m/s of water"},
    {"numerics.support_over_spacing", {"", 1.8, 4}, 1, false, "fewer neighbours no longer add up to one, more only cost"},
    {"numerics.sound_speed", kSpeed, 1, false, "what single precision tells apart"},
    {"numerics.max_speed", kSpeed, 1, false, "what single precision tells apart"},
    {"numerics.artificial_viscosity", {"", 0, 1}, 1, true, "more damps all motion within a few sub-steps"},
    {"numerics.density_diffusion", {"", 0, 0.5}, 1, true, "more is unstable at the sub-step that is planned"},
    {"numerics.shift", {"", 0, 100}, 1, false, "more moves particles past where they would be even"},
    {"numerics.skin_over_spacing", {"", 0.02, 1}, 1, false, "less lists neighbours anew in each sub-step, more lists twice as many"},
    {"numerics.sleep_speed", {"m/s", 0, 1, true}, 1, false, "fluid in a hand's way is never slower than all that sleeps"},
    {"numerics.region_of_interest", {"m", 0, 1e6, true}, 1, false, "0 would leave nothing to compute"},
    {"numerics.safety", {"", 0.05, 1}, 1, false, "above 1 a sub-step is unstable, far below only slow"},
    {"stream.particle_rate_hz", {"Hz", 0, 1000}, 1, true, "0 sends none; nothing draws faster than steps are made"},
    {"stream.scalar", {}, 0, true, "a name: none, speed, density, pressure, temperature, density_error or state"},
    {"material.density", {"kg/m^3", 1e-6, 1e6}, 1, false, "from thin gas to past all matter on earth"},
    {"material.viscosity", {"Pa s", 0, 1e9}, 1, true, "pitch has 2e8 Pa s; more does not flow in a lifetime"},
    {"material.surface_tension", {"N/m", 0, 1e6}, 1, false, kOnlySign},
    {"material.adhesion", {"N/m", 0, 1e6}, 1, false, kOnlySign},
    {"material.young_modulus", {"Pa", 1e-6, 1e12}, 1, false, "diamond has 1.1e12 Pa"},
    {"material.poisson_ratio", {"", -0.9, 0.495}, 1, false, "at -1 and 0.5 a modulus is infinite"},
    {"material.damping", {"Pa s", 0, 1e9}, 1, false, "as viscosity"},
    {"material.yield_stress", {"Pa", 0, 1e12, true}, 1, false, "as young_modulus; 0 would be a fluid"},
    {"material.hardening", {"Pa", 0, 1e12}, 1, false, "as young_modulus"},
    {"material.tear_strain", {"", 0, 1000, true}, 1, false, "no matter stretches a thousandfold"},
    {"material.friction", {"", 0, 10}, 1, false, "gecko and rubber reach a few"},
    {"material.kinetic_friction", {"", 0, 10}, 1, false, "as friction"},
    {"material.restitution", {"", 0, 1}, 1, false, "a bounce gains no energy"},
    {"material.conductivity", {"W/(m K)", 0, 1e6}, 1, false, "graphene has 5e3; made-up matter may be a hundred times quicker"},
    {"material.heat_capacity", {"J/(kg K)", 0, 1e9, true}, 1, false, kOnlySign},
    {"material.latent_heat", {"J/kg", 0, 1e12, true}, 1, false, kOnlySign},
    {"material.cooking_time", {"s", 0, 1e9, true}, 1, false, "thirty years"},
};
// clang-format on

constexpr std::string_view kMaterial = "material.";

}  // namespace

const std::vector<ParameterRow>& parameter_rows() { return kParameters; }

const ParameterRow& parameter_row(std::string_view key) {
  for (const ParameterRow& row : kParameters) {
    if (row.key == key) return row;
  }
  throw std::logic_error("config/parameter_ranges.cpp has no row " + std::string(key));
}

std::vector<ChangeableParameter> changeable_parameters(const std::vector<std::string>& materials) {
  std::vector<ChangeableParameter> all;
  for (const ParameterRow& row : kParameters) {
    if (!row.while_running) continue;
    const std::string_view key = row.key;
    if (key.substr(0, kMaterial.size()) != kMaterial) {
      all.push_back({row.key, &row});
      continue;
    }
    for (const std::string& material : materials)
      all.push_back({fmt::format("{}{}.{}", kMaterial, material, key.substr(kMaterial.size())), &row});
  }
  return all;
}

std::vector<double> parse_parameter(const ParameterRow& row, const std::string& name, const std::string& value) {
  const auto fail = [&] {
    const std::string each = describe(row.range);
    throw ConfigError(fmt::format("parameter {} is '{}', expected {}", name, value.substr(0, 80),
                                  row.count == 1 ? each : fmt::format("{} numbers, each {}", row.count, each)));
  };
  std::vector<double> numbers;
  std::string_view rest = value;
  constexpr const char* kBlanks = " \t";
  while (rest.find_first_not_of(kBlanks) != std::string_view::npos) {
    rest.remove_prefix(rest.find_first_not_of(kBlanks));
    const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
    rest.remove_prefix(word.size());
    const auto number = parse_number(word);
    if (!number || !is_in(*number, row.range)) fail();
    numbers.push_back(*number);
  }
  if (numbers.size() != static_cast<std::size_t>(row.count)) fail();
  return numbers;
}

}  // namespace palp
