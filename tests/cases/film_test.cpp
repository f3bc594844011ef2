// Films and drops on a thin table.
#include <gtest/gtest.h>

#include "tests/support/change_scenes.h"

namespace palp::test::film_test {
namespace {

// A table whose top is at z = 0, and a cube of water above it.
Scene water_above_a_table(double half, double thickness, const Eigen::Vector2d& corner) {
  Scene scene = empty_scene(kSpacing, {-half, -half, -0.2}, {half, half, 0.2});
  scene.config.numerics.support_over_spacing = 3;
  scene.config.numerics.artificial_viscosity = 0.05;
  add_material(scene, 1000, 1e-3);
  add_body(scene, "table", BodyKind::fixed, 0, {-half, -half, -thickness}, {half, half, 0});
  add_body(scene, "water", BodyKind::fluid, 0, {corner.x(), corner.y(), 0.04},
           {corner.x() + 0.05, corner.y() + 0.05, 0.09});
  return scene;
}

// Lets the water splash and returns it as it is then.
Snapshot splash(Scene& scene, const Eigen::Vector3d& velocity, double until) {
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (scene.body[i] == 1) scene.velocity[i] = velocity;
  const auto simulation = simulate(scene);
  while (simulation->output().time < until) {
    const StepOutput& out = simulation->step({});
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) break;
  }
  return snapshot_of(*simulation);
}

bool ran_off(const Snapshot& s, std::size_t i, float half) {
  return std::max(std::abs(s.position[3 * i]), std::abs(s.position[3 * i + 1])) > half - 0.01f;
}

// A lump of water splashes onto a table of two layers and spreads to a film of single particles, which stays on it.
// Until solids kept fluids out of the gaps between their particles, a third of it was below the table by then. With
// less artificial viscosity more than half of it runs off the table in that time.
TEST(Film, StaysOnATableOfTwoLayers) {
  Scene scene = water_above_a_table(0.2, 0.02, {-0.022, -0.025});
  const Snapshot s = splash(scene, {0.2, 0.1, -2}, 1.5);
  std::uint32_t film = 0;
  for (std::size_t i = scene.bodies[1].first; i < scene.position.size(); ++i) {
    if (ran_off(s, i, 0.2f)) continue;
    EXPECT_GT(s.position[3 * i + 2], -0.3 * kSpacing) << "particle " << i;
    ++film;
  }
  EXPECT_GT(film, scene.bodies[1].count / 2);
}

// The same, straight down onto a table as thin as a sheet, whose surface has no roughness that would hold what runs.
TEST(Film, StaysOnASheet) {
  const ByGeometry walls;
  Scene scene = water_above_a_table(0.4, 0.001, {-0.025, -0.025});
  const Snapshot s = splash(scene, {0, 0, -0.5}, 0.5);
  double widest = 0;
  for (std::size_t i = scene.bodies[1].first; i < scene.position.size(); ++i) {
    if (ran_off(s, i, 0.4f)) continue;
    EXPECT_GT(s.position[3 * i + 2], 0) << "particle " << i;
    widest = std::max<double>(widest, std::hypot(s.position[3 * i], s.position[3 * i + 1]));
  }
  EXPECT_GT(widest, 0.1) << "it has spread";
}

}  // namespace
}  // namespace palp::test::film_test
