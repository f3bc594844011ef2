// The loop before a device whose hand lets go, whose readings cannot be, or that fails.
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "tests/haptic_bridge/loop/loop_bench.h"

namespace palp::test::device_readings_test {
namespace {

TEST(Loop, ALiftedHandEndsTheForceInTheSameTick) {
  Bench b;
  b.engage();
  b.device.reading.dead_man = false;
  b.tick();
  EXPECT_EQ(b.felt(), 0);
  EXPECT_EQ(b.loop.report().cuts, 1u);
  EXPECT_EQ(b.loop.sample().flags & kEngaged, 0u);
  b.device.reading.dead_man = true;
  b.tick();
  EXPECT_LE(b.felt(), 0.3);
  b.ticks(600);
  EXPECT_NEAR(b.felt(), 4, kRounding);
}

TEST(Loop, ImpossibleReadingsCutTheForceAndNeverReachTheServer) {
  const std::vector<std::function<void(PuppetDevice&)>> faults{
      [](PuppetDevice& d) { d.readable = false; },
      [](PuppetDevice& d) { d.reading.state.position.x() = kNan; },
      [](PuppetDevice& d) { d.reading.state.orientation.w() = 2; },
      [](PuppetDevice& d) { d.reading.state.angular.z() = HUGE_VAL; },
      [](PuppetDevice& d) { d.reading.state.linear.z() = 100; },
      [](PuppetDevice& d) { d.reading.state.position.y() += 0.05; },
      [](PuppetDevice& d) { d.reading.state.orientation = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()); },
  };
  for (std::size_t i = 0; i < faults.size(); ++i) {
    SCOPED_TRACE(i);
    Bench b;
    b.engage();
    const DeviceReading good = b.device.reading;
    faults[i](b.device);
    b.tick();
    EXPECT_EQ(b.felt(), 0);
    EXPECT_EQ(b.loop.report().bad_readings, 1u);
    EXPECT_EQ(b.loop.sample().flags & (kEngaged | kHealthy), 0u);
    EXPECT_EQ(b.loop.sample().pose, to_pose(good.state));
    b.device.reading = good;
    b.device.readable = true;
    b.ticks(600);
    EXPECT_NEAR(b.felt(), 4, kRounding);
    EXPECT_EQ(b.loop.report().fault, LoopFault::none);
  }
}

// The controller of the arm and the bridge tick by clocks of their own: two of its steps may lie between two readings.
TEST(Loop, AFastHandKeepsItsForceWhereTheArmsClockIsNotTheBridges) {
  Bench b;
  b.engage();
  RigidState& hand = b.device.reading.state;
  hand.linear.y() = 4;
  for (int i = 0; i < 40; ++i) {
    for (int step = i % 2 == 0 ? 2 : 0; step > 0; --step) hand.position.y() += 1e-3 * hand.linear.y();
    b.tick();
    ASSERT_FALSE(b.loop.record().cut) << "tick " << i;
  }
  EXPECT_EQ(b.loop.report().bad_readings, 0u);
}

TEST(Loop, AFailingDeviceIsAFaultForGood) {
  Bench b;
  b.engage();
  b.device.readable = false;
  b.ticks(20);
  EXPECT_EQ(b.loop.report().fault, LoopFault::none);
  b.tick();
  EXPECT_EQ(b.loop.report().fault, LoopFault::device_read);
  b.device.readable = true;
  b.ticks(2000);
  EXPECT_EQ(b.loop.report().state, LoopState::fault);
  EXPECT_EQ(b.felt(), 0);

  Bench c;
  c.engage();
  c.device.writable = false;
  c.ticks(21);
  EXPECT_EQ(c.loop.report().fault, LoopFault::device_write);
  EXPECT_EQ(c.loop.report().state, LoopState::fault);
}

}  // namespace
}  // namespace palp::test::device_readings_test
