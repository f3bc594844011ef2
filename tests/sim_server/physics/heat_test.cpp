// Heat's rules one by one: enthalpy, a step against its equation restated, what is kept, zones, and what it costs.
#include <gtest/gtest.h>

#include "config/error.h"
#include "sim_server/solver/heat_plan.h"
#include "tests/support/backend.h"
#include "tests/support/contents.h"
#include "tests/support/equations.h"
#include "tests/support/kernels.h"
#include "tests/support/random_scene.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::heat_test {
namespace {

// One of everything, each body of another conductivity, water melting in the middle of the temperatures.
Scene warm_scene(Random& random, std::array<bool, 3> periodic) {
  RandomSceneOptions options;
  options.periodic = periodic;
  Scene scene = random_scene(random, options);
  const double conductivity[4] = {150, 20, 0, 600};
  for (std::size_t m = 0; m < 4; ++m) {
    scene.config.materials[m].conductivity = conductivity[m];
    scene.config.materials[m].heat_capacity = uniform(random, 1, 2);
  }
  scene.config.materials[0].melting_temperature = 300;
  scene.config.materials[0].latent_heat = 5;
  scene.config.heat.rate_hz = scene.config.rate_hz;
  for (std::size_t i = 0; i < scene.position.size(); ++i) scene.temperature.push_back(uniform(random, 280, 320));
  return scene;
}

// From h's definition: warmed to T_m, melted, warmed on.
TEST(Enthalpy, FollowsTheThreeRanges) {
  const HeatMaterial m{1, 2000, 273, 3e5, 1000};
  EXPECT_NEAR(enthalpy_of(m, 263), -2e4, 1);
  EXPECT_NEAR(enthalpy_of(m, 283), 3.2e5, 1);
  EXPECT_NEAR(temperature_of(m, -2e4), 263, 1e-3);
  EXPECT_EQ(temperature_of(m, 0), 273);
  EXPECT_EQ(temperature_of(m, 3e5), 273);
  EXPECT_NEAR(temperature_of(m, 3.2e5), 283, 1e-3);
  EXPECT_EQ(liquid_fraction(m, -1), 0);
  EXPECT_NEAR(liquid_fraction(m, 1.5e5), 0.5, 1e-6);
  EXPECT_EQ(liquid_fraction(m, 4e5), 1);
  const HeatMaterial plain{1, 2000, 273, 0, 1000};
  EXPECT_NEAR(temperature_of(plain, enthalpy_of(plain, 350)), 350, 1e-3);
}

class HeatStep : public ::testing::TestWithParam<std::array<bool, 3>> {};

// m dh/dt = sum_j V_i V_j 4 k_i k_j / (k_i + k_j) F (T_j - T_i), every pair, in double; V at most that at rest.
TEST_P(HeatStep, HoldsOnRandomScenes) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  Scene scene = warm_scene(random, GetParam());
  scene.bodies[4].holds_temperature = true;
  const StepInput input = random_input(random, scene);
  Restated world = restate(scene);
  ASSERT_EQ(world.plan.heat_interval, 1);
  ASSERT_EQ(world.plan.heat_steps, 1);
  sub_step(world, input, world.plan.dt);  // for the volumes of the fluids
  const auto material = [&](std::size_t i) { return scene.config.materials[scene.bodies[scene.body[i]].material]; };
  const auto held = [&](std::size_t i) { return scene.bodies[scene.body[i]].holds_temperature; };
  const std::size_t n = scene.position.size();
  const auto volume = [&](std::size_t i) { return std::min(world.V[i], world.m[i] / material(i).density); };
  double moment = 0;  // of the kernel's gradient on a lattice
  for (int a = -4; a <= 4; ++a)
    for (int b = -4; b <= 4; ++b)
      for (int c = -4; c <= 4; ++c) {
        const Eigen::Vector3d x = scene.spacing * Eigen::Vector3d(a, b, c);
        moment -= std::pow(scene.spacing, 3) * fluid_gradient(x, world.plan.support, scene.spacing).x() * x.x();
      }
  std::vector<double> T(n), heat(n, 0.0);
  double T_scale = 0, heat_scale = 0;
  for (std::size_t i = 0; i < n; ++i) {
    T[i] = scene.temperature[i];
    if (held(i)) continue;
    const double k_i = material(i).conductivity;
    for (std::size_t j = 0; j < n; ++j) {
      Eigen::Vector3d d = scene.position[i] - scene.position[j];
      for (int a = 0; a < 3; ++a) {
        const double period = scene.bounds_max[a] - scene.bounds_min[a];
        if (scene.config.periodic[a]) d[a] -= period * std::round(d[a] / period);
      }
      if (i == j || d.norm() >= world.plan.support) continue;
      const double k_j = material(j).conductivity;
      const double k = held(j) ? 4 * k_i : k_i + k_j > 0 ? 4 * k_i * k_j / (k_i + k_j) : 0;
      const double F = -fluid_gradient(d, world.plan.support, scene.spacing).dot(d) / d.squaredNorm();
      heat[i] += world.plan.dt * volume(i) * volume(j) * k * F / moment * (scene.temperature[j] - scene.temperature[i]);
    }
    const MaterialConfig& m = material(i);
    const double from = m.melting_temperature.value_or(300), latent = m.melting_temperature ? m.latent_heat : 0;
    double h = m.heat_capacity * (T[i] - from) + (T[i] > from ? latent : 0) + heat[i] / world.m[i];
    h = h < 0 ? h : std::max(0.0, h - latent);
    T[i] = from + h / m.heat_capacity;
    T_scale = std::max(T_scale, std::abs(T[i] - scene.temperature[i]));
    heat_scale = std::max(heat_scale, std::abs(heat[i]));
  }
  ASSERT_GT(T_scale, 0.5);
  const auto simulation = simulate(scene);
  ASSERT_TRUE(simulation->step(input).health.ok);
  Snapshot s;
  simulation->snapshot(s);
  for (std::size_t i = 0; i < n; ++i) {
    ASSERT_TRUE(within((s.heat[i] - heat[i]) / heat_scale, tol::kFewSteps)) << i;
    ASSERT_TRUE(within((s.temperature[i] - T[i]) / 300, tol::kOneStep)) << i;
  }
}

