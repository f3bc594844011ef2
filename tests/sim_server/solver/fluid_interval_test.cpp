// Fluids that take several haptic steps at once: when they do, and what is kept when they do.
#include <gtest/gtest.h>

#include "config/error.h"
#include "sim_server/solver/plan.h"
#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::fluid_interval_test {
namespace {

// A periodic box of 20 x 10 x 10 spacings of a fluid that nothing pulls, with a ball in it.
SceneConfig box_with_ball(double spacing) {
  SceneConfig config = contact_scene(spacing, 0, 0.2);
  config.gravity.setZero();
  config.domain_min.setZero();
  config.domain_max = Eigen::Vector3d(20, 10, 10) * spacing;
  config.periodic = {true, true, true};
  config.numerics.max_speed = 1;
  config.materials[0].viscosity = 0.1;
  const Eigen::Vector3d middle = config.domain_max / 2;
  BodyConfig water = at(body("water", BodyKind::fluid, box(config.domain_max)), middle, {0.1, 0, 0});
  water.shapes.push_back(cut(sphere(2.5 * spacing)));
  config.bodies = {water, at(body("ball", BodyKind::rigid, sphere(2.5 * spacing)), middle, {0.4, 0.1, 0})};
  return config;
}

Plan plan_with(const SceneConfig& config) { return make_plan(sampled(config)); }

TEST(FluidInterval, FollowsFromTheLimitsOfFluids) {
  for (const double spacing : {0.005, 0.01, 0.02, 0.05}) {
    SCOPED_TRACE(spacing);
    SceneConfig config = box_with_ball(spacing);
    const Plan plan = plan_with(config);
    if (plan.sub_steps > 1) {
      EXPECT_EQ(plan.fluid_interval, 1);
      continue;
    }
    // 1.5 times the safety of 2.23 dx / (c + v), and 2 ms at most
    const double allowed = std::min(2e-3, 1.5 * 0.5 * 2.23 * spacing / (plan.sound_speed + plan.max_speed));
    EXPECT_EQ(plan.fluid_interval, std::max(1, static_cast<int>(allowed * config.rate_hz + 1e-9)));
    config.rate_hz = 4000;
    EXPECT_EQ(plan_with(config).fluid_interval, static_cast<int>(4000 * allowed + 1e-9));
  }
}

TEST(FluidInterval, IsOneWhereFluidsShareTheirSteps) {
  const SceneConfig plain = box_with_ball(0.05);
  ASSERT_GT(plan_with(plain).fluid_interval, 1);
  SceneConfig few = plain;
  few.bodies[0].shapes = {box({0.2, 0.2, 0.2}, {0.3, 0, 0})};
  EXPECT_EQ(plan_with(few).fluid_interval, 1);
  SceneConfig asked = plain;
  asked.numerics.fluid_interval = 1;
  EXPECT_EQ(plan_with(asked).fluid_interval, 1);
  SceneConfig given = plain;
  given.numerics.sub_steps = 1;
  EXPECT_EQ(plan_with(given).fluid_interval, 1);
  SceneConfig paper = plain;
  paper.method = Method::paper;
  EXPECT_EQ(plan_with(paper).fluid_interval, 1);
  SceneConfig soft = plain;
  add_soft(soft, 0);
  soft.bodies[1].type = BodyKind::elastic;
  soft.bodies[1].material = "soft";
  EXPECT_EQ(plan_with(soft).fluid_interval, 1);
}

TEST(FluidInterval, RefusesMoreThanFluidsCanTake) {
  SceneConfig config = box_with_ball(0.05);
  const Plan own = plan_with(config);
  const int most = static_cast<int>(2.27 * 0.05 / (own.sound_speed + own.max_speed) * config.rate_hz);
  config.numerics.fluid_interval = most;
  EXPECT_EQ(plan_with(config).fluid_interval, most);
  const auto fault = [&] {
    try {
      plan_with(config);
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  config.numerics.fluid_interval = most + 1;
  EXPECT_NE(fault().find("can take " + std::to_string(most) + " haptic steps at once"), std::string::npos) << fault();
  config.method = Method::paper;
  EXPECT_NE(fault().find("can take 1 haptic step at once, since"), std::string::npos) << fault();
}

// A fluid receives a body's push at once, and the body the opposite over as many haptic steps.
TEST(FluidInterval, KeepsMomentum) {
  for (const int interval : {1, 2, 3}) {
    SCOPED_TRACE(interval);
    SceneConfig config = box_with_ball(0.02);
    config.numerics.fluid_interval = interval;
    const Scene scene = sampled(config);
    const auto simulation = simulate(scene);
    Snapshot s;
    const auto momentum = [&](double& size) {
      simulation->snapshot(s);
      const BodyOutput& ball = simulation->output().bodies[1];
      Eigen::Vector3d sum = scene.bodies[1].mass * ball.state.linear;
      size = sum.norm();
      for (std::size_t i = 0; i < scene.position.size(); ++i) {
        const Eigen::Vector3d mv = scene.volume[i] * config.materials[0].density *
                                   Eigen::Vector3d(s.velocity[3 * i], s.velocity[3 * i + 1], s.velocity[3 * i + 2]);
        sum += mv;
        size += mv.norm();
      }
      return sum;
    };
    double size = 0, most = 0, drift = 0;
    Eigen::Vector3d before = Eigen::Vector3d::Zero();
    for (int k = 1; k <= 300 * interval; ++k) {
      const StepOutput& out = simulation->step({});
      ASSERT_TRUE(out.health.ok) << out.health.cause;
      if (k == 2 * interval) before = momentum(size);
      if (k <= 2 * interval || k % interval != 0) continue;
      drift = std::max(drift, (momentum(most) - before).norm());
    }
    EXPECT_TRUE(within(drift / size, tol::kClosedMomentum));
  }
}

TEST(FluidInterval, MovesFluidsByAllStepsInTheFirst) {
  SceneConfig config = box_with_ball(0.02);
  config.bodies.pop_back();
  config.bodies[0].shapes.pop_back();
  config.numerics.fluid_interval = 3;
  const Scene scene = sampled(config);
  const auto simulation = simulate(scene);
  Snapshot s;
  for (int k = 1; k <= 12; ++k) {
    simulation->step({});
    simulation->snapshot(s);
    const int moved = (k + 2) / 3 * 3;  // haptic steps
    EXPECT_NEAR(s.position[0] - scene.position[0].x(), 0.1 * moved * 1e-3, 1e-6) << k;
  }
}

}  // namespace
}  // namespace palp::test::fluid_interval_test
