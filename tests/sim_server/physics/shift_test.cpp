// Particle shifting: its equations, which particles it moves, and where it is planned.
#include <gtest/gtest.h>

#include "config/error.h"
#include "sim_server/solver/plan.h"
#include "tests/support/backend.h"
#include "tests/support/equations.h"
#include "tests/support/random.h"
#include "tests/support/restated_shift.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::shift_test {
namespace {

constexpr double kSpacing = 0.05;

// A layer of fluid that floats in space, periodic along x and y, its particles displaced and sheared at random.
Scene sheared_layer(Random& random, int across, int high) {
  const double side = across * kSpacing, top = high * kSpacing;
  Scene scene = empty_scene(kSpacing, {0, 0, -0.5}, {side, side, top + 0.5});
  scene.config.periodic = {true, true, false};
  scene.config.gravity.setZero();
  scene.config.rate_hz = 250;
  scene.config.numerics.max_speed = 0.5;
  add_body(scene, "oil", BodyKind::fluid, add_material(scene, 1000, 5), {0, 0, 0}, {side, side, top});
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    scene.position[i] += random_vector(random, 0.05 * kSpacing);
    scene.velocity[i] = random_vector(random, 0.02);
    scene.velocity[i].x() += 0.2 * std::sin(2 * M_PI * scene.position[i].z() / top);
  }
  return scene;
}

TEST(Shift, FollowsItsEquations) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const Scene scene = sheared_layer(random, 9, 20);
  const auto simulation = simulate(scene);
  Restated world = restate(scene);
  ASSERT_EQ(world.plan.sub_steps, 1);
  ASSERT_EQ(world.plan.fluid_interval, 1);
  ASSERT_GT(world.plan.layer_interval, 1);
  Snapshot s;
  double largest = 0;
  for (int step = 1; step <= 5 * world.plan.layer_interval; ++step) {
    SCOPED_TRACE("step " + std::to_string(step));
    ASSERT_TRUE(simulation->step({}).health.ok);
    sub_step(world, {}, world.plan.dt);
    simulation->snapshot(s);
    ASSERT_TRUE(within(places_apart(world, s), tol::kFewSteps));
    for (std::size_t i = 0; i < world.x.size(); ++i) largest = std::max(largest, shift_of(world, i).norm() / kSpacing);
  }
  EXPECT_GT(largest, 20 * value_of(tol::kFewSteps)) << "else the comparison could not see shifts";
  int deep = 0;
  for (std::size_t i = 0; i < world.x.size(); ++i) {
    if (world.layer[i] < 3) continue;
    ++deep;
    EXPECT_GT(scene.position[i].z(), 1.9 * world.plan.support) << "a particle near the lower surface";
    EXPECT_LT(scene.position[i].z(), 20 * kSpacing - 1.9 * world.plan.support) << "a particle near the upper one";
  }
  EXPECT_GT(deep, 4 * 81);
}

// Between plates nine spacings apart each particle is a neighbour of one that has a plate in reach, so that none is
// ever shifted.
TEST(Shift, LeavesAFilmAlone) {
  SceneConfig config = scene(kSpacing);
  config.domain_min = {-0.5, -0.5, -1};
  config.domain_max = {0.5, 0.5, 1};
  config.periodic = {true, true, false};
  config.gravity.setZero();
  config.rate_hz = 250;
  config.numerics.max_speed = 0.5;
  config.materials[0].viscosity = 5;
  const double half = 4.5 * kSpacing;
  config.bodies = {body("oil", BodyKind::fluid, box({1, 1, 2 * half}))};
  for (const double side : {-1.0, 1.0}) {
    config.bodies.push_back(body(side < 0 ? "below" : "above", BodyKind::fixed, box({1, 1, 0.1})));
    config.bodies.back().position = {0, 0, side * (half + 0.05)};
  }
  Snapshot after[2];
  for (int k = 0; k < 2; ++k) {
    config.numerics.shift = k == 0 ? 0 : 50;
    Scene film = sample_scene(config, 1u << 20);
    for (std::size_t i = 0; i < film.position.size(); ++i)
      film.velocity[i] = {0.2 * std::sin(2 * M_PI * film.position[i].x()), 0,
                          0.1 * std::cos(2 * M_PI * film.position[i].y())};
    const auto simulation = simulate(film);
    for (int step = 0; step < 40; ++step) ASSERT_TRUE(simulation->step({}).health.ok);
    simulation->snapshot(after[k]);
  }
  EXPECT_EQ(after[0].position, after[1].position);
}

SceneConfig tank(double deep) {
  SceneConfig config = scene(kSpacing);
  config.accuracy = Accuracy::accurate;
  config.domain_min.setConstant(-2);
  config.domain_max.setConstant(2);
  config.numerics.max_speed = 1;
  config.materials[0].viscosity = 10;
  config.bodies = {body("oil", BodyKind::fluid, box({1, 1, deep}))};
  return config;
}

double shift_in(const SceneConfig& config) { return make_plan(sample_scene(config, 1u << 20)).shift; }

TEST(Shift, IsPlannedWhereAFluidIsDeep) {
  EXPECT_EQ(shift_in(tank(0.75)), 0) << "it is shallow";
  SceneConfig config = tank(1);
  EXPECT_GT(shift_in(config), 0);
  config.accuracy = Accuracy::fast;
  EXPECT_EQ(shift_in(config), 0) << "its kernel is no spline";
  config.numerics.support_over_spacing = 2.7;
  EXPECT_GT(shift_in(config), 0);
  config.materials[0].viscosity = 0.001;
  EXPECT_EQ(shift_in(config), 0) << "its viscosity smooths nothing over a spacing";
  config.materials[0].viscosity = 10;
  config.numerics.shift = 0.0;
  EXPECT_EQ(shift_in(config), 0);
  config.numerics.shift = 3.0;
  EXPECT_EQ(shift_in(config), 3);
  config.method = Method::paper;
  EXPECT_THROW(shift_in(config), ConfigError);
}

// Thin water that is made thick would be shifted from then on, were it not too late for that.
TEST(Shift, StaysAsPlannedWhenViscosityIsSet) {
  for (const double viscosity : {0.001, 10.0}) {
    SceneConfig config = tank(1);
    config.gravity.setZero();
    config.materials[0].viscosity = viscosity;
    const auto simulation = simulate(sample_scene(config, 1u << 20));
    const bool shifted = simulation->numerics().find("shift") != std::string::npos;
    EXPECT_EQ(shifted, viscosity == 10);
    simulation->step({});
    simulation->set_parameter("material.m.viscosity", viscosity == 10 ? "0.001" : "10");
    EXPECT_EQ(simulation->numerics().find("shift") != std::string::npos, shifted);
    for (int step = 0; step < 20; ++step) ASSERT_TRUE(simulation->step({}).health.ok);
  }
}

}  // namespace
}  // namespace palp::test::shift_test