// Nothing is lost, nothing is gained, and no particle gets colder than the coldest or hotter than the hottest.
TEST_P(HeatStep, KeepsHeatInAClosedScene) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const Scene scene = warm_scene(random, GetParam());
  const StepInput input = random_input(random, scene);
  const auto simulation = simulate(scene);
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(simulation->step(input).health.ok);
  Snapshot s;
  simulation->snapshot(s);
  double sum = 0, size = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    sum += s.heat[i];
    size += std::abs(s.heat[i]);
    EXPECT_GE(s.temperature[i], 280 - 1e-3);
    EXPECT_LE(s.temperature[i], 320 + 1e-3);
  }
  ASSERT_GT(size, 1e3);
  EXPECT_TRUE(within(sum / size, tol::kHeatKept));
}

INSTANTIATE_TEST_SUITE_P(Domains, HeatStep,
                         ::testing::Values(std::array<bool, 3>{false, false, false},
                                           std::array<bool, 3>{true, true, true}),
                         [](const auto& param) { return param.param[0] ? "periodic" : "closed"; });

Scene cold_block(BodyKind type = BodyKind::fixed) {
  Scene scene = empty_scene(0.1, {-1, -1, -1}, {1, 1, 1});
  scene.config.gravity.setZero();
  const auto stuff = add_material(scene, 1000, 0.1);
  scene.config.materials[stuff].conductivity = 1;
  scene.config.materials[stuff].heat_capacity = 10;
  add_body(scene, "block", type, stuff, {-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3});
  scene.temperature.assign(scene.position.size(), 300);
  return scene;
}

