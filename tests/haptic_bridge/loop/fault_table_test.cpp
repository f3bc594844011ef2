// Tests what the loop does when something is wrong: one test for each row of the table of faults in ARCHITECTURE.md.
#include <gtest/gtest.h>

#include "tests/haptic_bridge/loop/loop_bench.h"

namespace palp::test::fault_table_test {
namespace {

// Lets go for so many ticks, takes hold, and is felt again on the ramp of half a second.
void regrip(Bench& b, int open = 5) {
  b.device.reading.dead_man = false;
  b.ticks(open);
  b.device.reading.dead_man = true;
  b.ticks(2);
  EXPECT_LE(b.felt(), 4.0 * 2 / 500 + 0.05);
  b.ticks(250);
  EXPECT_NEAR(b.felt(), 2, 0.05);
  b.ticks(260);
  EXPECT_NEAR(b.felt(), 4, kRounding);
}

struct FaultTable : ::testing::Test {
  void SetUp() override {
    b.engage();
    ASSERT_NEAR(b.felt(), 4, kRounding);
    b.device.regrips = false;  // a hand that does not let go by itself
  }
  // Expects no force, however long all is well again, until the hand has let go.
  void expect_locked() {
    b.ticks(1000);
    EXPECT_EQ(b.felt(), 0);
    EXPECT_EQ(b.loop.report().state, LoopState::locked);
    EXPECT_EQ(b.device.shown, LoopState::locked);
    EXPECT_EQ(b.loop.sample().flags & kEngaged, 0u) << "the server must know that the hand is off";
    regrip(b);
  }
  Bench b;
};

TEST_F(FaultTable, SamplesUpToTwentyMillisecondsOldAreFeltAsTheyAre) {
  b.ticks(20, false);
  EXPECT_NEAR(b.felt(), 4, kRounding);
  EXPECT_EQ(b.loop.report().state, LoopState::engaged);
}

TEST_F(FaultTable, OlderOnesFadeAndPastAHundredTheHandMustLetGo) {
  b.ticks(40, false);
  EXPECT_NEAR(b.felt(), 2, 0.2);
  EXPECT_EQ(b.loop.report().state, LoopState::degraded);
  b.ticks(60, false);
  EXPECT_EQ(b.felt(), 0);
  EXPECT_EQ(b.loop.report().state, LoopState::stale);
  EXPECT_EQ(b.loop.report().trips, 1u);
  expect_locked();
}

TEST_F(FaultTable, AfterSilenceFreshDataCountsFor200MillisecondsBeforeForceComes) {
  b.ticks(150, false);
  b.device.reading.dead_man = false;
  b.ticks(5);
  b.device.reading.dead_man = true;
  b.ticks(190);
  EXPECT_EQ(b.felt(), 0);
  b.ticks(520);
  EXPECT_NEAR(b.felt(), 4, kRounding);
}

TEST_F(FaultTable, MoreThanThreeUnsoundSamplesInARowEndTheForce) {
  for (const auto& lie : std::vector<std::function<void(ProxySample&)>>{
           [](ProxySample& s) { s.wrench.force[0] = kNan; }, [](ProxySample& s) { s.proxy_pose.orientation[3] = 0.5; },
           [](ProxySample& s) { s.gains.stiffness = 1e9; }}) {
    b.lie = lie;
    b.ticks(3);
    EXPECT_NEAR(b.felt(), 4, kRounding);
    b.tick();
    EXPECT_EQ(b.felt(), 0);
    b.lie = nullptr;
    expect_locked();
  }
}

// The bus drops what is malformed, and the loop is told how many there were.
TEST_F(FaultTable, SamplesThatTheBusRefusedCountInThatRow) {
  b.loop.note_refused(2);
  b.tick(false);
  b.tick();  // a sound one ends the row
  b.loop.note_refused(3);
  b.tick(false);
  EXPECT_NEAR(b.felt(), 4, kRounding);
  b.loop.note_refused(1);
  b.tick(false);
  EXPECT_EQ(b.felt(), 0);
  expect_locked();
}

// A link that reorders is no fault; one that brings nothing new is a silent server.
TEST_F(FaultTable, OldSamplesAreDroppedAndLeadToSilence) {
  b.lie = [](ProxySample& s) { s.header.sequence = 3; };
  b.ticks(15);
  EXPECT_NEAR(b.felt(), 4, kRounding);
  b.ticks(85);
  EXPECT_EQ(b.loop.report().state, LoopState::stale);
  EXPECT_EQ(b.felt(), 0);
}

TEST_F(FaultTable, AnOpenHandEndsTheForceInTheSameTick) {
  b.device.reading.dead_man = false;
  b.tick();
  EXPECT_EQ(b.felt(), 0);
  EXPECT_EQ(b.loop.report().state, LoopState::idle);
  b.device.reading.dead_man = true;  // it was seen open
  b.ticks(510);
  EXPECT_NEAR(b.felt(), 4, kRounding);
}

TEST_F(FaultTable, PowerOrEmergencyStopEndTheForceAndTheHandMustLetGo) {
  for (bool DeviceReading::*what : {&DeviceReading::powered, &DeviceReading::chain_closed}) {
    b.device.reading.*what = false;
    b.tick();
    EXPECT_EQ(b.felt(), 0);
    b.ticks(10);
    b.device.reading.*what = true;
    expect_locked();
  }
}

// One may wait for the power with the handle in the hand.
TEST_F(FaultTable, AGripBeforeThePowerComesBackCounts) {
  b.device.reading.powered = false;
  b.ticks(10);
  b.device.reading.dead_man = false;
  b.ticks(10);
  b.device.reading.dead_man = true;
  b.ticks(300);
  EXPECT_EQ(b.felt(), 0);
  b.device.reading.powered = true;
  b.ticks(510);
  EXPECT_NEAR(b.felt(), 4, kRounding);
}

TEST_F(FaultTable, AShiftedArmLeavesTheToolBehindAndFindsItAgain) {
  b.device.reading.shifted = true;
  b.tick();
  EXPECT_EQ(b.felt(), 0);
  EXPECT_EQ(b.loop.sample().flags & kEngaged, 0u);
  const std::array<double, 3> tool{0.01, 0.02, 0.03};
  b.lie = [&](ProxySample& s) { s.proxy_pose.position = tool; };
  for (int i = 0; i < 50; ++i) {
    b.device.reading.state.position.x() += 1e-3;
    b.tick();
  }
  b.device.reading.shifted = false;
  b.tick();
  EXPECT_NEAR(b.loop.sample().pose.position[0], tool[0], kRounding) << "the hand begins at the tool";
  EXPECT_NEAR(b.loop.sample().pose.position[2], tool[2], kRounding);
  b.ticks(150);
  EXPECT_NEAR(b.felt(), 2, 0.1);  // ramp of 0.3 s
  b.ticks(160);
  EXPECT_NEAR(b.felt(), 4, kRounding);
  b.device.reading.state.position.x() += 1e-3;
  b.tick();
  EXPECT_NEAR(b.loop.sample().pose.position[0], tool[0] + 1e-3, kRounding);
}

TEST_F(FaultTable, TheReachOfAnArmIsToldInTheSceneAndMovesWithTheClutch) {
  LoopConfig config = config_for_tests();
  config.workspace.motion_scale = 2;
  Bench scaled(config);
  scaled.device.about.reach = DeviceReach{{0.1, 0, 0}, {0.2, 0.3, 0.4}};
  scaled.engage();
  const std::array<double, 3> half{0.4, 0.6, 0.8};
  EXPECT_EQ(scaled.loop.report().reach.half, half);
  EXPECT_NEAR(scaled.loop.report().reach.center[0], 0.2, kRounding);
  EXPECT_EQ(scaled.loop.report().motion_scale, 2);

  scaled.device.reading.shifted = true;
  scaled.lie = [](ProxySample& s) { s.proxy_pose.position = {0.01, 0.02, 0.03}; };
  scaled.device.reading.state.position.x() += 1e-3;
  scaled.tick();
  EXPECT_EQ(scaled.loop.report().reach.half, (std::array<double, 3>{})) << "nobody knows where the hand will begin";
  scaled.device.reading.shifted = false;
  scaled.tick();
  EXPECT_EQ(scaled.loop.report().reach.half, half);
  EXPECT_NEAR(scaled.loop.report().reach.center[0], 0.01 + 2 * (0.1 - 1e-3), kRounding) << "the hand is at the tool";
  EXPECT_NEAR(scaled.loop.report().reach.center[2], 0.03, kRounding);

  Bench unknown;
  unknown.engage();
  EXPECT_EQ(unknown.loop.report().reach.half, (std::array<double, 3>{}));
}

TEST_F(FaultTable, ATickFiveMillisecondsLateEndsTheForce) {
  const auto late_by = [&](std::int64_t ns) {
    b.now += kMillisecond + ns;
    const IncomingProxy in{b.next_answer(), b.now};
    b.loop.tick(b.now, ns, static_cast<std::uint32_t>(ns / kMillisecond), &in);
  };
  late_by(4'900'000);
  EXPECT_NEAR(b.felt(), 4, kRounding);
  late_by(5'100'000);
  EXPECT_EQ(b.felt(), 0);
  expect_locked();
}

TEST_F(FaultTable, TwentyLateTicksInARowEndTheForce) {
  const auto late = [&](int n) {
    for (int i = 0; i < n; ++i) {
      b.now += kMillisecond;
      const IncomingProxy in{b.next_answer(), b.now};
      b.loop.tick(b.now, 700'000, 0, &in);
    }
  };
  late(19);
  b.tick();
  late(19);
  EXPECT_NEAR(b.felt(), 4, kRounding);
  late(1);
  EXPECT_EQ(b.felt(), 0);
  expect_locked();
}

TEST_F(FaultTable, AStrainedArmGetsHalfTheForce) {
  b.device.reading.strained = true;
  b.ticks(20);
  EXPECT_NEAR(b.felt(), 2, kRounding);
  EXPECT_TRUE(b.loop.report().strained);
  b.device.reading.strained = false;
  b.ticks(20);
  EXPECT_NEAR(b.felt(), 4, kRounding);
}

// A force that the limit holds is halved, too.
TEST_F(FaultTable, AStrainedArmGetsHalfOfTheLargestForce) {
  b.force = {0, 0, 100};
  b.ticks(50);
  EXPECT_NEAR(b.felt(), 8, kRounding);
  b.device.reading.strained = true;
  b.ticks(50);
  EXPECT_NEAR(b.felt(), 4, kRounding);
}

TEST_F(FaultTable, FastToolsFeelDampingOnly) {
  b.device.reading.state.linear = {0, 1.6, 0};
  b.ticks(100);
  EXPECT_NEAR(b.device.written.force.y(), -3 * 1.6, kRounding);
  EXPECT_NEAR(b.device.written.force.z(), 0, kRounding);
  b.device.reading.state.linear = {0, 1.3, 0};  // not yet slow enough
  b.ticks(100);
  EXPECT_NEAR(b.device.written.force.z(), 0, kRounding);
  b.device.reading.state.linear.setZero();
  b.device.reading.state.angular = {0, 0, 6.1};
  b.ticks(100);
  EXPECT_NEAR(b.device.written.force.z(), 0, kRounding);
  EXPECT_NEAR(b.device.written.torque.z(), -0.03 * 6.1, kRounding);
  b.device.reading.state.angular.setZero();
  b.ticks(50);
  EXPECT_NEAR(b.felt(), 4, kRounding);
}

TEST_F(FaultTable, TheHandGetsNoMoreThanThePowerLimit) {
  b.force = {0, 0, 8};
  b.ticks(50);
  EXPECT_NEAR(b.felt(), 8, 1e-3);
  b.device.reading.state.linear = {0, 0, 1};
  b.ticks(5);
  EXPECT_LE(b.device.written.force.dot(b.device.reading.state.linear), 5 + kRounding);
  b.device.reading.state.linear = {0, 0, -1};  // taking power from the hand is no danger
  b.ticks(50);
  EXPECT_NEAR(b.felt(), 8, 0.2);
}

TEST(FaultTableLimits, MotorsStayWithinTheirContinuousRating) {
  LoopConfig config = config_for_tests();
  config.limits.force = 20;
  config.limits.continuous_force = 6;
  Bench b(config);
  b.force = {0, 0, 20};
  double mean = 0;
  for (int i = 0; i < 60000; ++i) {
    b.tick();
    mean += (b.felt() * b.felt() - mean) / 10000;
    ASSERT_LE(mean, 36.1) << i;
    if (i == 750) {
      ASSERT_NEAR(b.felt(), 20, kRounding) << "a short peak is allowed";
    }
  }
  EXPECT_NEAR(b.felt(), 6, 0.2);
}

TEST(FaultTableLimits, AxesAreLimitedBeforeTheLength) {
  LoopConfig config = config_for_tests();
  config.limits.axis_force = {1, 8, 3};
  Bench b(config);
  b.force = {-5, 0, 5};
  b.engage();
  EXPECT_NEAR((b.device.written.force - Eigen::Vector3d(-1, 0, 3)).norm(), 0, kRounding);
}

// Taken hold of anywhere, the tool stays where it is; scaled motion and force are felt as the profile's stiffness.
TEST(Clutch, BeginsAtTheToolAndScalesMotionAndForce) {
  LoopConfig config = config_for_tests();
  config.workspace = {3, 0.5, true};
  Bench b(config);
  b.force = {0, 0, 0};
  b.device.reading.state.position = {0.2, -0.3, 0.4};
  b.device.reading.state.orientation = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX());
  const Eigen::Quaterniond tool(Eigen::AngleAxisd(-0.7, Eigen::Vector3d::UnitY()));
  b.lie = [&](ProxySample& s) {  // a tool that something rigid holds
    s.proxy_pose = {{1, 2, 3}, {tool.x(), tool.y(), tool.z(), tool.w()}};
    s.blend = {1, 1};
    for (int k = 0; k < 3; ++k)
      s.wrench.force[k] = s.gains.stiffness * (s.proxy_pose.position[k] - s.device_pose.position[k]);
  };
  b.engage();
  EXPECT_NEAR((to_vector(b.loop.sample().pose.position) - Eigen::Vector3d(1, 2, 3)).norm(), 0, kRounding);
  EXPECT_NEAR(to_quaternion(b.loop.sample().pose.orientation).angularDistance(tool), 0, 1e-7);
  EXPECT_NEAR(b.felt(), 0, kRounding);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitZ()));
  b.device.reading.state.position.y() += 2e-3;
  b.device.reading.state.orientation = turn * b.device.reading.state.orientation;
  b.ticks(100);
  EXPECT_NEAR(b.loop.sample().pose.position[1], 2 + 3 * 2e-3, kRounding);
  EXPECT_NEAR(to_quaternion(b.loop.sample().pose.orientation).angularDistance(turn * tool), 0, 1e-7);
  EXPECT_NEAR(b.device.written.force.y(), -config.gains.stiffness * 2e-3, 1e-6);
}

