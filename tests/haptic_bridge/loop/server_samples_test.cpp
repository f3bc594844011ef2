// The loop before a server whose samples are lost, late, sent again or unsound.
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "tests/haptic_bridge/loop/loop_bench.h"

namespace palp::test::server_samples_test {
namespace {

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
  EXPECT_EQ(b.count(Verdict::out_of_order), 1u);
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
    EXPECT_EQ(b.count(Verdict::repeated), static_cast<std::uint64_t>(k));
  }
  EXPECT_EQ(b.loop.report().passed_over, 0u);
  in.sample = b.next_answer();  // whose first sending was lost
  in.sample.flags |= kRepeated;
  in.t_receive_ns = b.now += kMillisecond;
  b.loop.tick(b.now, 0, 0, &in);
  EXPECT_EQ(b.loop.record().age_ns, 0);
  EXPECT_EQ(b.loop.record().sequence, in.sample.header.sequence);
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
    const std::uint64_t good = b.count(Verdict::accepted);
    b.force = {0, 0, -6};
    b.lie = c.lie;
    b.tick();
    EXPECT_EQ(b.count(c.verdict), 1u);
    EXPECT_EQ(b.count(Verdict::accepted), good);
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

}  // namespace
}  // namespace palp::test::server_samples_test
