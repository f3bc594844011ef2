#include "haptic_bridge/loop/force_limits.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "idl/histogram.h"
#include "tests/support/seed.h"

namespace palp::test::force_limits_test {
namespace {

constexpr double kRounding = 1e-12;  // relative, of a scaled vector's length

struct RandomVectors {
  explicit RandomVectors(std::uint64_t seed) : random(seed) {}
  // Lengths over many orders of magnitude, axes now and then exactly zero.
  Eigen::Vector3d next() {
    std::uniform_real_distribution<double> exponent(-12, 12), part(-1, 1);
    std::uniform_int_distribution<int> coin(0, 7);
    Eigen::Vector3d v(part(random), part(random), part(random));
    for (int i = 0; i < 3; ++i) {
      if (coin(random) == 0) v[i] = 0;
    }
    return v * std::pow(10, exponent(random));
  }
  std::mt19937_64 random;
};

TEST(ForceLimits, SaturationNeverExceedsTheLimitAndKeepsTheDirection) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomVectors vectors(seed);
  for (int i = 0; i < 100000; ++i) {
    const Eigen::Vector3d v = vectors.next();
    const double limit = std::abs(vectors.next().x());
    const Eigen::Vector3d s = saturated(v, limit);
    ASSERT_LE(s.norm(), limit * (1 + kRounding));
    ASSERT_LE((s.normalized() - v.normalized()).norm() * (s.norm() > 0), 1e-9) << v.transpose();
    if (v.norm() <= limit) {
      ASSERT_EQ(s, v);
    }
  }
}

TEST(ForceLimits, SaturationKeepsTheDirectionOfAVectorWhoseLengthOverflows) {
  const Eigen::Vector3d s = saturated(Eigen::Vector3d(1e300, -1e300, 0), 2);
  EXPECT_NEAR(s.x(), std::sqrt(2), 1e-12);
  EXPECT_NEAR(s.y(), -std::sqrt(2), 1e-12);
  EXPECT_EQ(s.z(), 0);
}

TEST(ForceLimits, SaturationToZeroIsZero) { EXPECT_EQ(saturated(Eigen::Vector3d(1, 2, 3), 0).norm(), 0); }

TEST(ForceLimits, SlewNeverStepsFurtherThanAllowedAndStaysInTheBall) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomVectors vectors(seed);
  const double limit = 8, step = 0.3;
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  for (int i = 0; i < 100000; ++i) {
    const Eigen::Vector3d next = slewed(at, saturated(vectors.next(), limit), step);
    ASSERT_LE((next - at).norm(), step * (1 + kRounding));
    ASSERT_LE(next.norm(), limit * (1 + kRounding));
    at = next;
  }
}

TEST(ForceLimits, SlewArrives) {
  const Eigen::Vector3d wanted(1, -2, 0.5);
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  for (int i = 0; i < 8; ++i) at = slewed(at, wanted, 0.3);
  EXPECT_LT((at - wanted).norm(), 1e-15);
}

// Sends what is wanted through the limit, a millisecond a step.
struct Sloped {
  explicit Sloped(double leak) : limit(leak) {}
  Wrench<double> send(const Wrench<double>& wanted) {
    sent = limit.step(sent, wanted, limits, 1e-3);
    limit.note(wanted, sent);
    return sent;
  }
  double send(double force) { return send({{force, 0, 0}, {0, 0, 0}}).force.x(); }
  SlewLimit limit;
  WrenchLimits limits;
  Wrench<double> sent = zero_wrench();
};
constexpr double kLeak = 0.05;

TEST(SlewLimit, NeverStepsFurtherThanAllowedNorLeavesTheLimits) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomVectors vectors(seed);
  Sloped s(kLeak);
  s.limits.axis_force = {6, 3, 8};
  for (int i = 0; i < 100000; ++i) {
    const Wrench<double> before = s.sent, wanted = saturated({vectors.next(), vectors.next()}, s.limits);
    const Wrench<double> now = s.send(wanted);
    ASSERT_LE((now.force - before.force).norm(), 0.3 * (1 + kRounding));
    ASSERT_LE((now.torque - before.torque).norm(), 0.03 * (1 + kRounding));
    ASSERT_LE(now.force.norm(), s.limits.force * (1 + kRounding));
    ASSERT_LE(now.torque.norm(), s.limits.torque * (1 + kRounding));
    for (int a = 0; a < 3; ++a) ASSERT_LE(std::abs(now.force[a]), s.limits.axis_force[a] * (1 + kRounding));
  }
}

// The limiter must not carry what it still has to go back by past the limits when what is wanted rises again.
TEST(SlewLimit, KeepsTheLimitsWhileItGoesOnWithArrears) {
  Sloped s(kLeak);
  for (int k = 0; k < 100; ++k) s.send({{8, 0, 0}, {0, 0.5, 0}});
  double wanted = 2, turn = 0.1, most = 0;
  s.send({{wanted, 0, 0}, {0, turn, 0}});
  for (int k = 0; k < 20; ++k) {
    s.send({{wanted += 0.3, 0, 0}, {0, turn += 0.02, 0}});
    most = std::max({most, s.sent.force.norm() / 8, s.sent.torque.norm() / 0.5});
  }
  EXPECT_LE(most, 1 + kRounding);
}

