// Proxies coupled to a device: statics, action and reaction, stiffness, energy, bad input.
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/random_scene.h"
#include "tests/support/tolerance.h"

namespace palp::test::proxy_test {
namespace {

// A tool in empty space, held at a handle off its centre.
Scene lone_tool() {
  Scene scene = empty_scene(0.02, {-1, -1, -1}, {1, 1, 1});
  const auto steel = add_material(scene, 2000, 0);
  const auto body = add_body(scene, "tool", BodyKind::rigid, steel, {-0.06, -0.02, -0.02}, {0.06, 0.02, 0.02});
  Proxy proxy;
  proxy.body = body;
  proxy.handle = {0.08, 0, 0.03};
  proxy.limit = {1e9, 1e6, 1e6, 1e4};
  scene.proxies.push_back(proxy);
  return scene;
}

StepInput held_at(const Scene& scene, const CouplingGains& gains) {
  StepInput input;
  input[0].engaged = true;
  input[0].state.position = scene.bodies[0].position + scene.proxies[0].handle;
  input[0].gains = gains;
  return input;
}

TEST(Proxy, HangsFromTheSpringByItsWeight) {
  const Scene scene = lone_tool();
  const StepInput input = held_at(scene, {1000, 20, 50, 0.5});
  const auto simulation = simulate(scene);
  const StepOutput* out = nullptr;
  for (int k = 0; k < 5000; ++k) out = &simulation->step(input);
  const double weight = scene.bodies[0].mass * 9.81;
  const ProxyOutput& proxy = out->proxies[0];
  // the coupling pulls the device down by the tool's weight
  EXPECT_TRUE(within((proxy.force - Eigen::Vector3d(0, 0, -weight)).norm() / weight, tol::kCouplingForce));
  EXPECT_NEAR(input[0].state.position.z() - proxy.state.position.z(), weight / 1000, 1e-6);
  // and turns it by the weight's moment about the handle
  const Eigen::Vector3d arm = out->bodies[0].state.position - proxy.state.position;
  const Eigen::Vector3d moment = arm.cross(Eigen::Vector3d(0, 0, -weight));
  EXPECT_TRUE(within((proxy.torque - moment).norm() / moment.norm(), tol::kCouplingForce));
  EXPECT_EQ(proxy.contact_force.norm(), 0);
}

// Momentum balance of a held and shaken tool: what it gains is the opposite of what the device got, plus its weight.
TEST(Proxy, DeviceFeelsTheOppositeOfTheProxysForce) {
  const Scene scene = lone_tool();
  const auto simulation = simulate(scene);
  StepInput input = held_at(scene, {500, 5, 20, 0.05});
  const Eigen::Vector3d start = input[0].state.position;
  const double m = scene.bodies[0].mass, dt = 1e-3;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  double worst = 0;
  for (int k = 0; k < 500; ++k) {
    const double phase = 30 * k * dt;
    input[0].state.position = start + 0.02 * Eigen::Vector3d(std::sin(phase), 1 - std::cos(phase), 0);
    input[0].state.linear = 0.6 * Eigen::Vector3d(std::cos(phase), std::sin(phase), 0);
    const StepOutput& out = simulation->step(input);
    const RigidState& body = out.bodies[0].state;
    const Eigen::Vector3d gained = m * (body.linear - before) / dt - m * Eigen::Vector3d(0, 0, -9.81);
    worst = std::max(worst, (gained + out.proxies[0].force).norm() / (m * 9.81));
    before = body.linear;
  }
  // one sub-step a step here, so the force of the step's end is that of its sub-step, up to the turn of the handle
  EXPECT_LT(worst, 0.02);
}

// A bridge holds for a step the force that moved the tool in that step, also that of a slow server. At the step's end
// alone the coupling pulls less, and a hand that throws the tool about is given energy.
TEST(Proxy, DeviceFeelsTheMeanOfASlowServersStep) {
  Scene scene = lone_tool();
  scene.config.rate_hz = 300;
  scene.config.gravity.setZero();
  scene.config.numerics.sub_steps = 5;
  const auto simulation = simulate(scene);
  ASSERT_EQ(simulation->sub_steps(), 5);
  StepInput input = held_at(scene, {1000, 20, 50, 0.5});
  const Eigen::Vector3d start = input[0].state.position;
  const double m = scene.bodies[0].mass, dt = 1 / scene.config.rate_hz;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  double worst = 0, largest = 0;
  for (int k = 0; k < 200; ++k) {
    const double phase = 8 * k * dt;
    input[0].state.position = start + 0.1 * Eigen::Vector3d(1 - std::cos(phase), 0, 0);
    input[0].state.linear = 0.8 * Eigen::Vector3d(std::sin(phase), 0, 0);
    const StepOutput& out = simulation->step(input);
    const RigidState& body = out.bodies[0].state;
    const Eigen::Vector3d gained = m / dt * (body.linear - before);
    worst = std::max(worst, (gained + out.proxies[0].force).norm());
    largest = std::max(largest, gained.norm());
    before = body.linear;
  }
  // single precision of the velocities; the tool turns, which the body frame's velocity has little of
  EXPECT_LT(worst, 0.02 * largest);
}

TEST(Proxy, StaysBoundedAtVeryHighGains) {
  const Scene scene = lone_tool();
  const auto simulation = simulate(scene);
  StepInput input = held_at(scene, {1e8, 1e3, 1e5, 1});
  input[0].state.position += Eigen::Vector3d(0.05, 0, 0);  // a jump of 5 cm
  input[0].state.orientation = Eigen::AngleAxisd(2, Eigen::Vector3d::UnitY());
  double reach = 0;
  for (int k = 0; k < 2000; ++k) {
    const StepOutput& out = simulation->step(input);
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    const double off = (out.proxies[0].state.position - input[0].state.position).norm();
    if (k > 100) reach = std::max(reach, off);
  }
  EXPECT_LT(reach, 1e-4);
}

// In vacuum, without gravity: the energy stored in spring and tool, and the losses, come from the hand. The work of the
// proxy on the coupling is minus its kinetic energy.
TEST(Proxy, WorkOnTheCouplingIsTheLossOfKineticEnergy) {
  Scene scene = lone_tool();
  scene.config.gravity.setZero();
  scene.config.rate_hz = 10000;
  const auto simulation = simulate(scene);
  StepInput input = held_at(scene, {2000, 0, 20, 0});
  const Eigen::Vector3d start = input[0].state.position;
  const double dt = 1e-4;
  double most = 0, worst = 0;
  for (int k = 0; k < 5000; ++k) {
    const double phase = 20 * k * dt;
    input[0].state.position = start + 0.03 * Eigen::Vector3d(std::sin(phase), 0, 0.5 * std::sin(phase));
    input[0].state.linear = 0.6 * std::cos(phase) * Eigen::Vector3d(1, 0, 0.5);
    const StepOutput& out = simulation->step(input);
    const double kinetic = out.health.kinetic_energy;
    const double work = out.proxies[0].energy[0] + out.proxies[0].energy[1];
    most = std::max(most, kinetic);
    worst = std::max(worst, work + kinetic);
  }
  // backward Euler loses energy, so the proxy takes more out of the coupling than it keeps, never less
  EXPECT_LT(worst, 1e-3 * most) << "the proxy must not gain energy from nowhere";
  const StepOutput& out = simulation->step(input);
  const double balance = out.proxies[0].energy[0] + out.proxies[0].energy[1] + out.health.kinetic_energy;
  RecordProperty("lost_share", std::to_string(-balance / most));
  EXPECT_LT(std::abs(balance), 0.2 * most);
}

TEST(Proxy, WithoutHandIsHeldInPlace) {
  const Scene scene = lone_tool();
  const auto simulation = simulate(scene);
  for (int k = 0; k < 100; ++k) simulation->step({});
  const StepOutput& out = simulation->step({});
  EXPECT_LT((out.bodies[0].state.position - scene.bodies[0].position).norm(), 1e-7);
  EXPECT_EQ(out.proxies[0].force.norm(), 0);
  EXPECT_EQ(out.proxies[0].blend[0], 0);
}

TEST(Proxy, GainsAreClippedToItsLimit) {
  Scene scene = lone_tool();
  scene.proxies[0].limit = {100, 10, 5, 0.5};
  const auto simulation = simulate(scene);
  const StepOutput& out = simulation->step(held_at(scene, {1e6, 1e6, -3, 1e6}));
  EXPECT_EQ(out.proxies[0].gains.stiffness, 100);
  EXPECT_EQ(out.proxies[0].gains.damping, 10);
  EXPECT_EQ(out.proxies[0].gains.angular_stiffness, 0);
  EXPECT_EQ(out.proxies[0].gains.angular_damping, 0.5);
}

// The blend says how much the world holds the proxy back: 0 in the air, 1 against a wall.
TEST(Proxy, BlendIsSmallInTheAirAndLargeAtAWall) {
  Scene scene = lone_tool();
  scene.config.gravity.setZero();
  const auto wall = add_body(scene, "wall", BodyKind::fixed, 0, {0.1, -0.2, -0.2}, {0.2, 0.2, 0.2});
  (void)wall;
  const auto simulation = simulate(scene);
  StepInput input = held_at(scene, {1000, 20, 50, 0.5});
  const double x0 = input[0].state.position.x();
  double in_air = 0, at_wall = 0;
  for (int k = 0; k < 1000; ++k) {
    input[0].state.linear = {0.1, 0, 0};
    input[0].state.position.x() = x0 + 0.1 * k * 1e-3;
    const StepOutput& out = simulation->step(input);
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    if (k == 250) in_air = out.proxies[0].blend[0];
    if (k == 999) at_wall = out.proxies[0].blend[0];
  }
  EXPECT_LT(in_air, 0.2);
  EXPECT_GT(at_wall, 0.8);
}

// Input that is not finite, or no rotation, never reaches the world: the proxy is held and no force goes to the device.
TEST(Proxy, NonFiniteInputIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  Random random(5);
  const Scene scene = random_scene(random, {});
  const StepInput good = random_input(random, scene);
  std::vector<StepInput> bad(8, good);
  bad[0][0].state.position.x() = nan;
  bad[1][0].state.orientation.w() = inf;
  bad[2][0].state.orientation = Eigen::Quaterniond(0, 0, 0, 0);
  bad[3][0].state.linear.y() = -inf;
  bad[4][0].state.angular.z() = nan;
  bad[5][0].gains.stiffness = nan;
  bad[6][0].gains.angular_damping = nan;
  bad[7][0].state.position.z() = 1e300;  // finite, but not once it is rounded to float
  const auto simulation = simulate(scene);
  for (std::size_t k = 0; k < bad.size(); ++k) {
    SCOPED_TRACE("input " + std::to_string(k));
    simulation->reset();
    simulation->step(good);
    const StepOutput& out = simulation->step(bad[k]);
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    EXPECT_EQ(out.health.non_finite, 0u);
    EXPECT_EQ(out.proxies[0].force.norm(), 0);
    EXPECT_EQ(out.proxies[0].torque.norm(), 0);
    EXPECT_TRUE(out.proxies[0].state.position.allFinite());
    EXPECT_TRUE(out.proxies[0].device.position.allFinite());
    EXPECT_TRUE(std::isfinite(out.proxies[0].gains.stiffness + out.proxies[0].gains.angular_damping));
    const StepOutput& later = simulation->step(good);
    EXPECT_TRUE(later.health.ok);
    EXPECT_TRUE(later.proxies[0].force.allFinite());
    EXPECT_GT(later.proxies[0].force.norm(), 0);
  }
}

}  // namespace
}  // namespace palp::test::proxy_test
