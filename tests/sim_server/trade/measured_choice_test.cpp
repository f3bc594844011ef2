// Tests of the choice on machines that are not as the table says, without a clock: they take as long as they are told.
#include "sim_server/trade/measured_choice.h"

#include <cmath>

#include "config/error.h"
#include "sim_server/trade/calibration.h"
#include "sim_server/trade/front.h"
#include "tests/sim_server/trade/random_front.h"

namespace palp::test::measured_choice_test {
namespace {

constexpr double kUsed = 0.79;  // of a budget: a candidate that takes four fifths of it serves

// A spacing within 1 % of the best one serves, too; errors of random_points go at most by the tenth power of the
// spacing.
constexpr double kSteepest = 1.105;

// A machine that is `factor` times as slow as the table's for a spacing of 2 cm, and by `slope` more or less for
// others.
struct Machine {
  const std::vector<TradePoint>& points;
  double factor, slope;

  // Returns what a point takes here, by the table's curve, restated.
  double step(const TradePoint& at) const {
    const TradePoint *fine = nullptr, *coarse = nullptr;
    for (const TradePoint& p : points) {
      if (p.settings != at.settings) continue;
      if (p.spacing <= at.spacing * (1 + 1e-9) && (!fine || p.spacing > fine->spacing)) fine = &p;
      if (p.spacing >= at.spacing * (1 - 1e-9) && (!coarse || p.spacing < coarse->spacing)) coarse = &p;
    }
    if (!fine) fine = coarse;
    if (!coarse) coarse = fine;
    const double width = std::log(coarse->spacing / fine->spacing);
    const double share = width > 0 ? std::log(at.spacing / fine->spacing) / width : 0;
    return std::exp((1 - share) * std::log(fine->step) + share * std::log(coarse->step)) * factor *
           std::pow(at.spacing / 0.02, slope);
  }
};

class MeasuredChoiceOf : public RandomCase {};

TEST_F(MeasuredChoiceOf, ABudgetIsKeptAndUsedOnMachinesOfAnotherSpeed) {
  int made = 0;
  for (int round = 0; round < 300; ++round) {
    const std::vector<TradePoint> points = random_points(random_);
    const bool as_many_times_slower = round % 3 > 0;  // for each number of particles
    const Machine machine{points, std::exp(between(std::log(0.1), std::log(10.0))),
                          as_many_times_slower ? 0 : between(-0.7, 0.7)};
    const double budget = std::exp(between(std::log(1e-5), std::log(1e-1)));
    int timed = 0;
    const TimeCandidate time = [&](const TradePoint& p) {
      ++timed;
      return 0.8 * machine.step(p);
    };
    double cheapest = 1e300;
    for (const TradePoint& p : points) cheapest = std::min(cheapest, machine.step(p));
    try {
      const MeasuredChoice chosen = choose_measured(points, {budget, std::nullopt}, round % 2 == 0, "tray", time);
      ++made;
      const double real = machine.step(chosen.point);
      EXPECT_LE(real, budget * (1 + 1e-6));
      EXPECT_NEAR(chosen.point.step / real, 1, 1e-3) << "what is expected is what it takes";
      EXPECT_LE(timed, 6);
      for (const TradePoint& p : points)
        EXPECT_TRUE(!as_many_times_slower || machine.step(p) > kUsed * budget ||
                    chosen.point.error <= p.error * kSteepest);
    } catch (const ConfigError& error) {
      EXPECT_GT(cheapest, 0.98 * budget) << error.what();
      EXPECT_NE(std::string(error.what()).find("tray: no numerics"), std::string::npos);
    }
  }
  EXPECT_GT(made, 100);
}

TEST_F(MeasuredChoiceOf, SpacingsAtWhichTheSceneCannotBeHadAreStoodAside) {
  int made = 0;
  for (int round = 0; round < 300; ++round) {
    const std::vector<TradePoint> points = random_points(random_);
    const Machine machine{points, 1, 0};
    const double low = between(0.01, 0.05), high = low * between(1, 1.3);
    const TimeCandidate time = [&](const TradePoint& p) {
      if (p.spacing > low && p.spacing < high) throw ConfigError("a part holds no particle");
      return 0.8 * machine.step(p);
    };
    const bool budgeted = round % 2 == 0;
    const double budget = points.back().step * between(0.1, 1), error = points.front().error * between(0.3, 1);
    const ChoiceRequest request = budgeted ? ChoiceRequest{budget, std::nullopt} : ChoiceRequest{std::nullopt, error};
    try {
      const MeasuredChoice chosen = choose_measured(points, request, round % 4 < 2, "tray", time);
      ++made;
      EXPECT_FALSE(chosen.point.spacing > low && chosen.point.spacing < high);
      EXPECT_NEAR(chosen.point.step / machine.step(chosen.point), 1, 1e-3);
      EXPECT_TRUE(!budgeted || chosen.point.step <= budget * (1 + 1e-6));
    } catch (const ConfigError&) {  // there may be no other spacing
      const TradePoint& cheapest = points.front();
      const bool had = cheapest.spacing <= low || cheapest.spacing >= high;
      EXPECT_TRUE(!budgeted || !had || cheapest.step > 0.98 * budget);
    }
  }
  EXPECT_GT(made, 200);
}

TEST_F(MeasuredChoiceOf, AnErrorIsKeptAndItsCostToldAsItIsHere) {
  for (int round = 0; round < 100; ++round) {
    const std::vector<TradePoint> points = random_points(random_);
    const Machine machine{points, 3, 0};
    const double error = std::exp(between(-5, 0));
    const auto wanted = cheapest_within(points, error);
    const TimeCandidate time = [&](const TradePoint& p) { return 0.8 * machine.step(p); };
    if (!wanted) {
      EXPECT_THROW(choose_measured(points, {std::nullopt, error}, false, "tray", time), ConfigError);
      continue;
    }
    const MeasuredChoice chosen = choose_measured(points, {std::nullopt, error}, false, "tray", time);
    EXPECT_LE(chosen.point.error, error);
    EXPECT_NEAR(chosen.point.step / (3 * wanted->step), 1, 1e-3);
    EXPECT_NEAR(chosen.speed, 1.0 / 3, 1e-3);
  }
}

TEST(MeasuredChoice, NumericsThatCannotBeHadGiveWayToOthers) {
  const std::vector<TradePoint> points{{0.04, {"a.b=1"}, 1e-4, 2e-4, 8e-5, 0.4},
                                       {0.02, {"a.b=2"}, 2e-4, 4e-4, 1.6e-4, 0.1}};
  const TimeCandidate time = [](const TradePoint& p) {
    return p.spacing > 0.03 ? 8e-5 : throw ConfigError("a part holds no particle");
  };
  for (const bool trusted : {false, true})
    EXPECT_EQ(choose_measured(points, {1.0, std::nullopt}, trusted, "tray", time).point.spacing, 0.04);
}

TEST(MeasuredChoice, WhatIsPossibleIsSaidWhereNothingFits) {
  const std::vector<TradePoint> points{{0.04, {}, 1e-4, 2e-4, 8e-5, 0.4}, {0.02, {}, 16e-4, 20e-4, 13e-4, 0.1}};
  const TimeCandidate twice = [&](const TradePoint& p) { return 2 * (p.spacing > 0.03 ? 8e-5 : 13e-4); };
  try {
    choose_measured(points, {1e-4, std::nullopt}, true, "tray", twice);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "tray: no numerics that were measured take a step of at most 100 us on this machine: the cheapest, a "
                 "spacing of 40 mm, takes 200 us at an error of 40 %; give a budget of that, or a smaller scene or a "
                 "faster machine");
  }
  try {
    choose_measured(points, {std::nullopt, 0.05}, true, "tray", twice);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "tray: no numerics that were measured err by at most 5 %: the most accurate, a spacing of 20 mm, is "
                 "expected to err by 10 % of the force; ask for that, or measure finer ones with tools/tradeoff");
  }
}

TEST(Calibration, AMomentElsewhereDoesNotCount) {
  int step = 0;
  const auto timed = [&] {
    ++step;
    if (step < 20) return 5e-3;              // caches and clocks are cold
    return step % 10 == 0 ? 50e-3 : 200e-6;  // now and then the machine is elsewhere for a while
  };
  EXPECT_DOUBLE_EQ(typical_step(timed), 200e-6);
}

TEST(Calibration, LongStepsAreTimedAFewTimesOnly) {
  int step = 0;
  EXPECT_DOUBLE_EQ(typical_step([&] { return ++step, 2.0; }), 2.0);
  EXPECT_LE(step, 6);
  step = 0;
  EXPECT_DOUBLE_EQ(typical_step([&] { return ++step, 1e-5; }), 1e-5);
  EXPECT_LE(step, 26000 + 1000) << "a quarter of a second of steps";
}

}  // namespace
}  // namespace palp::test::measured_choice_test
