// The rings that plots are drawn from, and what goes into them.
#include "viewer/plots.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace palp::test::plots_test {
namespace {

TEST(History, KeepsTheNewestInOrder) {
  History h;
  EXPECT_TRUE(h.empty());
  const int n = 3 * static_cast<int>(History::kMost) / 2;
  for (int i = 0; i < n; ++i) h.add(0.1 * i, i);
  ASSERT_EQ(h.size(), History::kMost);
  EXPECT_EQ(h.newest().value, n - 1);
  for (std::size_t i = 0; i < h.size(); ++i)
    EXPECT_EQ(h[i].value, n - static_cast<int>(History::kMost) + static_cast<int>(i));
}

TEST(History, CoversItsSpanHoweverOftenValuesCome) {
  History h;
  for (int i = 0; i < 15'000; ++i) h.add(1e-3 * i, i);  // 15 s at 1 kHz
  EXPECT_GE(h.newest().time - h[0].time, 0.99 * History::kSpan);
  EXPECT_GT(h.newest().time, 14.9);
}

TEST(History, PassesOverWhatIsNoNumberAndBeginsAnewWhenTimeGoesBack) {
  History h;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    h.add(bad, 1);
    h.add(1, bad);
  }
  EXPECT_TRUE(h.empty());
  h.add(5, 1);
  h.add(6, 2);
  h.add(2, 3);
  ASSERT_EQ(h.size(), 1u);
  EXPECT_EQ(h.newest().value, 3);
}

TEST(Plots, TakeForcesAgesAndPace) {
  Plots plots;
  FeedView view;
  HudData figures;
  plots.add(view, figures, 1'000'000'000);
  EXPECT_TRUE(plots.step_time.empty() && plots.frame_age.empty() && plots.real_time_factor.empty());
  EXPECT_TRUE(plots.kinetic_energy.empty());
  view.proxies[2].emplace().wrench = {{1, 2, 3}, {4, 5, 6}};
  view.frame = std::make_shared<const ParticleFrame>();
  view.frame_time_ns = 1'900'000'000;
  figures.step_time = 4e-4;
  figures.real_time_factor = 0.5;
  figures.bridge_data_age = 2e-3;
  figures.kinetic_energy = 0.7;
  plots.add(view, figures, 2'000'000'000);
  EXPECT_TRUE(plots.hands[0].force[0].empty());
  EXPECT_EQ(plots.hands[2].force[2].newest().value, 3);
  EXPECT_EQ(plots.hands[2].torque[0].newest().value, 4);
  EXPECT_NEAR(plots.frame_age.newest().value, 0.1, 1e-9);
  EXPECT_EQ(plots.step_time.newest().value, 4e-4);
  EXPECT_EQ(plots.bridge_age.newest().value, 2e-3);
  EXPECT_EQ(plots.real_time_factor.newest().value, 0.5);
  EXPECT_EQ(plots.kinetic_energy.newest().value, 0.7);
  figures.paused = true;
  plots.add(view, figures, 3'000'000'000);
  EXPECT_EQ(plots.real_time_factor.newest().value, 0);
}

}  // namespace
}  // namespace palp::test::plots_test
