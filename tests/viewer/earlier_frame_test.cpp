// Which frame the speeds of particles follow from, beside the one that is shown.
#include <gtest/gtest.h>

#include <memory>

#include "viewer/feed_state.h"

namespace palp::test::earlier_frame_test {
namespace {

TEST(EarlierFrame, IsTheOneBeforeInSimulatedTime) {
  FeedState state(true, 1);
  SceneDescription scene;
  scene.header.session = 5;
  scene.particle_count = 1;
  state.add(Received<SceneDescription>{scene, 0});
  std::uint64_t number = 0;
  const auto add = [&](double sim_time) {
    auto frame = std::make_shared<ParticleFrame>();
    frame->session = 5;
    frame->frame = ++number;
    frame->sim_time = sim_time;
    frame->positions = {0, 0, 0};
    state.add(std::shared_ptr<const ParticleFrame>(frame));
    return state.view().earlier ? state.view().earlier->frame : 0;
  };
  EXPECT_EQ(add(0.1), 0u) << "nothing was before";
  EXPECT_EQ(add(0.2), 1u);
  EXPECT_EQ(add(0.3), 2u);
  EXPECT_EQ(add(0.3), 2u) << "a simulation that stands does not slow its particles down";
  EXPECT_EQ(add(0), 0u) << "it began anew";
  EXPECT_EQ(add(0.1), 5u);
}

}  // namespace
}  // namespace palp::test::earlier_frame_test
