// Melting and freezing under weight, in disorder and around a hand.
#include <gtest/gtest.h>

#include "tests/support/change_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::state_change_motion_test {
namespace {

// How high the stuff reaches.
double top_of(const Snapshot& s) {
  float top = -1e30f;
  for (std::size_t i = 2; i < s.position.size(); i += 3) top = std::max(top, s.position[i]);
  return top;
}

TEST(StateChange, StandsUntilItMelts) {
  Scene scene = on_a_floor(BodyKind::elastic, kMelting - 1);
  add_heat(scene, 20 * mass_of(scene), 0.3, 0.5);
  const auto simulation = simulate(scene);
  run_until(*simulation, 0.3);
  EXPECT_NEAR(top_of(snapshot_of(*simulation)), 0.055, 0.003);
  run_until(*simulation, 0.8);
  EXPECT_LT(top_of(snapshot_of(*simulation)), 0.025);
}

// Matter that freezes keeps the shape that it has then, and rests in it: bonds form without strain.
TEST(StateChange, WhatFreezesRestsAsItIs) {
  Scene scene = on_a_floor(BodyKind::fluid, kMelting + 0.5);
  scene.config.materials[0].damping = 30;
  add_heat(scene, -20 * mass_of(scene), 0, 0.05);
  const auto simulation = simulate(scene);
  run_until(*simulation, 0.1);
  const Snapshot frozen = snapshot_of(*simulation);
  for (std::size_t i = 0; i < scene.position.size(); ++i) ASSERT_EQ(frozen.solid[i], scene.body[i] == 1 ? 1 : 0) << i;
  run_until(*simulation, 0.6);
  const double settled = top_of(snapshot_of(*simulation));
  run_until(*simulation, 1.2);
  const Snapshot s = snapshot_of(*simulation);
  EXPECT_GT(settled, 0.025) << "flowed on";
  EXPECT_NEAR(top_of(s), settled, 0.05 * kSpacing);
  EXPECT_LT(motion_of(scene, s).kinetic, 1e-7);
}

// Kinetic and potential energy of what moves.
double energy_of(const Scene& scene, const Snapshot& s) {
  double sum = motion_of(scene, s).kinetic;
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (scene.body[i] == 1) sum += 1000 * scene.volume[i] * 9.81 * s.position[3 * i + 2];
  return sum;
}

bool is_frozen(const Scene& scene, const Snapshot& s) {
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (scene.body[i] == 1 && s.solid[i] < 1) return false;
  return true;
}

// A splash that freezes at once, in all its disorder, as stiff stuff, flies on, wobbles, bounces and gains no energy:
// the sub-step is short enough. Bonds form without strain, so what moves and lies high has all the energy at the moment
// in which the last particle freezes; later the strain of the wobble has its share.
TEST(StateChange, ASplashThatFreezesHolds) {
  for (const double support : {2.0, 3.0})
    for (const double young : {2e3, 1e4, 1e5}) {
      Scene scene = on_a_floor(BodyKind::fluid, kMelting + 0.5);
      scene.config.numerics.support_over_spacing = support;
      scene.config.materials[0].young_modulus = young;
      add_heat(scene, -20 * mass_of(scene), 0.1, 0.15);
      const auto simulation = simulate(scene);
      while (simulation->output().time < 0.15 && !is_frozen(scene, snapshot_of(*simulation)))
        run_until(*simulation, simulation->output().time + 1e-3);
      const double start = simulation->output().time, frozen = energy_of(scene, snapshot_of(*simulation));
      ASSERT_GT(start, 0.1);
      ASSERT_LT(start, 0.12);
      for (double time = start + 5e-3; time < 0.3; time += 5e-3) {
        run_until(*simulation, time);
        EXPECT_LT(energy_of(scene, snapshot_of(*simulation)), frozen) << support << ", " << young << ", " << time;
      }
    }
}

// A fluid freezes with particles at a fraction of a spacing from each other here and there. Damping takes energy from
// them, too, whatever share of the sub-step's limit it has.
TEST(StateChange, NeighborsThatFrozeTogetherStayCalm) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const double damping : {5, 7, 10, 14, 20, 28, 40}) {
    Scene scene = melting_scene();
    scene.config.materials[0].damping = damping;
    add_body(scene, "stuff", BodyKind::elastic, 0, {0, 0, 0}, {0.06, 0.06, 0.06});
    scene.temperature.assign(scene.position.size(), kMelting - 1);
    for (std::size_t i = 0; i < scene.position.size(); ++i) {
      if (i % 9 == 0) scene.position[i] = scene.position[i + 1] + random_vector(random, 0.2 * kSpacing);
      scene.velocity[i] = random_vector(random, 0.01);
    }
    const auto simulation = simulate(scene);
    const double start = motion_of(scene, snapshot_of(*simulation)).kinetic;
    for (double time = 0.005; time < 0.3; time += 0.005) {
      run_until(*simulation, time);
      ASSERT_LT(motion_of(scene, snapshot_of(*simulation)).kinetic, start) << "damping " << damping << ", " << time;
    }
  }
}

class HeldRod : public ::testing::TestWithParam<bool> {};

