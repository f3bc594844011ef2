// Density diffusion where particles crowd.
#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scenes.h"

namespace palp::test::diffusion_test {
namespace {

// A torn film that runs along a wall has particles at less than half a spacing from one another, without a pressure
// that would part them. Diffusion then has eight times the weights of a lattice: a sub-step must not take a density
// past the mean of its neighbours', which swings ever farther until a pressure throws a particle off, at a third of c.
TEST(DensityDiffusion, LeavesACrowdBesideAWallCalm) {
  constexpr double dx = 0.02, crowded = 0.45, speed = 0.2;
  const ByGeometry walls;
  Scene scene = empty_scene(dx, {-0.5, -0.5, -0.2}, {0.5, 0.5, 0.5});
  scene.config.gravity.setZero();
  scene.config.numerics.tension = false;
  scene.config.numerics.max_speed = 2;
  add_material(scene, 1000, 0.001);
  add_body(scene, "floor", BodyKind::fixed, 0, {-0.4, -0.4, -0.06}, {0.4, 0.4, 0});
  const std::uint32_t water =
      add_body(scene, "water", BodyKind::fluid, 0, {-6 * dx, -6 * dx, 0}, {6 * dx, 6 * dx, 4 * dx});
  const Body& body = scene.bodies[water];
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
    scene.position[i] = crowded * scene.position[i] + Eigen::Vector3d(0, 0, 0.1 * dx);
    scene.velocity[i] = speed * Eigen::Vector3d(scene.position[i].x(), scene.position[i].y(), 0) / (6 * crowded * dx);
  }
  const auto simulation = simulate(scene);
  double fastest = 0;
  while (simulation->output().time < 0.1) fastest = std::max<double>(fastest, simulation->step({}).health.max_speed);
  EXPECT_LT(fastest, 3 * speed) << "thrown off";
}

}  // namespace
}  // namespace palp::test::diffusion_test