TEST(Gains, AreLoweredTogetherWhileTheLinkIsSlow) {
  Bench b;
  b.engage();
  EXPECT_EQ(b.loop.sample().gains, b.loop.config().gains);
  const std::int64_t behind = 60 * kMillisecond;
  LoopConfig config = config_for_tests();
  config.round_trip_allowance_ns = behind;
  Bench slow(config);
  slow.engage();
  slow.lie = [&](ProxySample& s) { s.t_device_ns -= behind; };
  slow.ticks(200);
  const CouplingGains lowered = slow.loop.sample().gains;
  EXPECT_NEAR(lowered.stiffness * (0.0005 + 0.061), config.governor.budget, 1);
  EXPECT_NEAR(lowered.damping, 20 * std::sqrt(lowered.stiffness / 1000), 1e-9);
  slow.lie = nullptr;
  slow.force = {0, 0, 0};
  slow.ticks(200);
  const double forgotten = slow.loop.sample().gains.stiffness / lowered.stiffness;
  EXPECT_NEAR(forgotten, std::exp(0.2 / config.governor.memory), 0.01) << "a long delay is forgotten slowly";
  slow.force = {0, 0, 4};
  slow.ticks(200);
  EXPECT_NEAR(slow.loop.sample().gains.stiffness / lowered.stiffness, forgotten, 0.01)
      << "a spring that becomes stiffer while it is bent gives the hand energy";
  slow.force = {0, 0, 0};
  slow.ticks(10000);
  EXPECT_EQ(slow.loop.sample().gains, config.gains);
}

// A gap is over before a swing of the hand has turned: it feeds the swing as little as its mean does.
TEST(Gains, FallLittleForAGapAndFullyForADelayThatLasts) {
  const auto lowered_by = [](bool lasts) {
    GainGovernor governor({}, {4000, 20, 10, 0.2}, 1e-3);
    for (int tick = 0; tick < 1000; ++tick) {
      const int into = tick % 250;  // a gap of 30 ms in each quarter of a second
      const std::int64_t delay = kMillisecond * (lasts ? 30 : into < 30 ? into + 1 : 1);
      if (lasts || into >= 30) governor.note_delay(into == 30 ? 30 * kMillisecond : delay);
      governor.update(delay, 4, 0);
    }
    return governor.gains().stiffness;
  };
  EXPECT_NEAR(lowered_by(true), GovernorConfig{}.budget / 30.5e-3, 20);
  EXPECT_GT(lowered_by(false), 3900);
}

}  // namespace
}  // namespace palp::test::fault_table_test
