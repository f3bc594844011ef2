// The driver of the Virtuose in the loop, before the simulated arm, in lock step: whatever happens to the arm, each
// wrench is within its limits, the arm ends safe, and the reason is told.
#include <random>

#include "haptic_bridge/loop/loop.h"
#include "tests/haptic_bridge/device/virtuose_bench.h"
#include "tests/haptic_bridge/loop/fake_server.h"
#include "tests/support/seed.h"

namespace palp::test::virtuose_loop_test {
namespace {

constexpr double kRounding = 1e-9;       // [N]
constexpr float kFloatRounding = 2e-6F;  // of ten newtons in float

// Returns script lines for what goes wrong in a run of a few seconds, drawn at random.
std::string mishaps(std::mt19937& random,
                    const std::function<std::string(const std::string&, double, double, const std::string&)>& event) {
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const std::vector<std::pair<std::string, std::string>> kinds{
      {"dead_man_up", ""},      {"power_off", ""},
      {"emergency_stop", ""},   {"shift", ""},
      {"bound", "value = 2"},   {"alarm", "value = 32768"},
      {"nan_position", ""},     {"bad_quaternion", ""},
      {"jump", "value = 0.2"},  {"freeze", ""},
      {"error", "value = 2"},   {"error", "value = 6"},
      {"slow", "value = 0.01"}, {"error", "value = 8\ncall = \"virtSetForce\""}};
  std::string text;
  const int n = 1 + static_cast<int>(random() % 6);
  for (int i = 0; i < n; ++i) {
    const auto& [name, more] = kinds[random() % kinds.size()];
    text += event(name, between(0.1, 2.5), random() % 2 ? between(0.001, 0.015) : between(0.02, 0.6), more);
  }
  return text;
}

class VirtuoseLoop : public VirtuoseBench {
 protected:
  LoopConfig config() const {
    LoopConfig c;
    c.own_session = kBridgeSession;
    c.limits = {10, 1, 300, 30};
    c.fresh_ns = 20'000'000;
    c.ramp_up = 0.1;
    return c;
  }
  void begin(const VirtuoseSetup& s) {
    loop_.reset();
    open(s);
    loop_ = std::make_unique<HapticLoop>(config(), *device_);
    before_ = zero_wrench();
    sequence_ = 0;
  }
  void TearDown() override {
    loop_.reset();
    VirtuoseBench::TearDown();
  }
  // One tick before a server that pushes the hand back to where it began. Checks what must always hold.
  void tick() {
    now_ += kTickNs;
    IncomingProxy in;
    const bool answered = loop_->report().ticks > 0;
    if (answered) {
      in = {answer(loop_->sample(), 5, ++sequence_), now_};
      for (int i = 0; i < 3; ++i)
        in.sample.wrench.force[i] =
            pull_ * (kStart.position[i] - in.sample.device_pose.position[i]) + (i == 2 ? bias_ : 0);
    }
    loop_->tick(now_, 0, 0, answered ? &in : nullptr);

    const TickRecord& r = loop_->record();
    const Wrench<double>& w = r.sent;
    ASSERT_TRUE(is_finite(w));
    ASSERT_LE(w.force.norm(), 10 + kRounding);
    ASSERT_LE(w.torque.norm(), 1 + kRounding);
    const bool zero = w.force.isZero(0) && w.torque.isZero(0);
    if (!r.good_reading || !r.engaged_device || r.cut) {
      ASSERT_TRUE(zero) << "state " << to_string(r.state);
    } else if (!r.reduced) {
      ASSERT_LE((w.force - before_.force).norm(), 0.3 + kRounding);
    }
    ASSERT_TRUE(is_finite(to_state(loop_->sample().pose, loop_->sample().twist)));
    felt_ += !zero;
    before_ = w;
  }
  bool faulty() const { return loop_->report().fault != LoopFault::none; }
  // Ticks until a fault or the end, as run_loop does.
  void run(int n) {
    for (int i = 0; i < n && !faulty() && !HasFatalFailure(); ++i) tick();
  }
  // Checks the simulated arm's own view: it rendered nothing past the limits, and nothing without a hand or power.
  void check_rendered() {
    loop_.reset();
    for (const std::vector<double>& row : trace()) {
      const Eigen::Vector3d force(row[6], row[7], row[8]), torque(row[9], row[10], row[11]);
      ASSERT_LE(force.norm(), 10 * (1 + static_cast<double>(kFloatRounding)));
      ASSERT_LE(torque.norm(), 1 * (1 + static_cast<double>(kFloatRounding)));
      if (row[1] == 0 || row[2] == 0) {
        ASSERT_TRUE(force.isZero(0) && torque.isZero(0)) << row[0];
      }
    }
  }
  // Checks that the arm was left as it must be.
  void check_left_safe() {
    loop_.reset();
    const std::vector<LoggedCall> all = calls();
    EXPECT_EQ(all.back().name, "virtClose");
    const auto power =
        std::find_if(all.rbegin(), all.rend(), [](const LoggedCall& c) { return c.name == "virtSetPowerOn"; });
    EXPECT_EQ(power->arguments.substr(0, 2), " 0");
    for (const LoggedCall& c : all) EXPECT_NE(c.name, "order:") << c.arguments;
  }

