#include "haptic_bridge/loop/loop.h"

#include <algorithm>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "haptic_bridge/device/simulated.h"
#include "tests/haptic_bridge/loop/loop_bench.h"

namespace palp {
namespace {

using test::Bench;
using test::config_for_tests;
using test::kMillisecond;
using test::PuppetDevice;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kRounding = 1e-9;  // [N]

std::uint64_t count(const Bench& b, Verdict v) { return b.loop.report().verdicts[static_cast<std::size_t>(v)]; }

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

TEST(Loop, SingleLostSamplesChangeNothingOfAHeldWrench) {
  Bench b;
  b.engage();
  for (int i = 0; i < 300; ++i) {
    b.tick(i % 3 != 0);
    ASSERT_NEAR(b.felt(), 4, kRounding);
    ASSERT_EQ(b.loop.report().state, LoopState::engaged);
  }
}

TEST(Loop, LosingTheServerFadesMonotonouslyToZeroWithin100Ticks) {
  Bench b;
  b.engage();
  double before = b.felt();
  int zero_at = 0;
  for (int i = 1; i <= 200; ++i) {
    b.tick(false);
    ASSERT_LE(b.felt(), before + kRounding) << i;
    ASSERT_NEAR(b.felt(), 4 * std::clamp((60 - i) / 40.0, 0.0, 1.0), 0.2) << i;
    if (b.felt() == 0 && zero_at == 0) zero_at = i;
    before = b.felt();
  }
  EXPECT_GT(zero_at, 50);
  EXPECT_LE(zero_at, 100);
  EXPECT_EQ(b.loop.report().state, LoopState::stale);
  EXPECT_EQ(b.loop.report().stale_events, 1u);
}

TEST(Loop, EvenTheLargestForceIsGoneWithin100Ticks) {
  LoopConfig config = config_for_tests();
  config.limits = {35, 3, 300, 30};
  Bench b(config);
  b.force = {0, 35, 0};
  b.engage();
  EXPECT_NEAR(b.felt(), 35, kRounding);
  b.ticks(100, false);
  EXPECT_EQ(b.felt(), 0);
}

TEST(Loop, FadesIntoDampingWhileTheHandMoves) {
  Bench b;
  b.engage();
  b.device.reading.state.linear = {0, 0.5, 0};
  b.ticks(70, false);
  EXPECT_NEAR(b.device.written.force.y(), -3 * 0.5, kRounding);
  EXPECT_NEAR(b.device.written.force.z(), 0, kRounding);
  EXPECT_EQ(b.loop.report().state, LoopState::degraded);
  b.ticks(30, false);
  EXPECT_EQ(b.felt(), 0);
}

TEST(Loop, ComesBackWithFreshDataOnly) {
  Bench b;
  b.engage();
  b.ticks(150, false);
  b.ticks(150);
  EXPECT_EQ(b.felt(), 0);
  b.ticks(30, false);  // a gap: the 200 ms begin again
  b.ticks(150);
  EXPECT_EQ(b.felt(), 0);
  b.ticks(60);
  EXPECT_GT(b.felt(), 0);
  b.ticks(600);
  EXPECT_NEAR(b.felt(), 4, kRounding);
}

TEST(Loop, ARestartedServerIsTakenAndFeltOnANewRamp) {
  Bench b;
  b.engage();
  const std::uint64_t old_session = b.session;
  b.session = 6;
  b.sequence = 0;
  b.tick();
  EXPECT_EQ(b.loop.report().server_session, 6u);
  EXPECT_NEAR(b.felt(), 4 - 0.3, kRounding);  // down no faster than the slew limit
  b.ticks(20);
  EXPECT_EQ(b.felt(), 0);
  EXPECT_EQ(b.loop.report().state, LoopState::ready);
  b.session = old_session;  // a late sample of the one before
  b.sequence = 2000;
  b.tick();
  EXPECT_EQ(count(b, Verdict::out_of_order), 1u);
  b.session = 6;
  b.sequence = 100;
  b.ticks(750);
  EXPECT_NEAR(b.felt(), 4, kRounding);
}

// An answer that a server sends again makes nothing younger, unless it was lost the first time.
TEST(Loop, TakesAnAnswerOnceHoweverOftenItIsSent) {
  Bench b;
  b.engage();
  ProxySample again = b.next_answer();
  IncomingProxy in{again, b.now += kMillisecond};
  b.loop.tick(b.now, 0, 0, &in);
  const std::uint64_t used = b.loop.record().sequence;
  for (int k = 1; k <= 3; ++k) {
    in.sample.flags |= kRepeated;
    in.sample.header.sequence = ++b.sequence;
    in.t_receive_ns = b.now += kMillisecond;
    b.loop.tick(b.now, 0, 0, &in);
    EXPECT_EQ(b.loop.record().age_ns, k * kMillisecond);
    EXPECT_EQ(b.loop.record().sequence, used);
    EXPECT_EQ(count(b, Verdict::repeated), static_cast<std::uint64_t>(k));
  }
  EXPECT_EQ(b.loop.report().passed_over, 0u);
  in.sample = b.next_answer();  // whose first sending was lost
  in.sample.flags |= kRepeated;
  in.t_receive_ns = b.now += kMillisecond;
  b.loop.tick(b.now, 0, 0, &in);
  EXPECT_EQ(b.loop.record().age_ns, 0);
  EXPECT_EQ(b.loop.record().sequence, in.sample.header.sequence);
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

TEST(Loop, DropsWhatIsNotSoundAndCountsIt) {
  struct Case {
    const char* name;
    Verdict verdict;
    std::function<void(ProxySample&)> lie;
  };
  const std::vector<Case> cases{
      {"force", Verdict::not_finite, [](ProxySample& s) { s.wrench.force[1] = kNan; }},
      {"torque", Verdict::not_finite, [](ProxySample& s) { s.wrench.torque[0] = -HUGE_VAL; }},
      {"pose", Verdict::not_finite, [](ProxySample& s) { s.device_pose.position[0] = kNan; }},
      {"proxy", Verdict::not_finite, [](ProxySample& s) { s.proxy_pose.orientation[0] = kNan; }},
      {"twist", Verdict::not_finite, [](ProxySample& s) { s.device_twist.angular[2] = kNan; }},
      {"gain", Verdict::not_finite, [](ProxySample& s) { s.gains.damping = kNan; }},
      {"energy", Verdict::not_finite, [](ProxySample& s) { s.energy[1] = kNan; }},
      {"quaternion", Verdict::bad_range, [](ProxySample& s) { s.device_pose.orientation[3] = 0.9; }},
      {"proxy quaternion", Verdict::bad_range,
       [](ProxySample& s) {
         s.proxy_pose.orientation = {0, 0, 0, 0};
       }},
      {"blend", Verdict::bad_range, [](ProxySample& s) { s.blend[0] = 1.01; }},
      {"blend below", Verdict::bad_range, [](ProxySample& s) { s.blend[1] = -0.01; }},
      {"absurd force", Verdict::bad_range, [](ProxySample& s) { s.wrench.force[0] = 1e300; }},
      {"future", Verdict::bad_range, [](ProxySample& s) { s.t_device_ns += 1000 * kMillisecond; }},
      {"no stamp", Verdict::bad_range, [](ProxySample& s) { s.t_device_ns = 0; }},
      {"device", Verdict::bad_range, [](ProxySample& s) { s.device = 1; }},
      {"stiffness", Verdict::bad_gains, [](ProxySample& s) { s.gains.stiffness = 1001; }},
      {"damping", Verdict::bad_gains, [](ProxySample& s) { s.gains.damping = -1; }},
      {"angular stiffness", Verdict::bad_gains, [](ProxySample& s) { s.gains.angular_stiffness = 1e9; }},
      {"sequence back", Verdict::out_of_order, [](ProxySample& s) { s.header.sequence = 900; }},
      {"other bridge", Verdict::other_bridge, [](ProxySample& s) { s.device_session = 78; }},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    Bench b;
    b.engage();
    const std::uint64_t good = count(b, Verdict::accepted);
    b.force = {0, 0, -6};
    b.lie = c.lie;
    b.tick();
    EXPECT_EQ(count(b, c.verdict), 1u);
    EXPECT_EQ(count(b, Verdict::accepted), good);
    EXPECT_NEAR(b.felt(), 4, kRounding);  // as if it had been lost
    b.ticks(100);
    EXPECT_EQ(b.felt(), 0);  // nothing else came: that server is lost
  }
}

TEST(Loop, AnswersToOldDeviceStatesAreStaleHoweverFreshTheyArrive) {
  Bench b;
  b.engage();
  const std::int64_t heard_last = b.loop.sample().t_device_ns;
  b.lie = [&](ProxySample& s) { s.t_device_ns = heard_last; };
  b.ticks(110);
  EXPECT_EQ(b.loop.report().state, LoopState::stale);
  EXPECT_EQ(b.felt(), 0);
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

TEST(Loop, RendersContactBetweenSamples) {
  // samples every 4 ms, a hand that presses on: the wall pushes back each millisecond
  Bench b;
  b.force = {0, 0, 0};
  b.lie = [](ProxySample& s) { test::SpringWall{}.touch(s); };
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
        in = {test::answer(in_flight.front(), 5, static_cast<std::uint64_t>(i)), now};
        in_flight.pop_front();
        test::SpringWall{}.touch(in.sample);
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
}  // namespace palp