TEST(SlewLimit, SendsWhatIsWantedWhileTheSlopeAllowsIt) {
  Sloped s(kLeak);
  for (int k = 0; k < 1000; ++k) {
    const double wanted = 5 * std::sin(0.05 * k);  // up to 0.25 N a step
    ASSERT_NEAR(s.send(wanted), wanted, 1e-14);
  }
}

TEST(SlewLimit, TurnsInTheStepInWhichWhatItFollowsTurns) {
  const auto turns_after = [](double leak) {
    Sloped s(leak);
    double wanted = 0;
    for (int k = 0; k < 10; ++k) s.send(wanted += 0.7);
    double before = s.sent.force.x();
    for (int k = 1;; ++k) {
      const double now = s.send(wanted -= 0.7);
      if (now < before) return k;
      before = now;
    }
  };
  EXPECT_EQ(turns_after(kLeak), 1);
  EXPECT_GT(turns_after(1), 3) << "the plain limiter goes on until what is wanted has come down to it";
}

// The fundamental of what oscillates far beyond the slope must arrive in phase.
TEST(SlewLimit, DelaysNoOscillation) {
  const auto lag_deg = [](double leak) {
    Sloped s(leak);
    double in_phase = 0, behind = 0;
    for (int k = 0; k < 2000; ++k) {
      const double phase = 2 * M_PI * 0.02 * k;  // 20 Hz
      const double sent = s.send(7.5 * std::sin(phase));
      if (k < 1000) continue;
      in_phase += sent * std::sin(phase);
      behind -= sent * std::cos(phase);
    }
    return std::atan2(behind, in_phase) * 180 / M_PI;
  };
  EXPECT_LT(lag_deg(kLeak), 15);
  EXPECT_GT(lag_deg(1), 45) << "the plain limiter";
}

// The limiter reaches what is wanted and stays so as soon as the slope allows, but for the time that it takes to see
// that.
TEST(SlewLimit, FollowsWhatIsCalmAsFastAsItMay) {
  Sloped s(kLeak);
  int steps = 0;
  while (s.send(8) < 8) ASSERT_LT(++steps, 27 + 10);
  while (s.send(0) > 0) ASSERT_LT(++steps, 2 * (27 + 11));
  EXPECT_EQ(s.sent.force.x(), 0);
}

TEST(ForceLimits, RampMovesAtItsTwoRatesAndStops) {
  EXPECT_DOUBLE_EQ(ramped(0, 1, 0.002, 0.02), 0.002);
  EXPECT_DOUBLE_EQ(ramped(1, 0, 0.002, 0.02), 0.98);
  EXPECT_DOUBLE_EQ(ramped(0.999, 1, 0.002, 0.02), 1);
  EXPECT_DOUBLE_EQ(ramped(0.01, 0, 0.002, 0.02), 0);
}

TEST(ForceLimits, LowPassReaches63PercentInItsTimeConstant) {
  const double cutoff_hz = 10, dt = 1e-4, time_constant = 1 / (2 * M_PI * cutoff_hz);
  double y = 0;
  for (int i = 0; i < static_cast<int>(time_constant / dt); ++i) y += low_pass_share(cutoff_hz, dt) * (1 - y);
  EXPECT_NEAR(y, 1 - std::exp(-1), 5e-3);
  EXPECT_EQ(low_pass_share(0, dt), 1);
}

TEST(ForceLimits, OnlyFiniteUnitQuaternionsAreOrientations) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(is_unit(Eigen::Quaterniond(1.0005, 0, 0, 0)));
  EXPECT_FALSE(is_unit(Eigen::Quaterniond(1.002, 0, 0, 0)));
  EXPECT_FALSE(is_unit(Eigen::Quaterniond(0, 0, 0, 0)));
  EXPECT_FALSE(is_unit(Eigen::Quaterniond(nan, 0, 0, 1)));
  EXPECT_FALSE(is_unit(Eigen::Quaterniond(1, 0, inf, 0)));
  EXPECT_FALSE(is_unit(Eigen::Quaterniond(1e-310, 0, 0, 0)));
  EXPECT_FALSE(is_finite(Wrench<double>{{0, 0, 0}, {0, nan, 0}}));
  EXPECT_FALSE(is_finite(Wrench<double>{{-inf, 0, 0}, {0, 0, 0}}));
}

template <class H>
void expect_quantiles_within(double bin) {
  H h;
  EXPECT_EQ(h.quantile_us(0.5), 0);
  for (int i = 1; i <= 100000; ++i) h.add(i * 100);  // 0.1 us .. 10 ms, evenly
  for (double share : {0.01, 0.5, 0.99, 0.999}) {
    const double truth = share * 10000;
    EXPECT_GE(h.quantile_us(share), truth * 0.9999);
    EXPECT_LE(h.quantile_us(share), truth * (1 + bin));
  }
  EXPECT_EQ(h.max_us(), 10000);
  EXPECT_EQ(h.quantile_us(1), 10000);
  h.add(-5);
  h.add(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(h.count(), 100002u);
}

TEST(Histogram, QuantilesAreWithinABinOfTheTruth) {
  expect_quantiles_within<Histogram>(0.035);
  expect_quantiles_within<FineHistogram>(0.0045);
}

}  // namespace
}  // namespace palp::test::force_limits_test
