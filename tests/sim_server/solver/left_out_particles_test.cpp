// Solids have no particles where nothing needs them, and everything comes out as if they had.
#include <gtest/gtest.h>

#include <algorithm>

#include "sim_server/scene/particle_reason.h"
#include "tests/support/backend.h"
#include "tests/support/scene_builder.h"

namespace palp::test::left_out_particles_test {
namespace {

constexpr double kSpacing = 0.05;

// A floor, a ball that falls on it and spins, and a proxy that device 0 moves against the ball.
SceneConfig bodies_alone() {
  SceneConfig config = scene(kSpacing);
  config.bodies.push_back(body("floor", BodyKind::fixed, box({1.6, 1.4, 0.1}, {0, 0, -0.75})));
  config.bodies.push_back(body("ball", BodyKind::rigid, sphere(0.2, {0, 0, -0.4})));
  config.bodies.back().angular_velocity = {3, 0, 1};
  config.bodies.push_back(body("tool", BodyKind::rigid, sphere(0.11, {-0.6, 0, -0.5})));
  ProxyConfig proxy;
  proxy.body = "tool";
  config.proxies.push_back(proxy);
  return config;
}

BodyConfig bar(const std::string& bonded_to) {
  BodyConfig bar = body("bar", BodyKind::elastic, box({0.3, 0.2, 0.2}, {0.45, 0.5, -0.6}));
  if (!bonded_to.empty()) bar.bonded_to = {bonded_to};
  return bar;
}

SceneConfig with_bar(const std::string& bonded_to) {
  SceneConfig config = bodies_alone();
  config.materials[0].young_modulus = 1e5;
  config.materials[0].poisson_ratio = 0.3;
  config.bodies.push_back(bar(bonded_to));
  return config;
}

SceneConfig with_water() {
  SceneConfig config = bodies_alone();
  config.bodies.push_back(body("water", BodyKind::fluid, box({0.3, 0.3, 0.2}, {0, 0, -0.02})));
  return config;
}

SceneConfig with_all(SceneConfig config) {
  config.numerics.solid_particles = true;
  return config;
}

// The wrenches on the hand and the states of the bodies along one path of the hand.
std::vector<StepOutput> played(const SceneConfig& config, int steps) {
  const auto simulation = simulate(sample_scene(config, 1000000));
  std::vector<StepOutput> out;
  StepInput input;
  for (int s = 0; s < steps; ++s) {
    const double t = s * 1e-3;
    input[0].engaged = true;
    input[0].state.position = {-0.6 + 1.5 * t, 0.02, -0.5 - 0.3 * t};
    input[0].state.linear = {1.5, 0, -0.3};
    input[0].gains = kDefaultGains;
    out.push_back(simulation->step(input));
  }
  return out;
}

void expect_same(const SceneConfig& config, int steps) {
  const std::vector<StepOutput> without = played(config, steps), with = played(with_all(config), steps);
  double largest = 0;
  for (std::size_t s = 0; s < without.size(); ++s) {
    ASSERT_TRUE(without[s].health.ok) << without[s].health.cause;
    ASSERT_EQ(without[s].proxies[0].force, with[s].proxies[0].force) << s;
    ASSERT_EQ(without[s].proxies[0].torque, with[s].proxies[0].torque) << s;
    for (std::size_t b = 0; b < without[s].bodies.size(); ++b)
      ASSERT_EQ(without[s].bodies[b].state.position, with[s].bodies[b].state.position) << s << " " << b;
    largest = std::max(largest, without[s].proxies[0].contact_force.norm());
  }
  EXPECT_GT(largest, 1) << "the hand has met nothing";
}

std::vector<ParticleReason> reasons(const Scene& scene) {
  std::vector<ParticleReason> out;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) out.push_back(particle_reason(scene, b));
  return out;
}

TEST(LeftOutParticles, BodiesAloneMoveWithoutThemAsWithThem) { expect_same(bodies_alone(), 300); }

TEST(LeftOutParticles, ElasticBodiesFeelTheSame) {
  expect_same(with_bar(""), 240);
  expect_same(with_bar("floor"), 240);
}

// The order of sums over a fluid's neighbours is another one, so that rounding grows in a splash.
TEST(LeftOutParticles, FluidsFeelTheSame) {
  const std::vector<StepOutput> without = played(with_water(), 240), with = played(with_all(with_water()), 240);
  for (std::size_t s = 0; s < without.size(); ++s) {
    ASSERT_TRUE(without[s].health.ok) << without[s].health.cause;
    for (std::size_t b = 0; b < without[s].bodies.size(); ++b)
      ASSERT_LT((without[s].bodies[b].state.position - with[s].bodies[b].state.position).norm(), 1e-3 * kSpacing);
  }
}

TEST(LeftOutParticles, ASceneOfBodiesAlonePaysForNone) {
  const Scene s = sample_scene(bodies_alone(), 1000000);
  EXPECT_EQ(s.position.size(), 0u);
  EXPECT_EQ(reasons(s), std::vector<ParticleReason>(3, ParticleReason::none));
  const auto simulation = simulate(s);
  const StepOutput out = simulation->step({});
  // mass and inertia are those of the solids
  const double mass = 500 * 4 * M_PI / 3 * std::pow(0.2, 3);
  EXPECT_NEAR(s.bodies[1].mass, mass, 1e-12 * mass);
  EXPECT_NEAR(s.bodies[1].inertia(0, 0), 0.4 * mass * 0.04, 1e-12 * mass);
  // a ball's spin makes its surface faster than its middle
  EXPECT_GT(out.health.max_speed, 0.4);
  for (const auto& [name, bytes] : simulation->footprint().arrays)
    for (const char* of_particles : {"state ", "sorted ", "solid ", "health parts"})
      EXPECT_FALSE(name.starts_with(of_particles)) << name;
  for (const std::string& name : simulation->footprint().launches)
    EXPECT_TRUE(name != "move" && name != "health" && name != "sort") << name;
  Snapshot snapshot;
  simulation->snapshot(snapshot);
  EXPECT_TRUE(snapshot.position.empty());
  EXPECT_TRUE(frame_of(*simulation, ScalarField::speed).position.empty());
}

TEST(LeftOutParticles, ABondedBodyKeepsThoseWithinReach) {
  const Scene all = sample_scene(with_all(with_bar("floor")), 1000000), s = sample_scene(with_bar("floor"), 1000000);
  EXPECT_EQ(particle_reason(s, 0), ParticleReason::bonded);
  EXPECT_EQ(particle_reason(s, 3), ParticleReason::matter);
  EXPECT_GT(s.bodies[0].count, 0u);
  EXPECT_LT(s.bodies[0].count, all.bodies[0].count / 2);
  EXPECT_EQ(s.bodies[0].sites, all.bodies[0].count);
  EXPECT_EQ(s.bodies[3].count, all.bodies[3].count);
}

TEST(LeftOutParticles, StayWhereSomethingNeedsThem) {
  const auto floor_of = [](const SceneConfig& config) {
    const Scene s = sample_scene(config, 1000000);
    EXPECT_EQ(s.bodies[0].count, s.bodies[0].sites);
    EXPECT_FALSE(s.left_out.has_value());
    return particle_reason(s, 0);
  };
  EXPECT_EQ(floor_of(with_all(bodies_alone())), ParticleReason::asked);
  SceneConfig config = bodies_alone();
  config.method = Method::paper;
  EXPECT_EQ(floor_of(config), ParticleReason::paper);
  EXPECT_EQ(particle_reason(sample_scene(with_water(), 1000000), 0), ParticleReason::none);
  config = with_water();
  config.materials[0].adhesion = 0.03;
  EXPECT_EQ(floor_of(config), ParticleReason::adhesion);
  config = bodies_alone();
  for (BodyConfig& each : config.bodies) each.temperature = 300;
  config.materials[0].conductivity = 1;
  EXPECT_EQ(floor_of(config), ParticleReason::temperature);
  config.materials[0].conductivity = 0;
  config.heat_zones.emplace_back();
  EXPECT_EQ(floor_of(config), ParticleReason::temperature);
}

// Heat meets by their geometry those solids whose temperature stays as it is.
TEST(LeftOutParticles, HeatNeedsThemWhereItFlowsOn) {
  SceneConfig config = with_water();
  for (BodyConfig& each : config.bodies) each.temperature = 300 + static_cast<double>(each.name.size());
  const auto count = [](const Scene& s) { return s.bodies[0].count + s.bodies[1].count + s.bodies[2].count; };
  const auto expect_none = [&] {
    const Scene s = sample_scene(config, 1000000);
    EXPECT_EQ(count(s), 0u);
    EXPECT_EQ(s.temperature, std::vector<double>(s.position.size(), 305));
    EXPECT_EQ(particle_reason(s, 0), ParticleReason::none);
  };
  expect_none();  // nothing conducts
  config.materials[0].conductivity = 1;
  for (BodyConfig& each : config.bodies) each.hold_temperature = each.type != BodyKind::fluid;
  expect_none();
  config.bodies[0].hold_temperature = false;
  const Scene s = sample_scene(config, 1000000);
  EXPECT_EQ(s.bodies[0].count, s.bodies[0].sites);
  EXPECT_EQ(count(s), s.bodies[0].count);
  EXPECT_EQ(s.temperature.size(), s.position.size());
  EXPECT_EQ(s.temperature.front(), 305);
}

// Matter that melts may freeze again to any place of a body that it is bonded to.
TEST(LeftOutParticles, WhatMeltsNeedsAllOfThem) {
  SceneConfig config = with_bar("floor");
  for (BodyConfig& each : config.bodies) each.temperature = 300;
  config.materials.push_back(config.materials[0]);
  config.materials[1].name = std::string("ice");
  config.materials[1].conductivity = 1;
  config.materials[1].melting_temperature = 310;
  config.materials[1].latent_heat = 1000;
  for (MaterialConfig& each : config.materials) each.heat_capacity = 1000;
  config.bodies.back().material = std::string("ice");
  const Scene s = sample_scene(config, 1000000);
  EXPECT_EQ(particle_reason(s, 0), ParticleReason::bonded);
  EXPECT_EQ(s.bodies[0].count, s.bodies[0].sites);
  EXPECT_EQ(s.bodies[1].count, 0u);
}

}  // namespace
}  // namespace palp::test::left_out_particles_test
