// The two-port passivity controller, alone and in the loop.
#include "haptic_bridge/loop/passivity.h"

#include <deque>

#include <gtest/gtest.h>

#include "haptic_bridge/device/simulated.h"
#include "tests/haptic_bridge/loop/fake_server.h"
#include "tests/support/seed.h"

namespace palp::test::passivity_test {
namespace {

using Eigen::Vector3d;
TEST(Passivity, BooksWhatBothPortsGiveAndTake) {
  PassivityController p({.start = 0.008, .most = 0.05, .device_damping = 2});
  p.observe({0, 0, 3}, {0, 0, 1e-3}, {0, 0, 1}, 0.004, 0, 1e-3);
  EXPECT_NEAR(p.energy(), 0.008 - 0.003 + 0.004 + 0.002, 1e-15);
  EXPECT_EQ(p.damping(), 0);
  p.observe({0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 1, 0, 1e-3);
  EXPECT_EQ(p.energy(), 0.05) << "surplus is forgotten";
  p.observe({0, 0, 5}, {0, 0, 0.02}, {0, 0, 1}, 0, 0, 1e-3);
  EXPECT_LT(p.energy(), 0);
  EXPECT_GT(p.damping(), 0);
}

TEST(Passivity, AHandGetsBackWhatAStiffSpringHolds) {
  const double stiffness = 2000, dt = 1e-3;
  PassivityController p({.start = 0.008, .most = 0.05});
  const auto move = [&](double from, double to) {  // along the wall's normal, against the middle force
    const Vector3d force{0, 0, -stiffness * (from + to) / 2}, moved{0, 0, to - from};
    p.observe(force, moved, moved / dt, 0, spring_energy({0, 0, stiffness * to}, stiffness), dt);
    EXPECT_EQ(p.damping(), 0) << "at " << to << " m";
  };
  constexpr int n = 100;
  const double depth = 0.02;  // 40 N and 0.4 J: eight times the cap
  for (int i = 0; i < n; ++i) move(depth * i / n, depth * (i + 1) / n);
  EXPECT_NEAR(p.energy(), 0.008 + stiffness * depth * depth / 2, 1e-12);
  for (int i = n; i > 0; --i) move(depth * i / n, depth * (i - 1) / n);
  EXPECT_NEAR(p.energy(), 0.008, 1e-12);
  // and not more than that
  p.observe({0, 0, 5}, {0, 0, 0.02}, {0, 0, 1}, 0, 0, dt);
  EXPECT_GT(p.damping(), 0);
}

TEST(Passivity, DampsADebtAwayInAFewTicks) {
  PassivityController p({.start = 0, .most = 0.05, .most_damping = 20});
  const double dt = 1e-3;
  const Vector3d v{0.1, 0, 0};
  p.observe(Vector3d(1, 0, 0), dt * v, v, 0, 0, dt);  // a debt of 0.1 mJ
  for (int i = 0; i < 60; ++i) p.observe(-p.damping() * v, dt * v, v, 0, 0, dt);
  EXPECT_GE(p.energy(), -1e-6);
  EXPECT_LT(p.damping(), 1);
}

// A hand on the simulated arm and a server behind a link that makes a spring look like a motor.
struct Trial {
  double drawn = 0;  // energy that the hand got, at most [J]
  double rms = 0;    // of the last second's motion [m]
  std::uint64_t damped = 0;
};

HandScript light_hand() {
  HandScript script;
  script.hand = {0.15, 3, 100};
  return script;
}

// held: the server's wrench alone, of a wall of a proxy that rests where coupling and wall balance.
Trial press(double stiffness, int delay_ms, bool controlled, double seconds, const HandScript& script = light_hand()) {
  LoopConfig config;
  config.own_session = kBridgeSession;
  config.gains.stiffness = stiffness;
  config.limits = {35, 3, 3000, 300};
  config.governor.budget = 1e9;
  if (!controlled) config.passivity.most_damping = 0;
  const RigidState home = at_rest({0, 0, -0.02}, Eigen::Quaterniond::Identity());
  ArmModel model;
  model.friction = 0;  // which would hold still what is not stable
  SimulatedDevice arm(model, script, home, at_rest({0, 0, -0.001}, Eigen::Quaterniond::Identity()));
  HapticLoop loop(config, arm);
  std::deque<DeviceSample> link;
  Trial t;
  double sum = 0, sum2 = 0, energy = 0, last = 0;
  Vector3d before = arm.true_state().position;
  Wrench<double> sent = zero_wrench();
  const int ticks = static_cast<int>(1000 * seconds);
  for (int i = 1; i <= ticks; ++i) {
    const std::int64_t now = 1'000'000'000 + i * kMillisecond;
    IncomingProxy in;
    const bool comes = static_cast<int>(link.size()) > delay_ms;
    if (comes) {
      in = {answer(link.front(), 5, static_cast<std::uint64_t>(i)), now};
      test::SpringWall{1e6}.touch(in.sample);
      // the work of the wall's proxy on the coupling: it hardly moves
      const double z = in.sample.proxy_pose.position[2];
      if (last != 0 && in.sample.wrench.force[2] > 0) energy += in.sample.wrench.force[2] * (z - last);
      last = z;
      in.sample.energy = {energy, 0};
      in.sample.blend = {0, 0};  // a held wrench: the worst there is
      link.pop_front();
    }
    loop.tick(now, 0, 0, comes ? &in : nullptr);
    link.push_back(loop.sample());
    const Vector3d x = arm.true_state().position;
    t.drawn += sent.force.dot(x - before);
    before = x;
    sent = loop.record().sent;
    if (i > ticks - 1000) {
      sum += x.z() / 1000;
      sum2 += x.z() * x.z() / 1000;
    }
  }
  t.rms = std::sqrt(std::max(0.0, sum2 - sum * sum));
  t.damped = loop.report().damped_ticks;
  return t;
}

TEST(Passivity, StillsASpringThatTheLinkHasMadeAMotor) {
  const Trial free = press(2500, 4, false, 4), damped = press(2500, 4, true, 4);
  EXPECT_GT(free.rms, 1e-3) << "without the controller it would not shake: this test tests nothing";
  EXPECT_LT(damped.rms, 0.3 * free.rms);
  EXPECT_GT(damped.damped, 100u);
  EXPECT_LT(damped.drawn, 0.3 * std::max(free.drawn, 0.02));
}

TEST(Passivity, LeavesAGoodLinkAlone) {
  const Trial trial = press(600, 1, true, 4);
  EXPECT_EQ(trial.damped, 0u);
  EXPECT_LT(trial.rms, 5e-5);
}

TEST(Passivity, LeavesAHandAloneThatPressesHardAndComesBack) {
  HandScript script;
  script.hand = {0.5, 10, 500};
  const auto at = [](double time, double z) { return Keyframe{time, {0, 0, z}, Eigen::Quaterniond::Identity()}; };
  script.keyframes = {at(0, 0), at(1, 0), at(2, -0.06), at(3, 0), at(4, -0.06), at(5, 0.02)};
  EXPECT_EQ(press(600, 1, true, 6, script).damped, 0u);
}

}  // namespace
}  // namespace palp::test::passivity_test
