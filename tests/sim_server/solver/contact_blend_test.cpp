// The blend against contacts whose stiffness is known.
#include "sim_server/solver/contact_blend.h"

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/seed.h"

namespace palp::test::contact_blend_test {
namespace {

constexpr double kStep = 1e-3;
constexpr double kStiffness = 1000, kDamping = 20;

// A hand's coupling with a proxy that stands still at x = 0, and a contact that answers with a share of it.
struct Contact {
  // x, v: of the device; answer: the contact's force for the coupling's on the proxy.
  double step(double x, double v, const std::function<double(double)>& answer) {
    if (!known) slow_x = x, slow_v = v;
    known = true;
    slow_x += ContactBlend::share_of_slow_mean(kStep) * (x - slow_x);
    slow_v += ContactBlend::share_of_slow_mean(kStep) * (v - slow_v);
    const double held = kStiffness * x + kDamping * v;
    const double demand = kStiffness * (x - slow_x) + kDamping * (v - slow_v);
    const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
    return blend.update(answer(held) * axis, demand * axis, held * axis, 0.03, kStep);
  }
  ContactBlend blend;
  double slow_x = 0, slow_v = 0;
  bool known = false;
};

const auto kRigid = [](double held) { return held > 0 ? -held : 0.0; };

TEST(Blend, IsNothingWithoutContact) {
  Contact c;
  for (int k = 0; k < 1000; ++k)
    ASSERT_EQ(c.step(0.05 * std::sin(0.006 * k), 0.3 * std::cos(0.006 * k), [](double) { return 0.0; }), 0);
}

// However the hand moves behind a rigid wall, and wherever it comes to rest: the wall answers with everything.
TEST(Blend, IsOneAtARigidWallHoweverTheHandMoves) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> speed(0.01, 0.3), rate(10, 100), stop(2, 40);
  for (int run = 0; run < 100; ++run) {
    Contact c;
    const double v0 = speed(random), w = rate(random);
    const int arrive = 200, rest = arrive + static_cast<int>(stop(random));
    double x = -v0 * kStep * arrive, held_x = 0;
    for (int k = 0; k < rest + 300; ++k) {
      // comes at a steady speed, slows down, rests, moves about
      const double v = k < arrive ? v0 : k < rest ? v0 * (rest - k) / (rest - arrive) : 0;
      if (k < rest) held_x = x += kStep * v;
      const double t = kStep * (k - rest - 100);
      const double way = t > 0 ? 0.3 * held_x * std::sin(w * t) : 0;
      const double blend = c.step(k < rest ? x : held_x + way, t > 0 ? 0.3 * held_x * w * std::cos(w * t) : v, kRigid);
      if (k > arrive + 2 && kStiffness * x + kDamping * v > 0.1 && t <= 0) {
        ASSERT_GT(blend, 0.9) << "run " << run << ", " << k - arrive << " ms after it touched";
      }
      if (t > 0) {
        ASSERT_GT(blend, 0.9) << "run " << run << ", moving about";
      }
    }
  }
}

TEST(Blend, IsTheShareThatAnElasticContactAnswersWith) {
  for (const double share : {0.2, 0.5, 0.8}) {
    Contact c;
    const auto elastic = [share](double held) { return held > 0 ? -share * held : 0.0; };
    double x = -2e-3;
    for (int k = 0; k < 200; ++k) c.step(x += 2e-5, 0.02, elastic);
    for (int k = 0; k < 200; ++k) c.step(x, 0, elastic);
    EXPECT_NEAR(c.step(x, 0, elastic), share, 0.02);
  }
}

TEST(Blend, EndsWithTheContact) {
  Contact c;
  for (int k = 0; k < 100; ++k) c.step(1e-5 * k, 0.01, kRigid);
  EXPECT_GT(c.step(1e-3, 0, kRigid), 0.9);
  EXPECT_EQ(c.step(-1e-6, -1, kRigid), 0);
}

// Drag follows the speed, not the place. Only while the hand turns round, the share of the damper's that the drag is.
TEST(Blend, IsSmallInAFluidThatOnlyDrags) {
  Contact c;
  double most = 0, sum = 0;
  for (int k = 0; k < 3000; ++k) {
    const double phase = 2 * M_PI * 1e-3 * k, v = 0.05 * 2 * M_PI * std::cos(phase);
    const double blend = c.step(0.05 * std::sin(phase), v, [v](double) { return -5 * v - 1e-9; });
    if (k >= 1000) most = std::max(most, blend), sum += blend / 2000;
  }
  EXPECT_LT(most, 1.1 * 5 / kDamping);
  EXPECT_LT(sum, 0.05);
}

// A hand at rest, as its encoders show it.
TEST(Blend, KeepsWhatItKnowsWhileTheHandRests) {
  Contact c;
  for (int k = 0; k < 100; ++k) c.step(1e-5 * k, 0.01, kRigid);
  double before = 0;
  for (int k = 0; k < 100; ++k) before = c.step(1e-3, 0, kRigid);
  for (int k = 0; k < 1000; ++k)
    ASSERT_EQ(c.step(1e-3 + (k / 50 % 2) * 5e-6, 0, [k](double) { return -1 - 0.002 * (k % 7); }), before);
}

}  // namespace
}  // namespace palp::test::contact_blend_test
