// The server's treatment of a device's samples: which it takes, how far it moves them on, when a hand has let go.
#include "sim_server/device_tracker.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palp::test::device_tracker_test {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr double kStep = 1e-3;

DeviceSample sample(std::uint64_t sequence, double x, double speed) {
  DeviceSample s;
  s.header.session = 1;
  s.header.sequence = sequence;
  s.flags = kEngaged | kHealthy;
  s.pose = {{x, 0, 0}, {0, 0, 0, 1}};
  s.twist = {{speed, 0, 0}, {0, 0, 2}};
  s.gains = {1000, 20, 10, 0.2};
  return s;
}

RigidState proxy_at(double x) {
  RigidState s;
  s.position.x() = x;
  return s;
}

TEST(DeviceTracker, MovesOnForAsLongAsTheSampleHasWaited) {
  DeviceTracker tracker;
  tracker.receive(sample(1, 0.01, 0.5), 5 * kMillisecond);
  const DeviceInput in = tracker.input(8 * kMillisecond, kStep, proxy_at(0.01));
  EXPECT_NEAR(in.state.position.x(), 0.01 + 0.5 * 3e-3, 1e-12);
  const Eigen::AngleAxisd turn(in.state.orientation);
  EXPECT_NEAR(turn.angle(), 2 * 3e-3, 1e-9);
  EXPECT_NEAR(turn.axis().z(), 1, 1e-9);
}

// Neither a clock that jumped, nor a speed that no hand has, moves it far.
TEST(DeviceTracker, NeverMovesOnFurtherThanAHandMayInAFewMilliseconds) {
  for (const double speed : {0.5, 5.0, 1e6}) {
    for (const std::int64_t age_ms : {-70, 0, 4, 20, 70}) {
      DeviceTracker tracker;
      tracker.receive(sample(1, 0, speed), 1000 * kMillisecond);
      const double x = tracker.input((1000 + age_ms) * kMillisecond, kStep, proxy_at(0)).state.position.x();
      EXPECT_GE(x, 0);
      EXPECT_LE(x, std::min(speed, kFastestHand) * (kMostAhead + kStep) * (1 + 1e-12))
          << speed << " m/s, " << age_ms << " ms";
    }
  }
}

// While nothing is heard of it, it neither stops at once nor goes on for ever, and its velocity is that of its way.
TEST(DeviceTracker, SlowsDownWhileNothingIsHeard) {
  DeviceTracker tracker;
  tracker.receive(sample(1, 0, 0.5), 0);
  DeviceInput before = tracker.input(0, kStep, proxy_at(0));
  for (int ms = 1; ms < 50; ++ms) {
    const DeviceInput in = tracker.input(ms * kMillisecond, kStep, proxy_at(0));
    ASSERT_TRUE(in.engaged);
    const double way = in.state.position.x() - before.state.position.x();
    EXPECT_NEAR(way / kStep, (in.state.linear.x() + before.state.linear.x()) / 2, 1e-3) << ms << " ms";
    EXPECT_LE(in.state.linear.x(), before.state.linear.x());
    EXPECT_NEAR(in.state.linear.x() / 0.5, ms <= 6 ? 1 : std::exp(-(ms - 6) * 1e-3 / kSlowsDown), 1e-9);
    EXPECT_NEAR(in.state.angular.z() / 2, in.state.linear.x() / 0.5, 1e-9);
    before = in;
  }
  EXPECT_LT(before.state.position.x(), 0.5 * (kMostAhead + kSlowsDown));
}

// In steps, whatever the clock says: the same samples before the same steps give the same motion.
TEST(DeviceTracker, LetsGoAfterAsManyStepsOfSilence) {
  for (const std::int64_t clock : {std::int64_t{0}, std::int64_t{1}, 100 * kMillisecond}) {
    DeviceTracker tracker;
    tracker.receive(sample(1, 0, 0), 0);
    int held = 0;
    while (tracker.input(held * clock, kStep, proxy_at(0)).engaged) ASSERT_LT(++held, 1000);
    EXPECT_EQ(held, 50);
    EXPECT_FALSE(tracker.engaged());
    tracker.receive(sample(2, 0, 0), held * clock);
    EXPECT_TRUE(tracker.input(held * clock, kStep, proxy_at(0)).engaged);
  }
}

TEST(DeviceTracker, TakesNoOlderSampleOfASession) {
  DeviceTracker tracker;
  tracker.receive(sample(5, 0.02, 0), 0);
  tracker.receive(sample(4, 0.05, 0), 0);
  EXPECT_NEAR(tracker.input(0, kStep, proxy_at(0)).state.position.x(), 0.02, 1e-12);
  DeviceSample other = sample(1, 0.03, 0);
  other.header.session = 2;
  tracker.receive(other, 0);
  EXPECT_NEAR(tracker.input(0, kStep, proxy_at(0)).state.position.x(), 0.03, 1e-12);
}

// Its tool is not thrown to where another hand is.
TEST(DeviceTracker, ANewHandTakesHoldGentlyWhereAnotherOneHeld) {
  DeviceTracker tracker;
  for (std::uint64_t k = 1; k <= 400; ++k) {
    tracker.receive(sample(k, 0, 0), 0);
    tracker.input(0, kStep, proxy_at(0));
  }
  DeviceSample other = sample(1, 0.05, 0);
  other.header.session = 2;
  tracker.receive(other, 0);
  const DeviceInput in = tracker.input(0, kStep, proxy_at(0));
  EXPECT_NEAR(in.gains.stiffness, 1000 * kStep / kEaseIn, 1e-9);
}

// A recording that is replayed a second time begins with the numbers that it began with before.
TEST(DeviceTracker, TakesASessionThatBeginsAnewAfterSilence) {
  DeviceTracker tracker;
  tracker.receive(sample(500, 0.02, 0), 0);
  for (int k = 0; k < 199; ++k) {
    tracker.receive(sample(1, 0.03, 0), 0);
    ASSERT_NEAR(tracker.sample().pose.position[0], 0.02, 1e-12) << k;
    tracker.input(0, kStep, proxy_at(0));
  }
  for (int k = 0; k < 3; ++k) tracker.input(0, kStep, proxy_at(0));
  tracker.receive(sample(1, 0.03, 0), 0);
  const DeviceInput in = tracker.input(0, kStep, proxy_at(0));
  EXPECT_TRUE(in.engaged);
  EXPECT_NEAR(in.state.position.x(), 0.03, 1e-12);
}

TEST(DeviceTracker, PullsNoHarderThanItMay) {
  DeviceTracker tracker;
  tracker.receive(sample(1, 10, 0), 0);
  DeviceInput in;
  for (int k = 0; k < 400; ++k) {
    tracker.receive(sample(static_cast<std::uint64_t>(k) + 2, 10, 0), 0);
    in = tracker.input(0, kStep, proxy_at(1));
  }
  EXPECT_EQ(in.gains.stiffness, 1000);
  EXPECT_NEAR(in.gains.stiffness * (in.state.position.x() - 1), kStrongestPull, 1e-9);
}

}  // namespace
}  // namespace palp::test::device_tracker_test
