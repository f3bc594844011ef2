// Where an arm's handle can be moved: what bridges say of it, and which sides of the box are seen.
#include "viewer/hand_reach.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palp::test::hand_reach_test {
namespace {

Status bridge(const std::string& process) {
  Status status;
  status.process = process;
  const char* const names[] = {"reach_x_m",      "reach_y_m",      "reach_z_m",
                               "reach_half_x_m", "reach_half_y_m", "reach_half_z_m"};
  double value = 0.1;
  for (const char* name : names) status.metrics.push_back({name, value += 0.1});
  status.metrics.push_back({"clutch", 1});
  return status;
}

std::map<std::uint32_t, HandReach> read(const Status& status) { return reaches_of({{status.process, status}}); }

TEST(HandReach, IsReadByDevice) {
  const auto reaches = read(bridge("haptic_bridge 3"));
  ASSERT_TRUE(reaches.contains(3));
  EXPECT_LT((reaches.at(3).center - osg::Vec3d(0.2, 0.3, 0.4)).length(), 1e-12);
  EXPECT_LT((reaches.at(3).half - osg::Vec3d(0.5, 0.6, 0.7)).length(), 1e-12);
  EXPECT_TRUE(reaches.at(3).clutched);
}

TEST(HandReach, NothingSenselessIsOne) {
  EXPECT_TRUE(read(bridge("sim_server")).empty());
  EXPECT_TRUE(read(bridge("haptic_bridge 3x")).empty());
  EXPECT_TRUE(read(bridge("haptic_bridge ")).empty());
  Status unknown = bridge("haptic_bridge 0");
  unknown.metrics[4].value = 0;
  EXPECT_TRUE(read(unknown).empty()) << "the bridge does not know it";
  unknown.metrics[4].value = std::nan("");
  EXPECT_TRUE(read(unknown).empty());
  unknown.metrics.clear();
  EXPECT_TRUE(read(unknown).empty());
}

TEST(HandReach, TheSideThatTheHandComesNearIsSeen) {
  HandReach reach{{1, 2, 3}, {0.2, 0.4, 0.4}};
  EXPECT_EQ(reach_shown(reach, {1, 2, 3}), (std::array<float, 6>{}));
  const auto at_side = reach_shown(reach, {1, 2.4, 3});
  EXPECT_EQ(at_side, (std::array<float, 6>{0, 0, 0, 1, 0, 0}));
  const auto near = reach_shown(reach, {0.83, 2, 3});
  EXPECT_GT(near[0], 0);
  EXPECT_LT(near[0], 1);
  reach.clutched = true;
  for (const float side : reach_shown(reach, {1, 2, 3})) EXPECT_EQ(side, 0.5f);
}

}  // namespace
}  // namespace palp::test::hand_reach_test
