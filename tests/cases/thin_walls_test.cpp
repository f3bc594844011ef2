// Walls much thinner than a spacing keep fluids apart, and feel them from either side.
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/change_scenes.h"
#include "tests/support/scene_builder.h"
#include "tests/support/tolerance.h"

namespace palp::test::thin_walls_test {
namespace {

constexpr double kSpacing = 0.01, kWall = 0.001;

SceneConfig empty() {
  SceneConfig config = scene(kSpacing);
  config.materials[0].density = 1000;
  config.materials[0].viscosity = 1e-3;
  config.gravity = {0, 0, -9.81};
  config.domain_min = {-0.15, -0.15, -0.05};
  config.domain_max = {0.15, 0.15, 0.2};
  return config;
}

void probe(SceneConfig& config, const std::string& body) {
  ProbeConfig probe;
  probe.name = probe.body = body;
  probe.quantity = Quantity::body;
  config.probes.push_back(probe);
}

// Runs for a second and adds up the forces on bodies over its last quarter.
struct Played {
  Scene scene;
  std::unique_ptr<Simulation> simulation;
  std::vector<Eigen::Vector3d> force;

  explicit Played(const SceneConfig& config) : scene(sample_scene(config, 100000)), simulation(simulate(scene)) {
    constexpr int kSteps = 1000, kMean = 250;
    force.assign(scene.bodies.size(), Eigen::Vector3d::Zero());
    for (int k = 0; k < kSteps; ++k) {
      const StepOutput& out = simulation->step({});
      if (k < kSteps - kMean) continue;
      for (std::size_t b = 0; b < force.size(); ++b) force[b] += out.bodies[b].force / kMean;
    }
  }
  double weight(std::size_t body) const { return scene.bodies[body].mass * 9.81; }
};

TEST(ThinWalls, AGlassOfAMillimetreHoldsWater) {
  SceneConfig config = empty();
  BodyConfig glass = body("glass", BodyKind::fixed, cylinder_between(0.04 + kWall, -kWall, 0.12));
  glass.shapes.push_back(cut(cylinder_between(0.04, 0, 0.13)));
  config.bodies = {glass, body("water", BodyKind::fluid, cylinder_between(0.04, 0, 0.08))};
  probe(config, "glass");
  const Played run(config);
  EXPECT_EQ(run.scene.bodies[0].count, 0u);
  ASSERT_TRUE(run.simulation->output().health.ok) << run.simulation->output().health.cause;
  EXPECT_EQ(run.simulation->output().health.outside, 0u);
  const Snapshot s = snapshot_of(*run.simulation);
  for (std::size_t i = 0; i < run.scene.position.size(); ++i) {
    EXPECT_LT(std::hypot(s.position[3 * i], s.position[3 * i + 1]), 0.04) << i;
    EXPECT_GT(s.position[3 * i + 2], 0) << i;
  }
  double held = 0;
  for (std::size_t i = 0; i < run.scene.position.size(); ++i) held += 1000 * run.scene.volume[i] * 9.81;
  EXPECT_TRUE(within(-run.force[0].z() / held - 1, tol::kWallForce));
}

// A sheet of a fiftieth of a spacing between water of two depths: without a line of sight that it blocks, the two would
// push each other through it.
TEST(ThinWalls, ASheetKeepsTwoLevelsApart) {
  constexpr double kDeep = 0.12, kShallow = 0.06, kHalf = 0.0001, kRoom = 0.1, kWide = 0.1;
  SceneConfig config = empty();
  BodyConfig tank =
      body("tank", BodyKind::fixed, box({2 * kRoom + 2 * kWall, kWide + 2 * kWall, 0.16}, {0, 0, 0.08 - kWall}));
  tank.shapes.push_back(cut(box({2 * kRoom, kWide, 0.2}, {0, 0, 0.1})));
  const auto water = [&](const char* name, double from, double to, double depth) {
    return body(name, BodyKind::fluid, box({to - from, kWide, depth}, {(from + to) / 2, 0, depth / 2}));
  };
  config.bodies = {tank, body("sheet", BodyKind::fixed, box({2 * kHalf, kWide, 0.16}, {0, 0, 0.08})),
                   water("left", -kRoom, -kHalf, kDeep), water("right", kHalf, kRoom, kShallow)};
  probe(config, "sheet");
  probe(config, "tank");
  const Played run(config);
  ASSERT_TRUE(run.simulation->output().health.ok) << run.simulation->output().health.cause;
  EXPECT_EQ(run.simulation->output().health.outside, 0u);
  const Snapshot s = snapshot_of(*run.simulation);
  double top[2] = {0, 0};
  for (std::size_t i = run.scene.bodies[2].first; i < run.scene.position.size(); ++i) {
    const bool left = run.scene.body[i] == 2;
    EXPECT_EQ(s.position[3 * i] < 0, left) << i;
    top[left ? 0 : 1] = std::max(top[left ? 0 : 1], double(s.position[3 * i + 2]));
  }
  EXPECT_NEAR(top[0], kDeep - kSpacing / 2, kSpacing / 4);
  EXPECT_NEAR(top[1], kShallow - kSpacing / 2, kSpacing / 4);
  EXPECT_TRUE(within(-run.force[0].z() / (run.weight(2) + run.weight(3)) - 1, tol::kWallForce));
  const double push = 0.5 * 1000 * 9.81 * kWide * (kDeep * kDeep - kShallow * kShallow);
  EXPECT_TRUE(within(run.force[1].x() / push - 1, tol::kThinWallForce));
  EXPECT_TRUE(within((run.force[0].x() + run.force[1].x()) / push, tol::kWallForce)) << "what rests pushes nowhere";
}

}  // namespace
}  // namespace palp::test::thin_walls_test