// Heat is computed only where temperatures differ.
Scene with_a_warm_particle(Scene scene) {
  scene.temperature[0] += 1;
  return scene;
}

HeatZoneConfig add_zone(Scene& scene, const Eigen::Vector3d& position, const Eigen::Vector3d& size) {
  HeatZoneConfig zone;
  zone.name = std::to_string(scene.config.heat_zones.size());
  zone.position = position;
  zone.size = size;
  scene.config.heat_zones.push_back(zone);
  return zone;
}

double heat_in(const Snapshot& s) {
  double sum = 0;
  for (const float q : s.heat) sum += q;
  return sum;
}

TEST(HeatZones, GiveTheirPowerWhileTheyAreOn) {
  Scene scene = cold_block();
  add_zone(scene, {-0.3, 0, 0}, {0.25, 2, 2});
  scene.config.heat_zones[0].power = 500;
  scene.config.heat_zones[0].start = 0.2;
  scene.config.heat_zones[0].end = 0.7;
  const auto simulation = simulate(scene);
  Snapshot s;
  while (simulation->output().time < 0.2 - 1e-9) simulation->step({});
  simulation->snapshot(s);
  EXPECT_EQ(heat_in(s), 0);
  while (simulation->output().time < 0.3 - 1e-9) simulation->step({});
  simulation->snapshot(s);
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    EXPECT_EQ(s.temperature[i] > 300.05, scene.position[i].x() < -0.2) << scene.position[i].transpose();
  while (simulation->output().time < 1 - 1e-9) simulation->step({});
  simulation->snapshot(s);
  EXPECT_TRUE(within(heat_in(s) / 250 - 1, tol::kHeatGiven));
}

TEST(HeatZones, HoldATemperature) {
  Scene scene = cold_block();
  add_zone(scene, {0, 0, 0.25}, {2, 2, 0.1});
  scene.config.heat_zones[0].temperature = 400;
  const auto simulation = simulate(scene);
  for (int k = 0; k < 200; ++k) simulation->step({});
  Snapshot s;
  simulation->snapshot(s);
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    if (scene.position[i].z() > 0.2)
      EXPECT_NEAR(s.temperature[i], 400, 0.05);
    else
      EXPECT_LT(s.temperature[i], 399);
  }
}

// A box that a turned, turning and moving body carries along heats the same particles all the way.
TEST(HeatZones, MoveWithTheirBody) {
  Scene scene = cold_block(BodyKind::rigid);
  Body& body = scene.bodies[0];
  scene.config.materials[0].conductivity = 0;
  scene.config.periodic = {true, false, false};
  add_zone(scene, {0.25, 0.25, 0}, {0.1, 0.1, 2});
  scene.config.heat_zones[0].body = body.name;
  scene.config.heat_zones[0].power = 100;
  body.velocity = {1.5, 0, 0};
  body.angular_velocity = {0, 0, 2};
  const auto simulation = simulate(scene);
  for (int k = 0; k < 2500; ++k) ASSERT_TRUE(simulation->step({}).health.ok);
  Snapshot s;
  simulation->snapshot(s);
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    EXPECT_EQ(s.heat[i] > 0, scene.position[i].x() > 0.2 && scene.position[i].y() > 0.2) << i;
  EXPECT_TRUE(within(heat_in(s) / 250 - 1, tol::kHeatGiven));
}

TEST(Heat, RunsNoOftenerThanItNeeds) {
  const Plan slow = make_plan(with_a_warm_particle(cold_block()));
  EXPECT_EQ(slow.heat_interval, 50);
  EXPECT_EQ(slow.heat_steps, 1);
  Scene scene = with_a_warm_particle(cold_block());
  scene.config.materials[0].conductivity = 5e3;
  const Plan middle = make_plan(scene);
  EXPECT_GT(middle.heat_interval, 1);
  EXPECT_LT(middle.heat_interval, 50);
  scene.config.materials[0].conductivity = 1e6;
  const Plan fast = make_plan(scene);
  EXPECT_EQ(fast.heat_interval, 1);
  EXPECT_GT(fast.heat_steps, 1);
  for (const Plan& plan : {slow, middle, fast}) EXPECT_LE(plan.heat_dt, 0.5 * plan.heat_limit * (1 + 1e-6));
}

