// Tests how the wrench fades with the age of its data.
#include "haptic_bridge/loop/stale_fade.h"

#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

namespace palp::test::stale_fade_test {
namespace {

TEST(StaleFade, FallsFromOneToZeroAndNeverRises) {
  const StaleTimes t;
  EXPECT_EQ(stale_scale(0, t), 1);
  EXPECT_EQ(stale_scale(t.fade_start_ns, t), 1);
  EXPECT_EQ(stale_scale(t.fade_end_ns, t), 0);
  EXPECT_EQ(stale_scale(std::numeric_limits<std::int64_t>::max(), t), 0);
  EXPECT_DOUBLE_EQ(stale_scale(40'000'000, t), 0.5);
  double before = 1;
  for (std::int64_t age = 0; age < 100'000'000; age += 100'000) {
    ASSERT_LE(stale_scale(age, t), before);
    before = stale_scale(age, t);
  }
}

}  // namespace
}  // namespace palp::test::stale_fade_test
