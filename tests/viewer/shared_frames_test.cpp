// The viewer's view of frames that come by shared memory, without any.
#include <gtest/gtest.h>

#include <memory>

#include "viewer/feed_state.h"

namespace palp::test::shared_frames_test {
namespace {

constexpr std::int64_t kMs = 1'000'000;

Received<SceneDescription> scene_of(std::uint64_t session, std::uint32_t particles) {
  Received<SceneDescription> received;
  received.message.header.session = session;
  received.message.particle_count = particles;
  return received;
}

std::shared_ptr<ParticleFrame> shared_frame(FeedState& state, std::uint64_t session, std::uint64_t number,
                                            std::size_t particles) {
  std::shared_ptr<ParticleFrame> frame = state.spare_frame();
  frame->session = session;
  frame->frame = number;
  frame->positions.assign(3 * particles, 0.5f);
  frame->t_send_ns = static_cast<std::int64_t>(number) * kMs;
  frame->t_receive_ns = frame->t_send_ns + kMs;
  return frame;
}

TEST(SharedFrames, AreShownAsThoseOfTheBus) {
  FeedState state(false, 1);
  state.add(shared_frame(state, 5, 1, 10));
  EXPECT_FALSE(state.view().frame) << "of a scene that has not arrived";
  state.add(scene_of(5, 10));
  state.add(shared_frame(state, 5, 2, 10));
  state.add(shared_frame(state, 5, 4, 10));
  ASSERT_TRUE(state.view().frame);
  EXPECT_EQ(state.view().frame->frame, 4u);
  EXPECT_EQ(state.view().frame_time_ns, 4 * kMs) << "of this host's clock, whatever the bus spans";
  EXPECT_EQ(state.view().lost_frames, 1u);
  state.add(shared_frame(state, 6, 9, 10));  // of a server that is passed over
  state.add(shared_frame(state, 5, 9, 11));  // of another scene
  EXPECT_EQ(state.view().frame->frame, 4u);
  EXPECT_EQ(state.view().refused, 1u);
  EXPECT_EQ(state.view().shared_frames, 2u);
  EXPECT_EQ(state.view().frames, 3u) << "the one that came before its scene was shown, too";
}

TEST(SharedFrames, MemoryOfFramesGoesRound) {
  FeedState state(true, 1);
  state.add(scene_of(5, 10));
  std::shared_ptr<const ParticleFrame> drawn;
  for (std::uint64_t number = 1; number <= 100; ++number) {
    state.add(shared_frame(state, 5, number, 10));
    drawn = state.view().frame;
    ASSERT_EQ(drawn->frame, number) << "nobody writes to a frame that is held";
  }
  EXPECT_GT(state.spare_frame()->positions.capacity(), 0u) << "that of a frame that nobody holds";
}

}  // namespace
}  // namespace palp::test::shared_frames_test