// A rod that is held in a fluid at rest feels its lift, and goes on feeling it, without a jump, while all around it
// freezes, becomes rigid where that is asked for, and melts again.
TEST_P(HeldRod, AHandFeelsNoJump) {
  Scene scene = melting_scene(1e5);
  if (GetParam()) scene.config.materials[0].rigid_below = kMelting - 0.75;
  scene.config.numerics.support_over_spacing = 2;
  scene.config.gravity = {0, 0, -9.81};
  scene.config.numerics.max_speed.reset();
  add_material(scene, 1000, 0.1);
  scene.config.materials[1].heat_capacity = kCapacity;
  add_tray(scene, 1, {-0.06, -0.06, 0}, {0.06, 0.06, 0.08}, 0.03);
  const auto in_rod = [](const Eigen::Vector3d& x) {
    return std::abs(x.x()) < 0.015 && std::abs(x.y()) < 0.015 && x.z() > 0.025 && x.z() < 0.055;
  };
  add_body(scene, "stuff", BodyKind::fluid, 0, {-0.06, -0.06, 0}, {0.06, 0.06, 0.08},
           [&](const Eigen::Vector3d& x) { return !in_rod(x); });
  const auto rod = add_body(scene, "rod", BodyKind::fixed, 1, {-0.02, -0.02, 0.02}, {0.02, 0.02, 0.06}, in_rod);
  scene.temperature.assign(scene.position.size(), kMelting + 0.5);
  scene.config.probes.push_back(probe_of("rod"));
  const double mass = mass_of(scene);
  add_heat(scene, -2 * mass, 0.7, 1.2);
  add_heat(scene, 2 * mass, 1.4, 1.9);
  const auto simulation = simulate(scene);
  const double lift = 1000 * 9.81 * scene.bodies[rod].volume;
  double jitter = 0, jump = 0, before = 0, most = 0;
  int rigid = 0;
  for (int k = 0; k < 2200; ++k) {
    ASSERT_TRUE(simulation->step({}).health.ok);
    const double force = simulation->output().bodies[rod].force.z();
    if (k >= 600) {
      double& largest = k < 700 ? jitter : jump;
      largest = std::max(largest, std::abs(force - before));
      most = std::max(most, std::abs(force - lift));
    }
    before = force;
    if (k % 50 != 0 || !GetParam()) continue;
    const Snapshot s = snapshot_of(*simulation);
    rigid += std::count(s.rigid.begin(), s.rigid.end(), 1) > 0 ? 1 : 0;
  }
  EXPECT_EQ(rigid > 5, GetParam());
  RecordProperty("jump_over_lift", std::to_string(jump / lift));
  RecordProperty("jitter_over_lift", std::to_string(jitter / lift));
  RecordProperty("most_over_lift", std::to_string(most / lift));
  EXPECT_TRUE(within(jump / lift, tol::kChangeJump));
}
INSTANTIATE_TEST_SUITE_P(StateChange, HeldRod, ::testing::Bool(),
                         [](const auto& param) { return param.param ? "Rigid" : "Elastic"; });

// A lump that turns, flies and wobbles, and melts, freezes and melts again on the way.
TEST(StateChange, KeepsMomentumAndAddsNoEnergy) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  Scene scene = melting_scene();
  scene.config.materials[0].viscosity = 0;  // Morris's form is not central
  add_body(scene, "lump", BodyKind::fluid, 0, {-0.04, -0.04, -0.04}, {0.04, 0.04, 0.04},
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

// Bonds reach two spacings, whatever the support radius of the fluid is: with more partners than a particle has room
// for, one side of a pair would know of bonds that the other one does not.
TEST(StateChange, BondsAreMutualWithAnySupport) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (const double support : {2.0, 3.0, 4.0})
    for (const Method method : {Method::accurate, Method::paper}) {
      SCOPED_TRACE(support);
      Random random(seed);
      Scene scene = melting_scene();
      scene.config.method = method;
      scene.config.numerics.support_over_spacing = support;
      add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, {0.06, 0.06, 0.06});
      scene.temperature.assign(scene.position.size(), kMelting - 10);
      double scale = 0;
      for (std::size_t i = 0; i < scene.position.size(); ++i) {
        scene.velocity[i] = random_vector(random, 0.05);
        scale += 1000 * scene.volume[i] * scene.velocity[i].norm();
      }
      const auto simulation = simulate(scene);
      const Motion start = motion_of(scene, snapshot_of(*simulation));
      for (int k = 0; k < 100; ++k) ASSERT_TRUE(simulation->step({}).health.ok);
      const Motion end = motion_of(scene, snapshot_of(*simulation));
      EXPECT_TRUE(within((end.momentum - start.momentum).norm() / scale, tol::kChangeMomentum));
      EXPECT_LE(end.kinetic, start.kinetic);
    }
}

TEST(StateChange, WhatHasSetStaysSo) {
  Scene scene = on_a_floor(BodyKind::fluid, 300);
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
  Frame frame = frame_of(*simulation, ScalarField::none);
  ASSERT_EQ(frame.solid.size(), s.solid.size());
  for (std::size_t i = 0; i < s.solid.size(); ++i) EXPECT_NEAR(frame.solid[i], 255 * s.solid[i], 0.51) << i;
  frame = frame_of(*simulation, ScalarField::state);
  ASSERT_EQ(frame.scalar.size(), s.solid.size());
  for (std::size_t i = 0; i < s.solid.size(); ++i) EXPECT_EQ(frame.scalar[i], scene.body[i] == 1 ? s.solid[i] : 1) << i;
  run_until(*simulation, 0.7);
  s = snapshot_of(*simulation);
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    if (scene.body[i] != 1) continue;
    EXPECT_LT(s.temperature[i], 345);
    EXPECT_EQ(s.solid[i], scene.position[i].x() > 0 ? 1 : 0);
  }
}

}  // namespace
}  // namespace palp::test::state_change_motion_test
