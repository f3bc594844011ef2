// The loop before a server and a device that do all right: when there is force, how much, and how it is rendered.
#include "haptic_bridge/loop/loop.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include <gtest/gtest.h>

#include "haptic_bridge/device/simulated.h"
#include "tests/haptic_bridge/loop/loop_bench.h"

namespace palp::test::loop_test {
namespace {

TEST(Loop, WithoutAServerThereIsNoForceAndTheDeviceIsStillRead) {
  Bench b;
  b.device.reading.state.position = {0.1, 0.2, 0.3};
  b.ticks(500, false);
  EXPECT_EQ(b.felt(), 0);
  EXPECT_EQ(b.loop.report().state, LoopState::waiting);
  EXPECT_EQ(b.loop.sample().pose.position[2], 0.3);
  EXPECT_EQ(b.loop.sample().t_device_ns, b.now);
  EXPECT_EQ(b.loop.sample().flags, static_cast<std::uint32_t>(kEngaged | kHealthy));
}

TEST(Loop, ForceComesAfterFreshDataAndOnARamp) {
  Bench b;
  b.ticks(190);
  EXPECT_EQ(b.loop.report().state, LoopState::ready);
  EXPECT_EQ(b.felt(), 0);
  b.ticks(261);  // 200 ms of fresh data, then half of the ramp
  EXPECT_NEAR(b.felt(), 2, 0.03);
  b.ticks(300);
  EXPECT_EQ(b.loop.report().state, LoopState::engaged);
  EXPECT_NEAR(b.felt(), 4, kRounding);
}

TEST(Loop, SaturatesForceAndTorqueSeparatelyAndKeepsDirection) {
  Bench b;
  b.force = {30, 0, 40};
  b.lie = [](ProxySample& s) { s.wrench.torque = {0, 0.1, 0}; };
  b.engage();
  EXPECT_NEAR(b.device.written.force.x(), 8 * 0.6, kRounding);
  EXPECT_NEAR(b.device.written.force.z(), 8 * 0.8, kRounding);
  EXPECT_NEAR(b.device.written.torque.y(), 0.1, kRounding);
}

TEST(Loop, TheDevicesOwnLimitHoldsWhenItIsSmaller) {
  LoopConfig config = config_for_tests();
  config.limits.force = 100;
  config.limits.force_slew = 1e6;
  Bench b(config);
  b.force = {0, 0, 90};
  b.engage();
  EXPECT_NEAR(b.felt(), 35, kRounding);
}

// A wrench is held for a period, so the spring in it is that of the period's middle: on the mean the hand feels the
// coupling's stiffness and its damping, not K T/2 less.
TEST(Loop, RendersTheMiddleOfThePeriodThatItHoldsAWrenchFor) {
  Bench b;
  b.force = {0, 0, 0};
  b.lie = [](ProxySample& s) { s.blend = {1, 1}; };
  b.engage();
  const CouplingGains gains = b.loop.config().gains;
  b.device.reading.state.linear = {0.1, 0, 0};
  b.device.reading.state.angular = {0, 0.5, 0};
  b.device.reading.state.position = {1e-3, 0, 0};
  b.tick(false);
  b.tick(false);
  EXPECT_NEAR(b.loop.record().model.force.x(), -(gains.stiffness * (1e-3 + 0.1 * 0.5e-3) + gains.damping * 0.1), 1e-9);
  EXPECT_NEAR(b.loop.record().model.torque.y(), -(gains.angular_stiffness * 0.5 * 0.5e-3 + gains.angular_damping * 0.5),
              1e-9);
}

TEST(Loop, PausedUnhealthyOrUncoupledRampsDownAndComesBack) {
  for (std::uint32_t flags : {kEngaged | kHealthy | kPaused, +kEngaged, +kHealthy}) {
    SCOPED_TRACE(flags);
    Bench b;
    b.engage();
    b.lie = [&](ProxySample& s) { s.flags = flags; };
    b.ticks(25);
    EXPECT_NEAR(b.felt(), 2, 0.2);
    b.ticks(35);
    EXPECT_EQ(b.felt(), 0);
    EXPECT_EQ(b.loop.report().state, LoopState::idle);
    b.lie = nullptr;
    b.ticks(600);
    EXPECT_NEAR(b.felt(), 4, kRounding);
  }
}

TEST(Loop, RendersContactBetweenSamples) {
  // samples every 4 ms, a hand that presses on: the wall pushes back each millisecond
  Bench b;
  b.force = {0, 0, 0};
  b.lie = [](ProxySample& s) { SpringWall{}.touch(s); };
  b.device.reading.state.position.z() = -1e-3;
  b.engage();
  const double share = 5000.0 / 6000;
  for (int i = 1; i <= 400; ++i) {
    b.device.reading.state.position.z() -= 1e-5;
    b.tick(i % 4 == 0);
    const double depth = 1e-3 + 1e-5 * i;
    ASSERT_NEAR(b.device.written.force.z(), 1000 * share * depth, 1e-6) << i;
  }
}

TEST(Loop, SimulatedArmPressesOnAWallSteadilyThroughAServerWithDelay) {
  for (const int delay_ticks : {1, 3}) {
    SCOPED_TRACE(delay_ticks);
    HandScript script;
    script.keyframes = {{0, {0, 0, 0}}, {1, {0, 0, -0.02}}};
    const RigidState home = at_rest({0, 0, 0.005}, Eigen::Quaterniond::Identity());
    SimulatedDevice arm(ArmModel{}, script, home, home);
    HapticLoop loop(config_for_tests(), arm);
    std::deque<DeviceSample> in_flight;
    double sum = 0, sum2 = 0;
    std::int64_t now = 1'000'000'000;
    for (int i = 1; i <= 4000; ++i, now += kMillisecond) {
      IncomingProxy in;
      const bool arrives = static_cast<int>(in_flight.size()) >= delay_ticks;
      if (arrives) {
        in = {answer(in_flight.front(), 5, static_cast<std::uint64_t>(i)), now};
        in_flight.pop_front();
        SpringWall{}.touch(in.sample);
      }
      loop.tick(now, 0, 0, arrives ? &in : nullptr);
      in_flight.push_back(loop.sample());
      if (i > 3000) {
        sum += loop.report().force;
        sum2 += loop.report().force * loop.report().force;
      }
    }
    // the hand wants 15 mm into the wall with 500 N/m against 833 N/m: both give until they balance
    const double mean = sum / 1000, share = 5000.0 / 6000, balance = 0.015 * 500 * 1000 * share / (500 + 1000 * share);
    EXPECT_NEAR(mean, balance, 0.15);  // friction of the arm
    EXPECT_LT(std::sqrt(std::max(0.0, sum2 / 1000 - mean * mean)), 0.02);
  }
}

TEST(Loop, LateTicksAreCountedAndDoNotBreakTheSlewLimit) {
  LoopConfig config = config_for_tests();
  config.safety.overrun_ns = 0;
  Bench b(config);
  b.engage();
  b.force = {0, 0, -4};
  b.now += 7 * kMillisecond;
  const IncomingProxy in{b.next_answer(), b.now};
  b.loop.tick(b.now, 7 * kMillisecond, 7, &in);
  EXPECT_EQ(b.loop.report().missed, 7u);
  EXPECT_GE(b.device.written.force.z(), 4 - 0.3 - kRounding);
}

}  // namespace
}  // namespace palp::test::loop_test
