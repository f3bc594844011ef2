// Tools in a hand against fixed bodies: implicit steps (proxy.h), so no tool is too light and no coupling too stiff.
#include <gtest/gtest.h>

#include "sim_server/solver/plan.h"
#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/backend.h"
#include "tests/support/random.h"
#include "tests/support/scene_builder.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::proxy_contact_test {
namespace {

using Eigen::Vector3d;
// A plate whose top is z = 0 and a tool above it, so heavy.
SceneConfig plate_and_tool(const ShapeConfig& shape, double volume, double mass, const Vector3d& place,
                           const Vector3d& velocity) {
  SceneConfig config = contact_scene(0.01, 0.3, 0.2);
  config.gravity.setZero();
  config.materials.push_back(config.materials[0]);
  config.materials[1].name = "tool";
  config.materials[1].density = mass / volume;
  config.bodies.push_back(at(body("plate", BodyKind::fixed, box({0.2, 0.2, 0.04})), {0, 0, -0.02}));
  BodyConfig tool = at(body("tool", BodyKind::rigid, shape), place, velocity);
  tool.material = "tool";
  config.bodies.push_back(tool);
  ProxyConfig proxy;
  proxy.body = "tool";
  proxy.coupling_limit = {1e6, 1e4, 1e4, 100};
  config.proxies.push_back(proxy);
  return config;
}

StepInput held(const Vector3d& place, const CouplingGains& gains) {
  StepInput input;
  input[0].engaged = true;
  input[0].state.position = place;
  input[0].gains = gains;
  return input;
}

// A cube pressed on a plate with 20 N through a stiff coupling: it comes to rest, as deep as its contact's stiffness,
// one or four times less than kappa m / dt^2 by where its points are, says.
TEST(ProxyContact, ToolsOfAnyMassRestOnAPlate) {
  for (const double rate : {300.0, 1000.0})
    for (const double mass : {1e-3, 1.0})
      for (const double stiffness : {1e3, 1e5}) {
        SCOPED_TRACE(::testing::Message() << rate << " Hz, " << mass << " kg, " << stiffness << " N/m");
        SceneConfig config = plate_and_tool(box({0.04, 0.04, 0.04}), 6.4e-5, mass, {0, 0, 0.0201}, Vector3d::Zero());
        config.rate_hz = rate;
        const Scene scene = sampled(config);
        const auto simulation = simulate(scene);
        const double dt = make_plan(scene).dt, deepest = 4 * 20 * dt * dt / mass;
        const StepInput input = held({0, 0, 0.02 - 20 / stiffness}, {stiffness, 5, 10, 0.05});
        for (int k = 0; k < static_cast<int>(rate / 2); ++k)
          ASSERT_TRUE(simulation->step(input).health.ok) << simulation->output().health.cause;
        const ProxyOutput& out = simulation->output().proxies[0];
        const double depth = 0.02 - out.state.position.z();
        EXPECT_LT(out.state.linear.norm(), 1e-5);
        EXPECT_GT(depth, 0.25 * deepest);
        EXPECT_LT(depth, deepest + 1e-6);
        EXPECT_TRUE(within(out.contact_force.z() / (20 - stiffness * depth) - 1, tol::kCouplingForce));
      }
}

// Thrown by a hand that has let its coupling go: what contact gives it is what its momentum changes by, in each step,
// and it bounces by its restitution.
TEST(ProxyContact, AToolBouncesByItsRestitution) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const double e : {0.2, 0.5, 0.8, 1.0})
    for (int round = 0; round < 2; ++round) {
      const double v = uniform(random, 0.2, 2), mass = uniform(random, 0.001, 0.5);
      const Vector3d place(0, 0, 0.05 + uniform(random, 0.001, 0.01));
      SceneConfig config = plate_and_tool(sphere(0.05), 5.236e-4, mass, place, {0, 0, -v});
      for (MaterialConfig& m : config.materials) m.restitution = e;
      const Scene scene = sampled(config);
      const auto simulation = simulate(scene);
      double before = -v;
      for (int k = 0; k < 80; ++k) {
        const StepOutput& out = simulation->step(held(place, {0, 0, 0, 0}));
        const double now = out.bodies[1].state.linear.z();
        EXPECT_TRUE(within((scene.bodies[1].mass * (now - before) * 1000 - out.proxies[0].contact_force.z()) /
                               (1000 * scene.bodies[1].mass * v),
                           tol::kContactMomentum));
        before = now;
      }
      EXPECT_TRUE(within(before / v - e, tol::kToolRestitution)) << "e " << e;
      if (e == 1) {
        EXPECT_LE(before, v * (1 + value_of(tol::kContactMomentum)));
      }
    }
}

// A hand that presses and then tears the tool away: contact never holds it back.
TEST(ProxyContact, ContactNeverPulls) {
  const SceneConfig config = plate_and_tool(box({0.04, 0.04, 0.04}), 6.4e-5, 0.05, {0, 0, 0.0201}, Vector3d::Zero());
  const auto simulation = simulate(sampled(config));
  StepInput input = held({0, 0, 0.0}, {1000, 5, 10, 0.05});
  for (int k = 0; k < 300; ++k) simulation->step(input);
  EXPECT_GT(simulation->output().proxies[0].contact_force.z(), 15);
  input[0].state.linear = {0, 0, 4};
  for (int k = 0; k < 50; ++k) {
    EXPECT_GE(simulation->step(input).proxies[0].contact_force.z(), -1e-4) << k;
    input[0].state.position.z() += 4e-3;
  }
  EXPECT_EQ(simulation->output().proxies[0].contact_force.norm(), 0);
}

// Tools of any mass in a corner of two walls and a plate, led by a hand that ends far inside: they stay finite and come
// to rest.
TEST(ProxyContact, ToolsComeToRestInACorner) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (int round = 0; round < 4; ++round) {
    const double mass = std::pow(10, uniform(random, -4, 0)), stiffness = std::pow(10, uniform(random, 2.5, 5));
    SCOPED_TRACE(::testing::Message() << mass << " kg, " << stiffness << " N/m");
    const Vector3d place(0.05, 0.05, 0.05);
    SceneConfig config = plate_and_tool(box({0.04, 0.04, 0.04}), 6.4e-5, mass, place, Vector3d::Zero());
    config.bodies.push_back(at(body("left", BodyKind::fixed, box({0.04, 0.2, 0.2})), {-0.02, 0, 0.1}));
    config.bodies.push_back(at(body("back", BodyKind::fixed, box({0.2, 0.04, 0.2})), {0.101, -0.02, 0.1}));
    const auto simulation = simulate(sampled(config));
    StepInput input = held(place, {stiffness, 5, 20, 0.1});
    const Vector3d way = 0.08 * (Vector3d(-1, -1, -1) + 0.5 * random_vector(random, 1)).normalized();
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(uniform(random, 0, 1), random_vector(random, 1).normalized()));
    for (int k = 0; k < 800; ++k) {
      const double share = std::min(1.0, k / 200.0);
      input[0].state.position = place + share * way;
      input[0].state.linear = share < 1 ? Vector3d(5 * way) : Vector3d::Zero();
      input[0].state.orientation = Eigen::Quaterniond::Identity().slerp(share, turn);
      const StepOutput& out = simulation->step(input);
      ASSERT_TRUE(out.health.ok) << out.health.cause;
    }
    EXPECT_LT(simulation->output().proxies[0].state.linear.norm(), 1e-3);
    EXPECT_LT(simulation->output().proxies[0].state.angular.norm(), 0.05);
  }
}

}  // namespace
}  // namespace palp::test::proxy_contact_test
