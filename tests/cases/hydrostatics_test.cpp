// A tank of fluid at rest (Adami, Hu & Adams 2012, section 6): pressure, wall force, speed and compression.
#include <gtest/gtest.h>

#include "sim_server/solver/plan.h"
#include "tests/support/backend.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::hydrostatics_test {
namespace {

constexpr double kDepth = 0.9, kSpacing = 0.075, kGravity = 1, kDensity = 1000;

struct TankCase {
  const char* name;
  double support_over_spacing;
  double gravity_ramp;  // [s]
  const char* title;    // in the table of tools/validate
  Method method = Method::accurate;
};
void PrintTo(const TankCase& c, std::ostream* out) { *out << c.name; }

// Quasi two-dimensional: periodic along y.
Scene tank(const TankCase& c) {
  constexpr double width = 1.5, wall = 3 * kSpacing, deep = 9 * kSpacing;
  Scene scene = empty_scene(kSpacing, {-wall, 0, -wall}, {width + wall, deep, 1.5});
  SceneConfig& config = scene.config;
  config.periodic = {false, true, false};
  config.gravity = {0, 0, -kGravity};
  config.gravity_ramp = c.gravity_ramp;
  config.rate_hz = 100;
  config.method = c.method;
  config.numerics.support_over_spacing = c.support_over_spacing;
  config.numerics.max_speed = std::sqrt(kGravity * kDepth);
  config.numerics.sound_speed = 10 * std::sqrt(kGravity * kDepth);
  const auto water = add_material(scene, kDensity, 0);
  const ByGeometry walls;
  add_body(scene, "water", BodyKind::fluid, water, {0, 0, 0}, {width, deep, kDepth});
  add_tray(scene, water, {0, 0, 0}, {width, deep, 1.05}, wall, {false, true, false});
  config.probes.push_back(probe_of("tray"));
  return scene;
}

constexpr const char* kTwice = "Eq. 2 takes half the gradient of pressure: a fluid at rest has twice rho g d";
constexpr const char* kSloshes =
    "neither density diffusion nor artificial viscosity: an inviscid fluid goes on sloshing";
constexpr const char* kSqueezed = "twice the pressure is twice the compression, and it sloshes";

class Tank : public ::testing::TestWithParam<TankCase> {};

TEST_P(Tank, ComesToRestWithTheHydrostaticPressure) {
  const Scene scene = tank(GetParam());
  const auto simulation = simulate(scene);
  constexpr int settle = 200, average = 80;  // two acoustic periods 4 H / c
  const StepOutput* out = nullptr;
  double force = 0, compression = 0;
  for (int k = 0; k < settle + average; ++k) {
    out = &simulation->step({});
    ASSERT_TRUE(out->health.ok) << out->health.cause;
    if (k >= settle) force += out->bodies[1].force.z() / average;
    compression = std::max(compression, out->health.max_compression);
  }
  Snapshot s;
  simulation->snapshot(s);
  double square = 0, weight = 0;
  const Body& water = scene.bodies[0];
  for (std::uint32_t i = water.first; i < water.first + water.count; ++i) {
    const double error = s.pressure[i] - kDensity * kGravity * (kDepth - s.position[3 * i + 2]);
    square += error * error / water.count;
  }
  // the mass that the solver gave the fluid: with pressure from the start it is compressed from the start
  weight = kGravity * kDensity * water.volume;
  if (GetParam().gravity_ramp == 0) {
    const double c = make_plan(scene).sound_speed;
    for (std::uint32_t i = water.first; i < water.first + water.count; ++i)
      weight += kGravity * scene.volume[i] * kDensity * kGravity * (kDepth - scene.position[i].z()) / (c * c);
  }
  const double bottom = kDensity * kGravity * kDepth;
  RecordProperty("profile_rms", std::to_string(std::sqrt(square) / bottom));
  RecordProperty("wall_force_error", std::to_string(-force / weight - 1));
  RecordProperty("speed", std::to_string(out->health.max_speed / std::sqrt(kGravity * kDepth)));
  const double speed = out->health.max_speed / std::sqrt(kGravity * kDepth);
  const auto row = [](const char* what, const char* reference, const std::string& result, const char* paper_is_off) {
    return ValidationCase{"D1 tank at rest, " + std::string(GetParam().title) + ": " + what, reference, result,
                          GetParam().method, paper_is_off};
  };
  EXPECT_TRUE(within(std::sqrt(square) / bottom, tol::kHydrostaticProfile,
                     row("pressure", "rho g (H - z), 900 Pa at the bottom (Adami 2012)",
                         quantity(std::sqrt(square), "Pa off, rms"), kTwice)));
  EXPECT_TRUE(
      within(-force / weight - 1, tol::kWallForce,
             row("force on the walls", ("weight, " + quantity(weight, "N")).c_str(), quantity(-force, "N"), nullptr)));
  EXPECT_TRUE(within(speed, tol::kRestingSpeed,
                     row("largest speed left", "0", quantity(1e3 * out->health.max_speed, "mm/s"), kSloshes)));
  EXPECT_TRUE(within(compression, tol::kCompression,
                     row("largest compression", "g H / c^2 = 1 %", quantity(100 * compression, "%"), kSqueezed)));
  EXPECT_EQ(out->health.outside, 0u);
}

std::vector<TankCase> tanks() {
  std::vector<TankCase> all{{"three_spacings_ramp", 3.0, 1.0, "H = 3 dx, gravity grown in"},
                            {"three_spacings_at_once", 3.0, 0.0, "H = 3 dx, gravity at once"},
                            {"two_spacings_ramp", 2.0, 1.0, "H = 2 dx, gravity grown in"}};
  if (methods().size() < 2) return all;
  all.push_back({"paper_three_spacings", 3.0, 1.0, "H = 3 dx, gravity grown in", Method::paper});
  all.push_back({"paper_two_spacings", 2.0, 1.0, "H = 2 dx, gravity grown in", Method::paper});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Supports, Tank, ::testing::ValuesIn(tanks()),
                         [](const auto& param) { return std::string(param.param.name); });

}  // namespace
}  // namespace palp::test::hydrostatics_test