  std::unique_ptr<HapticLoop> loop_;
  Wrench<double> before_ = zero_wrench();
  std::uint64_t sequence_ = 0;
  double pull_ = 300, bias_ = 2;
  static constexpr double kAtRest = 2.0 * 500 / (500 + 300);  // against the spring of the hand [N]
  long felt_ = 0;
};

const std::string kHeld = "grip_at = 0.1\nrelay_delay = 0\n";

TEST_F(VirtuoseLoop, FeelsTheServerOnceAllSwitchesAllowIt) {
  VirtuoseSetup s = setup("grip_at = 3.1\n");
  s.relay_time = 3;
  begin(s);
  run(3000);
  EXPECT_EQ(felt_, 0);
  run(500);
  EXPECT_EQ(loop_->report().state, LoopState::engaged);
  EXPECT_NEAR(loop_->record().sent.force.z(), kAtRest, 0.1);
  check_rendered();
}

TEST_F(VirtuoseLoop, LimitsHoldInEveryTickOfEverySchedule) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (int i = 0; i < 24 && !HasFatalFailure(); ++i) {
    const std::string events = mishaps(random, [](const auto& name, double time, double duration, const auto& more) {
      return event(name, time, duration, more);
    });
    SCOPED_TRACE(events);
    VirtuoseSetup s = setup(kHeld + events);
    if (i % 3 == 2) s.mode = VirtuoseMode::mechanism;
    begin(s);
    run(3000);
    if (faulty()) {
      EXPECT_FALSE(device_->trouble().empty() && loop_->report().fault == LoopFault::device_write);
    }
    check_rendered();
    check_left_safe();
  }
  EXPECT_GT(felt_, 5000);
}

TEST_F(VirtuoseLoop, AReleasedDeadManEndsTheForceInItsTickAndAGripBringsItBack) {
  begin(setup(kHeld + event("dead_man_up", 0.9995, 0.2)));
  run(999);
  EXPECT_GT(loop_->record().sent.force.norm(), 1);
  run(1);
  EXPECT_EQ(loop_->record().sent.force.norm(), 0);
  EXPECT_TRUE(loop_->record().cut);
  run(199);
  EXPECT_EQ(loop_->record().sent.force.norm(), 0);
  run(1000);
  EXPECT_GT(loop_->record().sent.force.norm(), 0.5);
  check_left_safe();
}

TEST_F(VirtuoseLoop, AFatalErrorEndsTheForceInItsTickAndTheRunWithItsReason) {
  begin(setup(kHeld + event("error", 0.9995, 0, "call = \"virtGetSpeed\"\nvalue = 12")));
  run(999);
  EXPECT_GT(loop_->record().sent.force.norm(), 1);
  run(1);
  EXPECT_EQ(loop_->record().sent.force.norm(), 0);
  run(100);
  EXPECT_EQ(loop_->report().fault, LoopFault::device_read);
  EXPECT_LE(loop_->report().ticks, 1025u);
  EXPECT_NE(device_->trouble().find("virtGetSpeed failed: the position has jumped (error 12)"), std::string::npos)
      << device_->trouble();
  check_left_safe();
}

TEST_F(VirtuoseLoop, AJumpOfThePoseIsNoReading) {
  begin(setup(kHeld + event("jump", 0.9995, 0.003, "value = 0.3")));
  run(999);
  const std::uint64_t bad = loop_->report().bad_readings;
  run(1);
  EXPECT_EQ(loop_->record().sent.force.norm(), 0);
  EXPECT_EQ(loop_->report().bad_readings, bad + 1);
  run(1000);
  EXPECT_FALSE(faulty());
  EXPECT_GT(loop_->record().sent.force.norm(), 1);
}

TEST_F(VirtuoseLoop, ALinkThatStaysBrokenIsAFaultWithItsReason) {
  begin(setup(kHeld + event("error", 0.9995, 0, "value = 2")));
  run(2000);
  EXPECT_TRUE(faulty());
  EXPECT_LE(loop_->report().ticks, 1025u);
  EXPECT_NE(device_->trouble().find("failed: the controller does not answer (error 2)"), std::string::npos);
}

TEST_F(VirtuoseLoop, MechanismModeRendersWhatTheLoopSends) {
  VirtuoseSetup s = setup(kHeld);
  s.mode = VirtuoseMode::mechanism;
  begin(s);
  run(2000);
  EXPECT_NEAR(loop_->record().sent.force.z(), kAtRest, 0.1);
  const Eigen::Vector3d sent = loop_->record().sent.force;
  check_rendered();
  const std::vector<double> last = trace().back();
  EXPECT_NEAR(last[8], sent.z(), 0.02);  // up is up in both frames
  check_left_safe();
}

}  // namespace
}  // namespace palp::test::virtuose_loop_test
