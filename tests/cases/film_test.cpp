// Films and drops on a thin table.
#include <gtest/gtest.h>

#include "tests/support/change_scenes.h"

namespace palp::test::film_test {
namespace {

// A lump of water splashes onto a table of two layers and spreads to a film of single particles, which stays on it.
// Until solids kept fluids out of the gaps between their particles, a third of it was below the table by then.
TEST(Film, StaysOnATableOfTwoLayers) {
  Scene scene = empty_scene(kSpacing, {-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2});
  scene.config.numerics.support_over_spacing = 3;
  scene.config.numerics.artificial_viscosity = 0.05;  // with less, more than half of it runs off the table in that time
  add_material(scene, 1000, 1e-3);
  add_body(scene, "table", BodyKind::fixed, 0, {-0.2, -0.2, -0.02}, {0.2, 0.2, 0});
  add_body(scene, "water", BodyKind::fluid, 0, {-0.022, -0.025, 0.04}, {0.028, 0.025, 0.09});
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (scene.body[i] == 1) scene.velocity[i] = {0.2, 0.1, -2};
  const auto simulation = simulate(scene);
  while (simulation->output().time < 1.5) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
  }
  const Snapshot s = snapshot_of(*simulation);
  std::uint32_t film = 0;
  for (std::size_t i = scene.bodies[1].first; i < scene.position.size(); ++i) {
    if (std::max(std::abs(s.position[3 * i]), std::abs(s.position[3 * i + 1])) > 0.19f) continue;  // ran off
    EXPECT_GT(s.position[3 * i + 2], -0.3 * kSpacing) << "particle " << i;
    ++film;
  }
  EXPECT_GT(film, scene.bodies[1].count / 2);
}

// The same, straight down onto a table as thin as a sheet, whose surface has no roughness that would hold what runs.
TEST(Film, StaysOnASheet) {
  const ByGeometry walls;
  Scene scene = empty_scene(kSpacing, {-0.4, -0.4, -0.2}, {0.4, 0.4, 0.2});
  scene.config.numerics.support_over_spacing = 3;
  scene.config.numerics.artificial_viscosity = 0.05;
  add_material(scene, 1000, 1e-3);
  add_body(scene, "table", BodyKind::fixed, 0, {-0.4, -0.4, -0.001}, {0.4, 0.4, 0});
  add_body(scene, "water", BodyKind::fluid, 0, {-0.025, -0.025, 0.04}, {0.025, 0.025, 0.09});
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (scene.body[i] == 1) scene.velocity[i] = {0, 0, -0.5};
  const auto simulation = simulate(scene);
  while (simulation->output().time < 0.5) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
  }
  const Snapshot s = snapshot_of(*simulation);
  double widest = 0;
  for (std::size_t i = scene.bodies[1].first; i < scene.position.size(); ++i) {
    if (std::max(std::abs(s.position[3 * i]), std::abs(s.position[3 * i + 1])) > 0.39f) continue;  // ran off
    EXPECT_GT(s.position[3 * i + 2], 0) << "particle " << i;
    widest = std::max<double>(widest, std::hypot(s.position[3 * i], s.position[3 * i + 1]));
  }
  EXPECT_GT(widest, 0.1) << "it has spread";
}

}  // namespace
}  // namespace palp::test::film_test
