// Matter that leaves the domain: liquid becomes inactive, solids come to rest, and matter inside does not notice.
#include <gtest/gtest.h>

#include "tests/support/change_scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::outside_test {
namespace {

using Eigen::Vector3d;

// A shelf with water on it and more water beside it, which falls out of the domain's bottom within 0.2 s.
Scene spill(Method method) {
  Scene scene = empty_scene(kSpacing, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
  scene.config.method = method;
  add_material(scene, 1000, 0.1);
  add_body(scene, "shelf", BodyKind::fixed, 0, {-0.1, -0.05, -0.03}, {0, 0.05, 0});
  add_body(scene, "water", BodyKind::fluid, 0, {-0.08, -0.03, 0}, {0.06, 0.03, 0.03});
  return scene;
}

Vector3d place(const Snapshot& s, std::size_t i) {
  return Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>();
}

void run_to(Simulation& simulation, double time) {
  while (simulation.output().time < time) {
    const StepOutput& out = simulation.step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
  }
}

TEST(Outside, SpilledFluidIsLetGo) {
  for (const Method method : {Method::accurate, Method::paper}) {
    const Scene scene = spill(method);
    const auto simulation = simulate(scene), again = simulate(scene);
    run_to(*simulation, 1);
    const Snapshot early = snapshot_of(*simulation);
    run_to(*simulation, 2);
    const Snapshot s = snapshot_of(*simulation);
    const Health& health = simulation->output().health;
    std::uint32_t gone = 0;
    double mass = 0;
    for (std::size_t i = 0; i < s.inactive.size(); ++i) {
      if (early.inactive[i] != 0) {
        EXPECT_EQ(place(early, i), place(s, i)) << i;
        EXPECT_EQ(s.inactive[i], 1) << i;
      }
      if (s.inactive[i] == 0) {
        EXPECT_GT(place(s, i).z(), -0.2) << "particle " << i << " still falls";
        continue;
      }
      ++gone;
      mass += 1000 * scene.volume[i];
      EXPECT_EQ(scene.body[i], 1u);
      EXPECT_EQ(s.velocity[3 * i + 2], 0);
      EXPECT_EQ(s.pressure[i], 0);
    }
    EXPECT_GT(gone, scene.bodies[1].count / 4);
    EXPECT_TRUE(method == Method::paper || gone < scene.bodies[1].count);  // with "paper" all of it runs off
    EXPECT_EQ(health.inactive, gone);
    EXPECT_GE(health.outside, gone);
    EXPECT_NEAR(health.inactive_mass, mass, 0.01 * mass);  // compressed at the start
    run_to(*again, 2);
    EXPECT_EQ(snapshot_of(*again).position, s.position);
    simulation->reset();
    run_to(*simulation, 2);
    EXPECT_EQ(snapshot_of(*simulation).position, s.position) << "after a reset";
  }
}

// A stream that leaves sideways: what has not left keeps the sum of its momenta, of its neighbours that vanish it
// feels nothing.
TEST(Outside, WhatStaysKeepsItsMomentum) {
  Scene scene = empty_scene(kSpacing, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
  scene.config.gravity.setZero();
  scene.config.numerics.tension = false;
  scene.config.numerics.max_speed = 1;
  add_material(scene, 1000, 1);
  add_body(scene, "stream", BodyKind::fluid, 0, {-0.08, -0.03, -0.03}, {0.08, 0.03, 0.03});
  for (Vector3d& v : scene.velocity) v = {0.5, 0, 0};
  const auto simulation = simulate(scene);
  run_to(*simulation, 0.25);
  const Snapshot s = snapshot_of(*simulation);
  std::size_t gone = 0;
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < s.inactive.size(); ++i) {
    if (s.inactive[i] != 0)
      ++gone;
    else
      sum += Eigen::Map<const Eigen::Vector3f>(&s.velocity[3 * i]).cast<double>() - Vector3d(0.5, 0, 0);
  }
  EXPECT_GT(gone, s.inactive.size() / 3);
  EXPECT_LT(gone, s.inactive.size());
  EXPECT_LT(sum.norm(), 1e-3 * 0.5 * static_cast<double>(s.inactive.size() - gone));
}

// A splash that flies out over an open top comes back.
TEST(Outside, ASplashAboveTheDomainComesBack) {
  Scene scene = empty_scene(kSpacing, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
  add_material(scene, 1000, 0.1);
  add_body(scene, "drop", BodyKind::fluid, 0, {-0.02, -0.02, 0}, {0.02, 0.02, 0.04});
  for (Vector3d& v : scene.velocity) v = {0, 0, 2};
  const auto simulation = simulate(scene);
  run_to(*simulation, 0.2);
  EXPECT_GT(simulation->output().health.outside, 0u);
  EXPECT_GT(place(snapshot_of(*simulation), 0).z(), 0.15);
  run_to(*simulation, 0.4);
  EXPECT_EQ(simulation->output().health.inactive, 0u);
  EXPECT_LT(place(snapshot_of(*simulation), 0).z(), 0.1);
}

class Dropped : public ::testing::TestWithParam<BodyKind> {};

// A spoon that is dropped beside the table does not end the run, but comes to rest below it, in one piece.
TEST_P(Dropped, SolidsComeToRestOutside) {
  Scene scene = spill(Method::accurate);
  add_material(scene, 1200, 0);
  scene.config.materials[1].young_modulus = 3e4;
  scene.config.materials[1].poisson_ratio = 0.3;
  add_body(scene, "spoon", GetParam(), 1, {0.01, 0.05, 0.02}, {0.07, 0.07, 0.04});
  const auto simulation = simulate(scene);
  run_to(*simulation, 2.5);
  const BodyOutput& spoon = simulation->output().bodies[2];
  EXPECT_LT(spoon.state.position.z(), -0.2);
  EXPECT_GT(spoon.state.position.z(), -1.5);
  EXPECT_LT(spoon.state.linear.norm(), 1e-3);
  const Snapshot s = snapshot_of(*simulation);
  const std::uint32_t first = scene.bodies[2].first, last = first + scene.bodies[2].count - 1;
  EXPECT_NEAR((place(s, last) - place(s, first)).norm(), (scene.position[last] - scene.position[first]).norm(),
              0.1 * kSpacing);
}

INSTANTIATE_TEST_SUITE_P(Bodies, Dropped, ::testing::Values(BodyKind::rigid, BodyKind::elastic),
                         [](const auto& param) { return param.param == BodyKind::rigid ? "Rigid" : "Elastic"; });

// Frozen lumps come to rest as they are; what melts out there is let go.
TEST(Outside, FrozenMatterRestsUntilItMelts) {
  for (const bool rigid : {false, true}) {
    Scene scene = melting_scene();
    scene.config.gravity = {0, 0, -9.81};
    scene.config.numerics.max_speed = 2;
    scene.bounds_min.z() = scene.config.domain_min.z() = -0.1;
    if (rigid) scene.config.materials[0].rigid_below = kMelting - 0.5;
    add_body(scene, "lump", BodyKind::elastic, 0, {-0.02, -0.02, 0}, {0.02, 0.02, 0.03});
    scene.temperature.assign(scene.position.size(), kMelting - 1);
    add_heat(scene, 2 * mass_of(scene), 0.8, 0.9);
    scene.config.heat_zones.back().size.setConstant(10);
    const auto simulation = simulate(scene);
    run_to(*simulation, 0.8);
    EXPECT_EQ(simulation->output().health.inactive, 0u);
    const Snapshot frozen = snapshot_of(*simulation);
    const std::size_t first = 0, last = scene.position.size() - 1;
    EXPECT_LT(place(frozen, first).z(), -0.2);
    EXPECT_NEAR((place(frozen, last) - place(frozen, first)).norm(),
                (scene.position[last] - scene.position[first]).norm(), 0.1 * kSpacing);
    run_to(*simulation, 1.2);
    EXPECT_EQ(simulation->output().health.inactive, scene.position.size()) << rigid;
  }
}

}  // namespace
}  // namespace palp::test::outside_test
