// Matter at rest stays at rest: one scene of each kind. A minute where PALP_VALIDATE is set, else two seconds.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/backend.h"
#include "tests/support/change_scenes.h"
#include "tests/support/scene_files.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"
#include "tests/support/validation.h"

namespace palp::test::rest_test {
namespace {

using Eigen::Vector3d;

constexpr double kEdge = 0.06;

double settling_time() { return validating() ? 3 : 2; }
double resting_time() { return validating() ? 60 : 2; }

// A floor with a tray's walls where something could run off.
Scene on_floor(bool walls) {
  Scene scene = empty_scene(kSpacing, {-0.1, -0.1, -0.05}, {0.1, 0.1, 0.2});
  add_material(scene, 1000, 0.1);
  if (walls)
    add_tray(scene, 0, {-kEdge / 2, -kEdge / 2, 0}, {kEdge / 2, kEdge / 2, kEdge}, 0.02);
  else
    add_body(scene, "floor", BodyKind::fixed, 0, {-0.06, -0.06, -0.02}, {0.06, 0.06, 0});
  return scene;
}

Scene with_block(const std::function<void(MaterialConfig&)>& set) {
  Scene scene = on_floor(false);
  MaterialConfig& m = scene.config.materials[add_material(scene, 1000, 0.1)];
  m.young_modulus = 3e4;
  m.poisson_ratio = 0.4;
  m.damping = 20;
  set(m);
  add_body(scene, "block", BodyKind::elastic, 1, {-0.03, -0.03, 0}, {0.03, 0.03, 0.06});
  return scene;
}

Scene water(double viscosity) {
  Scene scene = on_floor(true);
  add_material(scene, 1000, viscosity);
  add_body(scene, "water", BodyKind::fluid, 1, {-kEdge / 2, -kEdge / 2, 0}, {kEdge / 2, kEdge / 2, 0.04});
  return scene;
}

// A lump of ice that lies on a floor, or was water there until the start.
Scene frozen(BodyKind type) {
  SceneConfig config = frozen_scene(0.3);
  config.bodies = {at_temperature(at(body("floor", BodyKind::fixed, box({0.2, 0.2, 0.02})), {0, 0, -0.01}), 280),
                   of_ice(at(body("ice", type, box({0.06, 0.06, 0.06})), {0, 0, 0.03}), 280)};
  return sampled(config);
}

struct Kind {
  const char* name;
  std::function<Scene()> make;
};

void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }

class Rest : public ::testing::TestWithParam<Kind> {};

TEST_P(Rest, KeepsItsPlaceAndGainsNoEnergy) {
  if (std::string(GetParam().name) == "water" && !validating())
    GTEST_SKIP() << "thin water in a box of six particles creeps: tools/validate shows how far";
  const Scene scene = GetParam().make();
  const auto simulation = simulate(scene);
  run_until(*simulation, settling_time());
  const Snapshot start = snapshot_of(*simulation);
  double first = 0, last = 0, first_time = 0;
  const double end = settling_time() + resting_time();
  // the mean kinetic energy of the first second and of the last
  for (double from : {settling_time(), end - 1}) {
    run_until(*simulation, from);
    double sum = 0;
    for (int k = 0; k < 1000; ++k) sum += simulation->step({}).health.kinetic_energy / 1000;
    (first_time++ == 0 ? first : last) = sum;
  }
  const Snapshot now = snapshot_of(*simulation);
  double farthest = 0, mass = 0, fastest = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const auto at = [&](const std::vector<float>& v) { return Vector3d(v[3 * i], v[3 * i + 1], v[3 * i + 2]); };
    farthest = std::max(farthest, (at(now.position) - at(start.position)).norm());
    fastest = std::max(fastest, at(now.velocity).norm());
    mass += 1000 * scene.volume[i];
  }
  EXPECT_TRUE(within(farthest / scene.spacing, tol::kRestDrift,
                     {std::string(GetParam().name) + ", farthest particle in 60 s of rest", "0",
                      quantity(farthest / scene.spacing, "dx, ") + quantity(1e6 * fastest, "um/s at the end")}));
  // as fast as its whole mass would be with this energy
  EXPECT_LT(last, std::max(first, 1e-10 * mass));
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, Rest,
    ::testing::Values(Kind{"water", [] { return water(1e-3); }}, Kind{"batter", [] { return water(10); }},
                      Kind{"elastic", [] { return with_block([](MaterialConfig&) {}); }},
                      Kind{"dough", [] { return with_block([](MaterialConfig& m) { m.yield_stress = 1500; }); }},
                      Kind{"jelly", [] { return with_block([](MaterialConfig& m) { m.tear_strain = 0.3; }); }},
                      Kind{"ice", [] { return frozen(BodyKind::elastic); }},
                      Kind{"frozen_water", [] { return frozen(BodyKind::fluid); }},
                      Kind{"tray_elastic", [] { return scene_file("tray_elastic", Accuracy::fast, true); }},
                      Kind{"tray_rigid", [] { return scene_file("tray_rigid", Accuracy::fast, true); }},
                      Kind{"tray_fluid", [] { return scene_file("tray_fluid"); }}),
    [](const auto& kind) { return std::string(kind.param.name); });

// Numbers that fade out while a hand holds still make every sum of theirs slow on an Intel processor.
TEST(Rest, FadesToZeroAndNotThroughSubnormalNumbers) {
  if (tested_backend() == Backend::cuda) GTEST_SKIP() << "a GPU computes with subnormal numbers at full speed";
#if !defined(__SSE2__)
  GTEST_SKIP() << "subnormal numbers are left as they are";
#endif
  const Scene scene = scene_file("tray_rigid", Accuracy::fast);
  const auto simulation = simulate(scene);
  const Body& ladle = scene.bodies[scene.proxies[0].body];
  StepInput input;
  input[0].engaged = true;
  input[0].state.position = ladle.position + ladle.orientation * scene.proxies[0].handle;
  input[0].state.orientation = ladle.orientation;
  input[0].gains = scene.proxies[0].limit;
  for (int k = 0; k < 2000; ++k) {
    const RigidState& tool = simulation->step(input).proxies[0].state;
    for (int a = 0; a < 3; ++a)
      for (const double value : {tool.linear[a], tool.angular[a], tool.orientation.coeffs()[a]})
        ASSERT_NE(std::fpclassify(static_cast<float>(value)), FP_SUBNORMAL) << value << " in step " << k;
  }
}

}  // namespace
}  // namespace palp::test::rest_test
