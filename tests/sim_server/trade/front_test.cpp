// Tests that the best point of a front is chosen, between measured points, too.
#include "sim_server/trade/front.h"

#include <cmath>

#include "tests/sim_server/trade/random_front.h"

namespace palp::test::front_test {
namespace {

TradePoint point(double spacing, double step, double error, const std::string& setting = "numerics.safety=0.5") {
  TradePoint p;
  p.spacing = spacing;
  p.settings = {setting};
  p.step = p.step_p99 = p.calm_step = step;
  p.error = error;
  return p;
}

TEST(Front, BetweenNeighboursCostAndErrorArePowerLaws) {
  const std::vector<TradePoint> points{point(0.04, 1e-4, 0.4), point(0.02, 16e-4, 0.1)};  // powers -4 and 2
  const auto found = least_error_within(points, 4e-4);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->spacing, 0.04 / std::sqrt(2), 1e-9);
  EXPECT_NEAR(found->error, 0.2, 1e-9);
}

TEST(Front, AnErrorIsTrustedWhereItWasMeasuredOnly) {
  const std::vector<TradePoint> points{point(0.04, 1e-4, 0.4), point(0.02, 16e-4, 0.1)};
  for (const double error : {0.1, 0.2, 0.399}) EXPECT_EQ(cheapest_within(points, error)->spacing, 0.02) << error;
  EXPECT_EQ(cheapest_within(points, 0.4)->spacing, 0.04);
}

TEST(Front, OtherNumericsAreNotInterpolatedBetween) {
  const std::vector<TradePoint> points{point(0.04, 1e-4, 0.4), point(0.02, 16e-4, 0.1, "numerics.safety=0.9")};
  const auto found = least_error_within(points, 4e-4);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->spacing, 0.04);
}

TEST(Front, AnErrorOfNothingIsChosenWhereItFits) {
  const std::vector<TradePoint> points{point(0.04, 1e-4, 0), point(0.02, 2e-4, 0)};
  const auto found = least_error_within(points, 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->spacing, 0.04) << "of two that do not err the cheaper one";
  EXPECT_EQ(cheapest_within(points, 0.01)->spacing, 0.04);
}

TEST(Front, MovesAlongItsStretchesToTheirEnds) {
  const std::vector<TradePoint> points{point(0.04, 1e-4, 0.4), point(0.02, 16e-4, 0.1), point(0.01, 256e-4, 0.05)};
  const TradePoint from = point(0.0195, 1, 1);
  EXPECT_NEAR(moved_along(points, from, 1.2)->spacing, 0.0234, 1e-9) << "past a measured point";
  EXPECT_NEAR(moved_along(points, from, 1.2)->step, 1e-4 * std::pow(0.04 / 0.0234, 4), 1e-9);
  EXPECT_NEAR(moved_along(points, from, 3)->spacing, 0.04, 1e-9);
  EXPECT_NEAR(moved_along(points, from, 0.1)->spacing, 0.01, 1e-9);
  EXPECT_FALSE(moved_along(points, points[0], 1.01));
  EXPECT_FALSE(moved_along(points, points[2], 0.99));
  EXPECT_FALSE(moved_along(points, point(0.02, 1, 1, "numerics.safety=0.9"), 1.01));
}

TEST(Front, NothingIsChosenWhereNothingFits) {
  const std::vector<TradePoint> points{point(0.04, 1e-4, 0.4), point(0.02, 16e-4, 0.1)};
  EXPECT_FALSE(least_error_within(points, 0.9e-4));
  EXPECT_FALSE(cheapest_within(points, 0.09));
  EXPECT_FALSE(least_error_within({}, 1));
}

class RandomFront : public RandomCase {};

// Many places on each stretch, laid out without the code that is tested.
std::vector<TradePoint> on_the_curve(const std::vector<TradePoint>& points) {
  std::vector<TradePoint> all = points;
  for (const TradePoint& a : points)
    for (const TradePoint& b : points) {
      if (a.settings != b.settings || a.spacing <= b.spacing) continue;
      bool neighbours = true;
      for (const TradePoint& c : points)
        if (c.settings == a.settings && c.spacing < a.spacing && c.spacing > b.spacing) neighbours = false;
      for (int k = 1; neighbours && k < 50; ++k) {
        TradePoint c = a;
        const double share = k / 50.0;
        c.spacing = std::exp((1 - share) * std::log(a.spacing) + share * std::log(b.spacing));
        c.step = std::exp((1 - share) * std::log(a.step) + share * std::log(b.step));
        c.error = std::exp((1 - share) * std::log(a.error) + share * std::log(b.error));
        all.push_back(c);
      }
    }
  return all;
}

TEST_F(RandomFront, TheChoiceFitsAndIsDominatedByNothingOnTheCurve) {
  for (int round = 0; round < 200; ++round) {
    const std::vector<TradePoint> points = random_points(random_), curve = on_the_curve(points);
    const double step = std::exp(between(std::log(2e-5), std::log(1e-1))), error = std::exp(between(-5, 0));
    const auto by_budget = least_error_within(points, step), by_error = cheapest_within(points, error);
    EXPECT_TRUE(!by_budget || by_budget->step <= step);
    EXPECT_TRUE(!by_error || by_error->error <= error);
    for (const TradePoint& p : curve) {
      if (p.step > step * (1 - 1e-9)) continue;
      ASSERT_TRUE(by_budget);
      EXPECT_LE(by_budget->error, p.error * (1 + 1e-9));
    }
    for (const TradePoint& p : points) {
      if (p.error > error) continue;
      ASSERT_TRUE(by_error);
      EXPECT_LE(by_error->step, p.step);
    }
  }
}

TEST_F(RandomFront, MoreBudgetNeverErrsMore) {
  for (int round = 0; round < 100; ++round) {
    const std::vector<TradePoint> points = random_points(random_);
    double least = 1e300;
    for (double step = points.front().step; step < 2 * points.back().step; step *= 1.05) {
      const double error = least_error_within(points, step).value().error;
      EXPECT_LE(error, least * (1 + 1e-12));
      least = error;
    }
  }
}

}  // namespace
}  // namespace palp::test::front_test
