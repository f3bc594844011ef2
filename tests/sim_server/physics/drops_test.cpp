// Drops of one particle each, which no other particle feels.
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace palp::test::drops_test {
namespace {

constexpr double kSpacing = 0.01;
constexpr int kDropsAcross = 8;

// A sheet whose top is at z = 0, and drops above it, four spacings and more apart, that hit it with 0.8 to 2 m/s.
Scene rain_on_a_sheet(double viscosity, Random& random) {
  const ByGeometry walls;
  const double apart = 5 * kSpacing, half = 0.5 * kDropsAcross * apart;
  Scene scene = empty_scene(kSpacing, {-half - 0.1, -half - 0.1, -0.1}, {half + 0.1, half + 0.1, 0.2});
  scene.config.numerics.tension = false;
  scene.config.numerics.max_speed = 2;
  add_material(scene, 1000, viscosity);
  add_body(scene, "sheet", BodyKind::fixed, 0, {-half - 0.05, -half - 0.05, -0.001}, {half + 0.05, half + 0.05, 0});
  const std::uint32_t rain = add_body(scene, "rain", BodyKind::fluid, 0, {0, 0, 0},
                                      {kSpacing * kDropsAcross, kSpacing * kDropsAcross, kSpacing});
  const Body& body = scene.bodies[rain];
  for (std::uint32_t k = 0; k < body.count; ++k) {
    const std::uint32_t i = body.first + k, row = k / kDropsAcross, column = k % kDropsAcross;
    scene.position[i] = Eigen::Vector3d(apart * (row + 0.5) - half, apart * (column + 0.5) - half, 0.04) +
                        random_vector(random, 0.5 * kSpacing);
    scene.velocity[i] = {0, 0, -uniform(random, 0.05, 1.7)};
  }
  return scene;
}

// Nothing but its own surface takes the pressure from a drop that a fall has given it. Drops that kept it bounced
// without an end, and had more of it after each fall.
TEST(Drops, LieWhereTheyFall) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const double viscosity : {0.001, 1.0}) {
    SCOPED_TRACE("viscosity " + std::to_string(viscosity));
    const Scene scene = rain_on_a_sheet(viscosity, random);
    const auto simulation = simulate(scene);
    std::vector<float> fell(scene.position.size()), rose(scene.position.size());
    Snapshot s;
    while (simulation->output().time < 0.6) {
      simulation->step({});
      simulation->snapshot(s);
      for (std::size_t i = scene.bodies[1].first; i < scene.position.size(); ++i) {
        fell[i] = std::max(fell[i], -s.velocity[3 * i + 2]);
        rose[i] = std::max(rose[i], s.velocity[3 * i + 2]);
      }
    }
    for (std::size_t i = scene.bodies[1].first; i < scene.position.size(); ++i) {
      EXPECT_LT(rose[i], 0.05 * fell[i]) << "drop " << i << " bounces";
      EXPECT_GT(s.position[3 * i + 2], 0) << "drop " << i << " is in the sheet";
      EXPECT_LT(s.position[3 * i + 2], 0.6 * kSpacing) << "drop " << i << " hovers";
      EXPECT_LT(s.density[i], 1001) << "drop " << i;
    }
  }
}

}  // namespace
}  // namespace palp::test::drops_test
