// Randomised schedules: whatever the server, the bus, the device and the scheduler do, the wrench stays within its
// limits in every tick, and the same schedule gives the same wrenches, bit for bit.
#include <bit>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "haptic_bridge/device/simulated.h"
#include "haptic_bridge/loop.h"
#include "tests/bridge/fake_server.h"
#include "tests/support/seed.h"

namespace palp {
namespace {

using test::kMillisecond;

constexpr double kRounding = 1e-9;
#ifdef __SANITIZE_ADDRESS__
constexpr int kSchedules = 1000;  // the sanitizer makes them forty times slower
#else
constexpr int kSchedules = 10000;
#endif
constexpr int kTicks = 60;          // per short schedule
constexpr int kLongSchedules = 30;  // long enough to engage, go stale and come back
constexpr int kLongTicks = 3000;

// A world that does everything wrong, by the draw of its seed.
class Mischief {
 public:
  explicit Mischief(std::uint64_t seed) : random_(seed) {
    for (double* p : {&lose_, &lie_, &glitch_, &lift_, &late_, &restart_}) *p = chance(0.5) ? 0 : 0.2 * unit() * unit();
    scale_ = std::pow(10, 4 * unit() - 1);  // 0.1 .. 1000 N
    reorder_ = chance(0.3);
  }

  LoopConfig config() {
    LoopConfig c;
    c.own_session = test::kBridgeSession;
    c.limits = {0.5 + 30 * unit(), 0.1 + 2 * unit(), 50 + 500 * unit(), 5 + 50 * unit()};
    if (chance(0.5)) {  // quick to engage, so that short schedules feel something
      c.fresh_ns = 0;
      c.ramp_up = 0.01;
    }
    return c;
  }
  bool chance(double p) { return unit() < p; }
  bool lift() { return chance(lift_); }
  std::int64_t wait_ns() { return chance(late_) ? std::llround(60e6 * unit() * unit()) + kMillisecond : kMillisecond; }

  // What comes in this tick, if anything.
  bool next(const DeviceSample& device, std::int64_t now, IncomingProxy& in) {
    if (chance(silence_left_ > 0 ? 0 : 0.001)) silence_left_ = static_cast<int>(200 * unit());
    if (silence_left_ > 0) {
      --silence_left_;
      return false;
    }
    if (chance(lose_)) return false;
    if (chance(restart_)) session_ = 1 + random_() % 3, sequence_ = 0;
    in.sample = test::answer(device, session_, ++sequence_);
    in.t_receive_ns = now;
    if (reorder_ && chance(0.1)) in.sample.header.sequence = 1 + random_() % (sequence_ + 2);
    for (int i = 0; i < 3; ++i) {
      in.sample.wrench.force[i] = scale_ * normal_(random_);
      in.sample.wrench.torque[i] = 0.1 * scale_ * normal_(random_);
    }
    in.sample.blend = {unit(), unit()};
    in.sample.flags = chance(0.02) ? static_cast<std::uint32_t>(random_() % 8) : kEngaged | kHealthy;
    if (chance(lie_)) lie(in.sample);
    return true;
  }

  void glitch(DeviceReading& r) {
    if (!chance(glitch_)) return;
    double* const targets[] = {&r.state.x.x(), &r.state.q.w(), &r.state.v.y(), &r.state.w.z()};
    *targets[random_() % 4] = bad_number();
  }

 private:
  double unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  double bad_number() {
    const double kBad[] = {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL, 1e308, -1e308, 1e-310, 1e7};
    return kBad[random_() % 7];
  }
  void lie(ProxySample& s) {
    double* const targets[] = {&s.wrench.force[0],
                               &s.wrench.torque[1],
                               &s.device_pose.position[2],
                               &s.device_pose.orientation[3],
                               &s.proxy_pose.orientation[0],
                               &s.device_twist.linear[0],
                               &s.device_twist.angular[1],
                               &s.gains.stiffness,
                               &s.gains.angular_damping,
                               &s.blend[0],
                               &s.energy[1],
                               &s.proxy_pose.position[1]};
    if (chance(0.2)) {
      s.t_device_ns = static_cast<std::int64_t>(random_());
    } else if (chance(0.2)) {
      s.device = static_cast<std::uint32_t>(random_() % 3);
    } else {
      *targets[random_() % 12] = bad_number();
    }
  }

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  double lose_, lie_, glitch_, lift_, late_, restart_, scale_;
  bool reorder_;
  int silence_left_ = 0;
  std::uint64_t session_ = 1, sequence_ = 0;
};

// An arm whose readings go wrong now and then.
class MischievousArm final : public HapticDevice {
 public:
  explicit MischievousArm(Mischief& mischief)
      : mischief_(mischief),
        arm_(ArmModel{}, HandScript{}, at_rest(Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()),
             at_rest(Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity())) {}
  const DeviceInfo& info() const noexcept override { return arm_.info(); }
  bool read(std::int64_t now, DeviceReading& out) noexcept override {
    const bool good = arm_.read(now, out);
    mischief_.glitch(out);
    out.dead_man = held_ && !mischief_.lift();
    held_ = true;
    return good;
  }
  void show(LoopState state) noexcept override {
    if (state == LoopState::locked) held_ = false;
  }
  bool write(const Wrench<double>& w) noexcept override {
    written = w;
    return arm_.write(w);
  }
  Wrench<double> written = zero_wrench();