// Both sides of the limit, on the sharpest pattern there is: it fades just below, and grows just above.
TEST(Heat, TheLimitIsReal) {
  for (const double ratio : {2.0, 2.6, 3.0, 4.0})
    for (const double safety : {0.99, 1.02}) {
      Scene scene = cold_block();
      scene.bounds_min.setConstant(-0.6);
      scene.bounds_max.setConstant(0.6);
      scene.config.periodic = {true, true, true};
      scene.bodies.clear();
      scene.position.clear(), scene.velocity.clear(), scene.volume.clear(), scene.body.clear();
      add_body(scene, "block", BodyKind::fixed, 0, scene.bounds_min, scene.bounds_max);
      scene.config.materials[0].conductivity = 1e6;
      scene.config.numerics.support_over_spacing = ratio;
      scene.temperature.clear();
      for (const Eigen::Vector3d& x : scene.position)
        scene.temperature.push_back((10 * (x - scene.bounds_min)).cast<int>().sum() % 2 ? 300.1 : 299.9);
      Plan plan = make_plan(scene);
      // whole steps only: choose the rate that gives this share of the limit
      scene.config.numerics.safety = 1;
      scene.config.rate_hz = 1 / (safety * plan.heat_limit) * (1 + 1e-6);
      if (safety > 1) scene.config.numerics.safety = 1.1;
      plan = make_plan(scene);
      ASSERT_EQ(plan.heat_steps * plan.heat_interval, 1);
      const auto simulation = simulate(scene);
      for (int k = 0; k < 60; ++k) simulation->step({});
      Snapshot s;
      simulation->snapshot(s);
      EXPECT_EQ(std::abs(s.temperature[0] - 300) < 0.1, safety < 1)
          << "H / dx = " << ratio << ", " << safety << ": " << s.temperature[0];
    }
}

TEST(Heat, AMaterialWithoutHeatCapacityIsRefused) {
  Scene scene = with_a_warm_particle(cold_block());
  scene.config.materials[0].heat_capacity = 0;
  EXPECT_THROW(make_plan(scene), ConfigError);
}

TEST(Heat, ATemperatureThatIsNoNumberIsCounted) {
  Scene scene = cold_block();
  scene.temperature[7] = NAN;
  const auto simulation = simulate(scene);
  const Health& health = simulation->step({}).health;
  EXPECT_FALSE(health.ok);
  EXPECT_EQ(health.non_finite, 1u);
}

TEST(Lightness, HeatIsPaidForWhereItFlows) {
  Scene still = with_a_warm_particle(cold_block(BodyKind::fluid));
  still.config.materials[0].conductivity = 0;
  Scene zoned = with_a_warm_particle(cold_block(BodyKind::fluid));
  add_zone(zoned, {0, 0, 0}, {1, 1, 1});
  const Contents without = contents_of(still), with = contents_of(with_a_warm_particle(cold_block(BodyKind::fluid))),
                 more = contents_of(zoned);
  for (const std::string& name : without.arrays) {
    EXPECT_EQ(name.find("heat"), std::string::npos) << name;
    EXPECT_EQ(name.find("enthalpy"), std::string::npos) << name;
  }
  EXPECT_EQ(added(without.arrays, with.arrays), (Names{"state enthalpy", "sorted enthalpy", "heat roles"}));
  EXPECT_EQ(added(without.launches, with.launches), (Names{"heat", "temperature"}));
  EXPECT_EQ(added(with.arrays, more.arrays), (Names{"heat zones", "heat zone volumes"}));
  EXPECT_EQ(added(with.launches, more.launches), (Names{"heat zones"}));
}

}  // namespace
}  // namespace palp::test::heat_test
