// Melting, freezing and setting: what bonds do, what is kept through a change, and what it costs.
#include <gtest/gtest.h>

#include "config/error.h"
#include "sim_server/state_change_plan.h"
#include "tests/support/backend.h"
#include "tests/support/random_scene.h"
#include "tests/support/tolerance.h"

namespace palp::testing {
namespace {

constexpr double kSpacing = 0.01;
constexpr double kMelting = 300;  // [K]
constexpr double kCapacity = 1000, kLatent = 2000;

// Stuff that melts; weightless unless a test says otherwise. Conducts so little that every particle keeps what it gets.
Scene melting_scene(double young = 2e4) {
  Scene scene = empty_scene(kSpacing, {-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3});
  scene.config.gravity.setZero();
  scene.config.numerics.max_speed = 1;
  scene.config.numerics.tension = false;
  add_material(scene, 1000, 0.1);
  MaterialConfig& m = scene.config.materials[0];
  m.young_modulus = young;
  m.damping = 1;
  m.conductivity = 1e-6;
  m.heat_capacity = kCapacity;
  m.melting_temperature = kMelting;
  m.latent_heat = kLatent;
  return scene;
}

// Over the whole scene, between two times [s]: as much as melts (freezes, when negative) so many kg.
void add_heat(Scene& scene, double kg, double start, double end) {
  HeatZoneConfig zone;
  zone.name = std::to_string(scene.config.heat_zones.size());
  zone.position.setZero();
  zone.size.setConstant(2);
  zone.power = kg * kLatent / (end - start);
  zone.start = start;
  zone.end = end;
  scene.config.heat_zones.push_back(zone);
}

double mass_of(const Scene& scene) { return 1000 * scene.volume[0] * static_cast<double>(scene.position.size()); }

struct Motion {
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero(), spin = momentum;
  double kinetic = 0;
};

Motion motion_of(const Scene& scene, const Snapshot& s) {
  Motion sum;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const double m = 1000 * scene.volume[i];
    const Eigen::Vector3d x = Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>();
    const Eigen::Vector3d v = Eigen::Map<const Eigen::Vector3f>(&s.velocity[3 * i]).cast<double>();
    sum.momentum += m * v;
    sum.spin += m * x.cross(v);
    sum.kinetic += 0.5 * m * v.squaredNorm();
  }
  return sum;
}

Snapshot snapshot_of(Simulation& simulation) {
  Snapshot s;
  simulation.snapshot(s);
  return s;
}

void run_until(Simulation& simulation, double time) {
  while (simulation.output().time < time - 1e-9) ASSERT_TRUE(simulation.step({}).health.ok);
}

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

// How high the stuff reaches.
double top_of(const Snapshot& s) {
  float top = -1e30f;
  for (std::size_t i = 2; i < s.position.size(); i += 3) top = std::max(top, s.position[i]);
  return top;
}

Scene on_a_floor(BodyType type, double temperature) {
  Scene scene = melting_scene();
  scene.config.gravity = {0, 0, -9.81};
  scene.config.numerics.max_speed.reset();
  add_material(scene, 1000, 0.1);
  scene.config.materials[1].heat_capacity = kCapacity;
  add_body(scene, "floor", BodyType::fixed, 1, {-0.15, -0.15, -0.03}, {0.15, 0.15, 0});
  add_body(scene, "stuff", type, 0, {-0.03, -0.03, 0}, {0.03, 0.03, 0.06});
  for (const std::uint32_t b : scene.body) scene.temperature.push_back(b == 0 ? kMelting : temperature);
  return scene;
}

TEST(StateChange, StandsUntilItMelts) {
  Scene scene = on_a_floor(BodyType::elastic, kMelting - 1);
  add_heat(scene, 20 * mass_of(scene), 0.3, 0.5);
  const auto simulation = simulate(scene);
  run_until(*simulation, 0.3);
  EXPECT_NEAR(top_of(snapshot_of(*simulation)), 0.055, 0.003);
  run_until(*simulation, 0.8);
  EXPECT_LT(top_of(snapshot_of(*simulation)), 0.025);
}

// What freezes keeps the shape that it has then, and rests in it: bonds form without strain.
TEST(StateChange, WhatFreezesRestsAsItIs) {
  Scene scene = on_a_floor(BodyType::fluid, kMelting + 0.5);
  scene.config.materials[0].young_modulus = 1e5;
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

// A splash that freezes at once, in all its disorder, as stiff stuff: the sub-step is short enough.
TEST(StateChange, ASplashThatFreezesHolds) {
  for (const double support : {2.0, 3.0})
    for (const double young : {1e4, 1e5, 1e6}) {
      Scene scene = on_a_floor(BodyType::fluid, kMelting + 0.5);
      scene.config.numerics.support_over_spacing = support;
      scene.config.materials[0].young_modulus = young;
      add_heat(scene, -20 * mass_of(scene), 0.1, 0.15);
      const auto simulation = simulate(scene);
      run_until(*simulation, 0.5);
      EXPECT_LT(motion_of(scene, snapshot_of(*simulation)).kinetic, 1e-3) << support << ", " << young;
    }
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

// A rod that is held in a fluid at rest feels its lift, and goes on feeling it, without a jump, while all around it
// freezes and melts again.
TEST(StateChange, AHandFeelsNoJump) {
  Scene scene = melting_scene(1e5);
  scene.config.numerics.support_over_spacing = 2;
  scene.config.gravity = {0, 0, -9.81};
  scene.config.numerics.max_speed.reset();
  add_material(scene, 1000, 0.1);
  scene.config.materials[1].heat_capacity = kCapacity;
  add_tray(scene, 1, {-0.06, -0.06, 0}, {0.06, 0.06, 0.08}, 0.03);
  const auto in_rod = [](const Eigen::Vector3d& x) {
    return std::abs(x.x()) < 0.015 && std::abs(x.y()) < 0.015 && x.z() > 0.025 && x.z() < 0.055;
  };
  add_body(scene, "stuff", BodyType::fluid, 0, {-0.06, -0.06, 0}, {0.06, 0.06, 0.08},
           [&](const Eigen::Vector3d& x) { return !in_rod(x); });
  const auto rod = add_body(scene, "rod", BodyType::fixed, 1, {-0.02, -0.02, 0.02}, {0.02, 0.02, 0.06}, in_rod);
  scene.temperature.assign(scene.position.size(), kMelting + 0.5);
  ProbeConfig probe;
  probe.quantity = Quantity::body;
  probe.body = "rod";
  scene.config.probes.push_back(probe);
  const double mass = mass_of(scene);
  add_heat(scene, -2 * mass, 1, 1.5);
  add_heat(scene, 2 * mass, 2, 2.5);
  const auto simulation = simulate(scene);
  const double lift = 1000 * 9.81 * scene.bodies[rod].volume;
  double jitter = 0, jump = 0, before = 0, most = 0;
  for (int k = 0; k < 3000; ++k) {
    ASSERT_TRUE(simulation->step({}).health.ok);
    const double force = simulation->output().bodies[rod].force.z();
    if (k >= 900) {
      double& largest = k < 1000 ? jitter : jump;
      largest = std::max(largest, std::abs(force - before));
      most = std::max(most, std::abs(force - lift));
    }
    before = force;
  }
  RecordProperty("jump_over_lift", std::to_string(jump / lift));
  RecordProperty("jitter_over_lift", std::to_string(jitter / lift));
  RecordProperty("most_over_lift", std::to_string(most / lift));
  EXPECT_TRUE(within(jump / lift, tol::kChangeJump));
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
