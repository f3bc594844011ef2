// The cuboids of figure 3, one of each state, with the hand that comes down on them and slides.
#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/played_scene.h"

namespace palp::test::cuboid_scenes_test {
namespace {

struct State {
  const char* name;
  double least_push, most_push;  // that the hand feels while it comes down [N]
  double least_drag, most_drag;  // against it, half way along [N]
};

class Cuboid : public ::testing::TestWithParam<State> {};

TEST_P(Cuboid, IsFeltAndStaysInItsPlace) {
  const State& state = GetParam();
  PlayedScene hand(std::string("cuboid_") + state.name, {"slide"});
  const Body& cuboid = body_named(hand.scene, "cuboid");
  double before = 0, push = 0, drag = 0, after = 0;
  const auto look = [&](const StepOutput& out) {
    const Eigen::Vector3d f = out.proxies[0].contact_force;
    ASSERT_TRUE(f.allFinite() && out.proxies[0].force.allFinite());
    if (out.time < 0.5) before = std::max(before, f.norm());
    if (out.time < 1.6) push = std::max(push, f.z());
    if (out.time > 1.9 && out.time < 2.3) drag += -f.x() / 400;
    if (out.time > 3.8) after = std::max(after, f.norm());
  };
  ASSERT_TRUE(hand.play(3.9, look));
  RecordProperty("push_N", std::to_string(push));
  RecordProperty("drag_N", std::to_string(drag));
  EXPECT_LT(before, 0.001 * push) << "felt where it is not";
  EXPECT_LT(after, 0.001 * push) << "felt when the tool has left";
  EXPECT_GT(push, state.least_push);
  EXPECT_LT(push, state.most_push);
  EXPECT_GT(drag, state.least_drag);
  EXPECT_LT(drag, state.most_drag);
  double low = 1, high = -1, across = 0;
  for (std::size_t i = cuboid.first; i < cuboid.first + cuboid.count; ++i) {
    const Eigen::Vector3d x = hand.place(i);
    low = std::min(low, x.z());
    high = std::max(high, x.z());
    across = std::max(across, x.head<2>().cwiseAbs().maxCoeff());
  }
  RecordProperty("low_m", std::to_string(low));
  RecordProperty("high_m", std::to_string(high));
  RecordProperty("across_m", std::to_string(across));
  EXPECT_GT(low, 0) << "through the floor";
  EXPECT_LT(high, 0.27);
  EXPECT_LT(across, 0.26) << "spread";
}

INSTANTIATE_TEST_SUITE_P(States, Cuboid,
                         ::testing::Values(State{"fluid", 1, 10, 0.3, 10}, State{"elastic", 5, 40, 0.5, 40},
                                           State{"rigid", 30, 60, 8, 16}, State{"static", 30, 60, 8, 16}),
                         [](const auto& param) { return std::string(param.param.name); });

}  // namespace
}  // namespace palp::test::cuboid_scenes_test
