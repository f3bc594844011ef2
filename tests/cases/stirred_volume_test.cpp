// Water that is stirred for long keeps its volume: its density is integrated, and what that errs must not add up.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/change_scenes.h"
#include "tests/support/scene_files.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::stirred_volume_test {
namespace {

constexpr double kDepth = 0.12, kEdge = 0.2;

// Returns the mean height of the water over the tray's floor [m].
double mean_height(const Scene& scene, Simulation& simulation, std::uint32_t water) {
  const Snapshot now = snapshot_of(simulation);
  double sum = 0;
  const Body& body = scene.bodies[water];
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i) sum += now.position[3 * i + 2];
  return sum / body.count;
}

TEST(StirredVolume, StaysAsItWas) {
  const ByGeometry walls;
  Scene scene = empty_scene(0.02, {-0.2, -0.2, -0.1}, {0.2, 0.2, 0.5});
  add_material(scene, 1000, 0.01);
  add_tray(scene, 0, {-kEdge / 2, -kEdge / 2, 0}, {kEdge / 2, kEdge / 2, 0.3}, 0.06);
  const std::uint32_t water =
      add_body(scene, "water", BodyKind::fluid, 0, {-kEdge / 2, -kEdge / 2, 0}, {kEdge / 2, kEdge / 2, kDepth});
  const auto simulation = simulate(scene);
  run_until(*simulation, 2);
  const double before = mean_height(scene, *simulation, water);
  // a push of 3 m/s^2 that goes round once a second sloshes it along the walls
  for (int k = 0; k < 30 * 50; ++k) {
    const double angle = 2 * M_PI * k / 50.0;
    simulation->set_parameter("body_force",
                              std::to_string(3 * std::cos(angle)) + " " + std::to_string(3 * std::sin(angle)) + " 0");
    run_until(*simulation, 2 + (k + 1) / 50.0);
  }
  simulation->set_parameter("body_force", "0 0 0");
  run_until(*simulation, 36);
  const double after = mean_height(scene, *simulation, water);
  RecordProperty("swelling", std::to_string(after / before - 1));
  EXPECT_TRUE(within(after / before - 1, tol::kStirredVolume));
}

}  // namespace
}  // namespace palp::test::stirred_volume_test
