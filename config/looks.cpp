#include "config/looks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "config/error.h"
#include "config/srgb.h"

namespace palp {
namespace {

using Rgb = std::array<float, 3>;

constexpr Rgb rgb(unsigned hex) {
  return {static_cast<float>(hex >> 16 & 255) / 255, static_cast<float>(hex >> 8 & 255) / 255,
          static_cast<float>(hex & 255) / 255};
}

// Light that is not scattered within any scene.
constexpr float kFar = kMostScatteringLength;
constexpr float kDyedScattering = 0.15f;  // [m], of what is clear and has a colour of its own

struct Row {
  std::string_view name;
  Rgb color;  // of what is clear: what white light becomes over kColorDepth, for legends
  Look look;
};

// Refractive indices at 589 nm: water, ice, oil, honey, glasses and plastics from tables of physics and of food; those
// of metals change nothing, as a metal reflects in its colour. Absorption of water after Pope
// and Fry (1997) at 650, 550 and 450 nm; that of oil and honey such that a spoonful (1 cm) of oil is straw and one of
// honey amber. Scattering lengths: milk and batter as reduced ones of milk (about 1 mm, Narasimhan et al. 2006), fat
// and chocolate shorter, jelly so that one sees through a finger's breadth. Colours of metals are their reflectance at
// normal incidence.
// clang-format off
constexpr Row kLooks[] = {
    // name         colour                  clear  rough   metal  index  absorption [1/m]      scattering [m]  grain
    {"water",     rgb(0xf6fbff),          {true,  0.03f,  0, 1.333f, {0.34f, 0.057f, 0.010f}, kFar,   0}},
    {"juice",     rgb(0xf0962a),          {true,  0.04f,  0, 1.35f,  {3, 18, 75},             0.012f, 0}},
    {"oil",       rgb(0xf4e09a),          {true,  0.03f,  0, 1.47f,  {2, 5, 22},              kFar,   0}},
    {"honey",     rgb(0xd07a10),          {true,  0.04f,  0, 1.49f,  {6, 26, 130},            0.15f,  0}},
    {"syrup",     rgb(0x8a3a0c),          {true,  0.04f,  0, 1.48f,  {18, 60, 140},           kFar,   0}},
    {"jelly",     rgb(0xd0302a),          {true,  0.06f,  0, 1.35f,  {4, 48, 55},             0.03f,  0}},
    {"ice",       rgb(0xdceffa),          {true,  0.12f,  0, 1.31f,  {2.2f, 0.9f, 0.5f},      0.025f, 0}},
    {"glass",     rgb(0xd4ece4),          {true,  0.02f,  0, 1.52f,  {6, 2.5f, 4},            kFar,   0}},
    {"milk",      rgb(0xfdfaf0),          {false, 0.08f,  0, 1.35f,  {},                      2e-3f,  0}},
    {"cream",     rgb(0xfbf2dc),          {false, 0.14f,  0, 1.40f,  {},                      1.5e-3f, 0}},
    {"batter",    rgb(0xf2dc9c),          {false, 0.22f,  0, 1.40f,  {},                      2e-3f,  0}},
    {"custard",   rgb(0xf4d878),          {false, 0.18f,  0, 1.38f,  {},                      4e-3f,  0}},
    {"butter",    rgb(0xf2d468),          {false, 0.26f,  0, 1.46f,  {},                      3e-3f,  0}},
    {"chocolate", rgb(0x4a2614),          {false, 0.16f,  0, 1.50f,  {},                      0.3e-3f, 0}},
    {"dough",     rgb(0xe8cf9a),          {false, 0.62f,  0, 1.40f,  {},                      2e-3f,  0}},
    {"paste",     rgb(0xc8603a),          {false, 0.30f,  0, 1.42f,  {},                      1e-3f,  0}},
    {"crepe",     rgb(0xb87f3c),          {false, 0.42f,  0, 1.42f,  {},                      0.8e-3f, 0}},
    {"china",     rgb(0xf2eee4),          {false, 0.10f,  0, 1.55f,  {},                      0.5e-3f, 0}},
    {"stone",     rgb(0x8a8a86),          {false, 0.80f,  0, 1.55f,  {},                      0,      0}},
    {"wood",      rgb(0xb5793a),          {false, 0.48f,  0, 1.53f,  {},                      0,      0.4f}},
    {"plastic",   rgb(0x3f7ad0),          {false, 0.30f,  0, 1.49f,  {},                      0.2e-3f, 0}},
    {"rubber",    rgb(0x3c3c3e),          {false, 0.70f,  0, 1.52f,  {},                      0,      0}},
    {"steel",     rgb(0xc4c7ca),          {false, 0.25f,  1, 2.5f,   {},                      0,      0}},
    {"iron",      rgb(0x60646a),          {false, 0.42f,  1, 2.9f,   {},                      0,      0}},
    {"aluminium", rgb(0xe6e7e9),          {false, 0.34f,  1, 1.4f,   {},                      0,      0}},
    {"copper",    rgb(0xf0a98c),          {false, 0.24f,  1, 1.1f,   {},                      0,      0}},
};
// clang-format on

const Row* row_of(std::string_view name) {
  const auto* found = std::ranges::find(kLooks, name, &Row::name);
  return found == std::end(kLooks) ? nullptr : found;
}

std::optional<float> number(TomlTable& table, const char* key, const Range& range) {
  const auto value = table.number(key, range);
  return value ? std::optional(static_cast<float>(*value)) : std::nullopt;
}

constexpr Range kShare{"", 0, 1};

LookConfig read_look_table(TomlTable table) {
  LookConfig look;
  const std::vector<std::string> names = look_names();
  if (const auto base = table.choice("base", names)) look.base = names[*base];
  look.color = table.color("color");
  look.clear = table.boolean("clear");
  look.roughness = number(table, "roughness", kShare);
  look.metallic = number(table, "metallic", kShare);
  look.refractive_index = number(table, "refractive_index", {"", 1, kMostRefractiveIndex});
  if (const auto a = table.numbers("absorption_per_m", 3, {"1/m", 0, kMostAbsorptionPerM}))
    look.absorption_per_m = Rgb{static_cast<float>((*a)[0]), static_cast<float>((*a)[1]), static_cast<float>((*a)[2])};
  look.scattering_length = number(table, "scattering_length", {"m", 0, kMostScatteringLength});
  look.grain = number(table, "grain", kShare);
  look.foam = number(table, "foam", kShare);
  return look;
}

bool changes_state(const MaterialConfig& m) { return m.melting_temperature || m.cooking_temperature; }

void apply(const LookConfig& said, Look& look) {
  look.clear = said.clear.value_or(look.clear);
  look.roughness = said.roughness.value_or(look.roughness);
  look.metallic = said.metallic.value_or(look.metallic);
  look.refractive_index = said.refractive_index.value_or(look.refractive_index);
  look.scattering_length = said.scattering_length.value_or(look.scattering_length);
  look.grain = said.grain.value_or(look.grain);
  look.foam = said.foam.value_or(look.foam);
}

// Returns how much foam follows from the physics: thin liquids catch air and let it go, thick ones hang together.
float usual_foam(BodyKind kind, const MaterialConfig& m) {
  constexpr double kThin = 0.005, kThick = 0.05;  // [Pa s]; water has 0.001, oil 0.05 and more
  if (kind != BodyKind::fluid || m.cooking_temperature) return 0;
  const double share = std::log(kThick / std::max(m.viscosity, kThin)) / std::log(kThick / kThin);
  return static_cast<float>(std::max(share, 0.0));
}

// Returns what follows from the physics: what sets browns, or turns white where it was clear; what freezes turns rough
// and hazy; what melts smooth and wet.
ColoredLook usual_changed_look(BodyKind kind, const MaterialConfig& m, ColoredLook look) {
  Look& l = look.look;
  if (kind == BodyKind::fluid && m.cooking_temperature) {
    if (!l.clear) return named_look("crepe");
    l.scattering_length = std::min(l.scattering_length, 2e-3f);
  } else if (kind == BodyKind::fluid) {
    l.roughness = std::max(l.roughness, l.clear ? 0.12f : 0.3f);
    if (l.clear) l.scattering_length = std::min(l.scattering_length, 0.025f);
  } else {
    l.roughness = std::min(l.roughness, l.clear ? 0.03f : 0.06f);
    l.scattering_length = l.clear ? kFar : 1.5f * l.scattering_length;
  }
  return look;
}

}  // namespace

std::optional<LookConfig> read_look(TomlTable& table, const char* key) {
  if (!table.has(key) || table.is_table(key)) {
    LookConfig look = read_look_table(table.table(key));
    return table.has(key) ? std::optional(look) : std::nullopt;
  }
  const std::vector<std::string> names = look_names();
  LookConfig look;
  if (const auto base = table.choice(key, names)) look.base = names[*base];
  return look;
}

void check_changed_look(const MaterialConfig& m) {
  if (!m.changed_look || changes_state(m)) return;
  throw ConfigError(
      fmt::format("{}: material '{}' has a changed_look and never changes state, expected a "
                  "melting_temperature or a cooking_temperature beside it",
                  m.where, m.name));
}

std::vector<std::string> look_names() {
  std::vector<std::string> names;
  for (const Row& row : kLooks) names.emplace_back(row.name);
  return names;
}

ColoredLook named_look(std::string_view name) {
  const Row* row = row_of(name);
  if (row == nullptr) throw std::logic_error(fmt::format("config/looks.cpp has no look '{}'", name));
  return {row->color, row->look};
}

std::string_view usual_look(BodyKind kind, const MaterialConfig& m) {
  if (kind == BodyKind::fluid) {
    if (m.cooking_temperature) return "batter";
    if (m.viscosity < 0.02) return "water";
    if (m.viscosity < 0.5) return "oil";
    return m.viscosity < 20 ? "honey" : "paste";
  }
  if (kind == BodyKind::elastic) {
    if (m.yield_stress) return "dough";
    if (m.melting_temperature) return *m.melting_temperature < 280 ? "ice" : "butter";
    if (m.young_modulus.value_or(0) < 2e5) return "jelly";
    return m.young_modulus.value_or(0) < 1e8 ? "rubber" : "plastic";
  }
  if (m.density >= 5000) return "steel";
  if (m.density >= 1500) return "stone";
  if (m.melting_temperature) return *m.melting_temperature < 280 ? "ice" : "plastic";
  return m.density >= 300 && m.density < 950 ? "wood" : "plastic";
}

std::array<float, 3> absorption_of(const Rgb& color) {
  // black would absorb without limit, and the least that a screen shows is as dark
  constexpr float kDarkest = 1.0f / 255;
  Rgb absorption{};
  for (std::size_t k = 0; k < 3; ++k)
    absorption[k] = -std::log(std::max(light_of_srgb(color[k]), kDarkest)) / kColorDepth;
  return absorption;
}

ColoredLook look_of(BodyKind kind, const MaterialConfig& material, const std::optional<LookConfig>& own_look,
                    const std::optional<Rgb>& own_color) {
  const LookConfig said = own_look ? *own_look : material.look.value_or(LookConfig{});
  const bool named = !said.base.empty();
  ColoredLook out = named_look(named ? said.base : usual_look(kind, material));
  Look& look = out.look;
  look.foam = usual_foam(kind, material);
  apply(said, look);

  const std::optional<Rgb> color = said.color ? said.color : own_color ? own_color : material.color;
  if (color) out.color = *color;
  if (!color && !named) out.color = kNoColor;
  if (!look.clear) {
    look.absorption_per_m = {};
  } else if (said.absorption_per_m) {
    look.absorption_per_m = *said.absorption_per_m;
  } else if (color || !named) {
    look.absorption_per_m = absorption_of(out.color);
    // what colours a liquid is seldom dissolved to the last grain
    if (!said.scattering_length) look.scattering_length = std::min(look.scattering_length, kDyedScattering);
  }
  return out;
}

ColoredLook changed_look_of(BodyKind kind, const MaterialConfig& material, const ColoredLook& own) {
  if (!changes_state(material)) return own;
  const LookConfig said = material.changed_look.value_or(LookConfig{});
  ColoredLook out = said.base.empty() ? usual_changed_look(kind, material, own) : named_look(said.base);
  out.look.foam = 0;
  apply(said, out.look);
  out.look.clear = own.look.clear;
  if (said.color) out.color = *said.color;
  if (!out.look.clear)
    out.look.absorption_per_m = {};
  else if (said.absorption_per_m || said.color)
    out.look.absorption_per_m = said.absorption_per_m.value_or(absorption_of(out.color));
  return out;
}

}  // namespace palp
