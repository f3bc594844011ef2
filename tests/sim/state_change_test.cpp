// Melting, freezing and setting: what bonds do, what is kept through a change, and what it costs.
#include <gtest/gtest.h>

#include "config/error.h"
#include "sim_server/state_change_plan.h"
#include "tests/support/change_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/tolerance.h"

namespace palp::testing {
namespace {

// What is solid and stays so moves as an elastic body of the same stuff, which is another code (elastic.h).
TEST(StateChange, ASolidIsAnElasticBody) {
  Scene scene = melting_scene();
  scene.config.numerics.support_over_spacing = 2;
  add_body(scene, "block", BodyType::elastic, 0, {0, 0, 0}, {0.06, 0.05, 0.04});
  Random random(5);
  for (Eigen::Vector3d& v : scene.velocity) v = random_vector(random, 0.05);
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    scene.velocity[i] += Eigen::Vector3d(0, 0, 2).cross(scene.position[i]);
  scene.config.numerics.sub_steps = 4;
  Scene plain = scene;
  plain.config.materials[0].melting_temperature.reset();
  plain.config.materials[0].conductivity = 0;
  scene.temperature.assign(scene.position.size(), kMelting - 10);
  ASSERT_EQ(make_plan(scene).slots, 120u);
  ASSERT_EQ(make_plan(plain).elastic_count, 120u);
  const auto a = simulate(scene), b = simulate(plain);
  double moved = 0, apart = 0;
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(a->step({}).health.ok);
    ASSERT_TRUE(b->step({}).health.ok);
  }
  const Snapshot s = snapshot_of(*a), t = snapshot_of(*b);
  for (std::size_t i = 0; i < s.position.size(); ++i) {
    apart = std::max(apart, static_cast<double>(std::abs(s.position[i] - t.position[i])));
    moved = std::max(moved, std::abs(s.position[i] - scene.position[i / 3][static_cast<Eigen::Index>(i % 3)]));
  }
  ASSERT_GT(moved, kSpacing);
  EXPECT_TRUE(within(apart / kSpacing, tol::kBondedMotion));
}

// A lump that turns, flies and wobbles, and melts, freezes and melts again on the way.
TEST(StateChange, KeepsMomentumAndAddsNoEnergy) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  Scene scene = melting_scene();
  scene.config.materials[0].viscosity = 0;  // Morris's form is not central
  add_body(scene, "lump", BodyType::fluid, 0, {-0.04, -0.04, -0.04}, {0.04, 0.04, 0.04},
           [](const Eigen::Vector3d& x) { return x.norm() < 0.038; });
  const Eigen::Vector3d v = random_vector(random, 0.2), w = random_vector(random, 3);
  double scale = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    scene.velocity[i] = v + w.cross(scene.position[i]) + random_vector(random, 0.02);
    scale += 1000 * scene.volume[i] * scene.velocity[i].norm();
    scene.temperature.push_back(kMelting - uniform(random, 0.0, 0.5));
  }
  add_heat(scene, 1.5 * mass_of(scene), 0.1, 0.4);
  add_heat(scene, -2 * mass_of(scene), 0.4, 0.7);
  add_heat(scene, 2 * mass_of(scene), 0.7, 1);
  const auto simulation = simulate(scene);
  Snapshot s = snapshot_of(*simulation);
  const Motion start = motion_of(scene, s);
  double solid_before = 2, most = 0;
  int turns = 0;
  for (int k = 0; k < 1200; ++k) {
    ASSERT_TRUE(simulation->step({}).health.ok);
    if (k % 50 != 0) continue;
    s = snapshot_of(*simulation);
    double solid = 0;
    for (const float K : s.solid) solid += K / static_cast<double>(s.solid.size());
    turns += (solid < 0.01) != (solid_before < 0.01) ? 1 : 0;
    solid_before = solid;
    most = std::max(most, motion_of(scene, s).kinetic);
  }
  const Motion end = motion_of(scene, snapshot_of(*simulation));
  EXPECT_EQ(turns, 3) << "it melted, froze, melted";
  EXPECT_TRUE(within((end.momentum - start.momentum).norm() / scale, tol::kChangeMomentum));
  EXPECT_TRUE(within((end.spin - start.spin).norm() / (scale * 0.04), tol::kChangeMomentum));
  EXPECT_LE(most, start.kinetic * (1 + value_of(tol::kChangeEnergy)));
}

TEST(StateChange, WhatHasSetStaysSo) {
  Scene scene = on_a_floor(BodyType::fluid, 300);
  MaterialConfig& m = scene.config.materials[0];
  m.melting_temperature.reset();
  m.latent_heat = 0;
  m.cooking_temperature = 310;
  m.cooking_time = 0.1;
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (scene.body[i] == 1 && scene.position[i].x() > 0) scene.temperature[i] = 350;
  add_heat(scene, -10 * mass_of(scene), 0.3, 0.5);
  const auto simulation = simulate(scene);
  run_until(*simulation, 0.05);
  Snapshot s = snapshot_of(*simulation);
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    EXPECT_NEAR(s.solid[i], scene.body[i] == 1 && scene.position[i].x() > 0 ? 0.5 : 0, 1e-6);
  run_until(*simulation, 0.7);
  s = snapshot_of(*simulation);
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    if (scene.body[i] != 1) continue;
    EXPECT_LT(s.temperature[i], 345);
    EXPECT_EQ(s.solid[i], scene.position[i].x() > 0 ? 1 : 0);
  }
}

TEST(StateChange, WithAWrenchIsRefused) {
  Scene scene = on_a_floor(BodyType::elastic, kMelting - 1);
  ProbeConfig probe;
  probe.name = "p";
  probe.quantity = Quantity::body;
  probe.body = "stuff";
  scene.config.probes.push_back(probe);
  EXPECT_THROW(make_plan(scene), ConfigError);
}

TEST(Lightness, ChangeIsPaidForWhereItHappens) {
  Scene scene = on_a_floor(BodyType::fluid, kMelting + 1);
  Scene lasting = scene;
  lasting.config.materials[0].young_modulus.reset();
  const auto with = simulate(scene), without = simulate(lasting);
  for (int k = 0; k < 50; ++k) {
    with->step({});
    without->step({});
  }
  for (const auto& [name, bytes] : without->footprint().arrays) {
    EXPECT_EQ(name.find("change"), std::string::npos) << name;
    EXPECT_EQ(name.find("bond"), std::string::npos) << name;
    EXPECT_EQ(name.find("solid fraction"), std::string::npos) << name;
  }
  for (const std::string& name : without->footprint().launches) {
    EXPECT_EQ(name.find("bond"), std::string::npos) << name;
    EXPECT_EQ(name.find("fraction"), std::string::npos) << name;
  }
  const auto& launches = with->footprint().launches;
  EXPECT_NE(std::find(launches.begin(), launches.end(), "bonds"), launches.end());
}

}  // namespace
}  // namespace palp::testing
