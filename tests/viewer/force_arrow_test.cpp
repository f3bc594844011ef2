// The length at which a newton is drawn.
#include "viewer/force_arrow.h"

#include <gtest/gtest.h>

namespace palp::test {
namespace {

TEST(ForceScale, GrowsAtOnceAndFallsSlowly) {
  ForceScale scale;
  EXPECT_DOUBLE_EQ(scale.update(0.4, 0), 1);
  EXPECT_DOUBLE_EQ(scale.update(3, 0.001), 5);
  EXPECT_DOUBLE_EQ(scale.update(0, 1), 5);
  EXPECT_LT(scale.update(0, 30), 5);
  EXPECT_DOUBLE_EQ(scale.update(9, 0), 10) << "time runs backwards at a reset";
}

}  // namespace
}  // namespace palp::test