 private:
  Mischief& mischief_;
  SimulatedDevice arm_;
  bool held_ = false;
};

struct Outcome {
  std::uint64_t hash = 1469598103934665603u;  // of every wrench sent
  int felt = 0;                               // ticks with force
  void add(double x) { hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 1099511628211u; }
};

Outcome run_schedule(std::uint64_t seed, int ticks) {
  Mischief mischief(seed);
  const LoopConfig config = mischief.config();
  MischievousArm arm(mischief);
  HapticLoop loop(config, arm);
  const WrenchLimits limits = loop.config().limits;
  Outcome outcome;
  Wrench<double> before = zero_wrench();
  std::int64_t now = 1'000'000'000, last_good = now;
  for (int i = 0; i < ticks; ++i) {
    const std::int64_t wait = mischief.wait_ns();
    now += wait;
    IncomingProxy in;
    const bool came = mischief.next(loop.sample(), now, in);
    loop.tick(now, wait - kMillisecond, static_cast<std::uint32_t>(wait / kMillisecond - 1), came ? &in : nullptr);

    const Wrench<double>& w = arm.written;
    const TickRecord& r = loop.record();
    if (r.verdict == 0 || r.verdict == 1) last_good = now;
    const auto fail = [&](const char* what) { ADD_FAILURE() << what << " seed " << seed << " tick " << i; };
    if (!is_finite(w)) fail("not finite");
    if (w.force.norm() > limits.force + kRounding || w.torque.norm() > limits.torque + kRounding) fail("limit");
    const double dt = 1e-3;
    const bool zero = w.force.isZero(0) && w.torque.isZero(0);
    if (r.cut && !zero) fail("cut but not zero");
    if (!r.cut && !r.reduced &&
        ((w.force - before.force).norm() > limits.force_slew * dt + kRounding ||
         (w.torque - before.torque).norm() > limits.torque_slew * dt + kRounding))
      fail("slew");
    if (now - last_good >= 100 * kMillisecond && !zero) fail("force without a server");
    if (!is_finite(to_handle(loop.sample().pose, loop.sample().twist))) fail("sample not finite");
    if (::testing::Test::HasFailure()) return outcome;
    before = w;
    outcome.felt += !zero;
    for (int k = 0; k < 3; ++k) outcome.add(w.force[k]), outcome.add(w.torque[k]);
  }
  return outcome;
}

TEST(LoopProperty, LimitsHoldInEveryTickOfEverySchedule) {
  const unsigned seed = testing::drawn_seed();
  SCOPED_TRACE("base seed " + std::to_string(seed));
  long felt = 0;
  for (int i = 0; i < kSchedules && !HasFailure(); ++i) felt += run_schedule(seed + i, kTicks).felt;
  EXPECT_GT(felt, kSchedules * kTicks / 20);  // the schedules do reach force
}

TEST(LoopProperty, LimitsHoldInLongSchedules) {
  const unsigned seed = testing::drawn_seed();
  SCOPED_TRACE("base seed " + std::to_string(seed));
  long felt = 0;
  for (int i = 0; i < kLongSchedules && !HasFailure(); ++i) felt += run_schedule(seed + i, kLongTicks).felt;
  EXPECT_GT(felt, kLongSchedules * kLongTicks / 20);
}

TEST(LoopProperty, TheSameInputsGiveTheSameWrenchesBitForBit) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Outcome one = run_schedule(seed, 1000), two = run_schedule(seed, 1000);
    EXPECT_EQ(one.hash, two.hash) << "seed " << seed;
    EXPECT_NE(one.hash, run_schedule(seed + 1000, 1000).hash);
  }
}

}  // namespace
}  // namespace palp
