// Pictures that are drawn in pieces between the steps of a server on the same GPU: they are those drawn at once.
#include <gtest/gtest.h>

#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/stage.h"

namespace palp::test::pieces_image_test {
namespace {

constexpr std::int64_t kUs = 1'000;

// Time that goes by 10 us a look, with a server on the page whose steps take 300 us of each millisecond.
class SteppingClock {
 public:
  SteppingClock() : page_(std::make_shared<GpuPage>()), server_(take_place(*page_, 1, 0)) {}
  GpuPacing::World world() {
    GpuPacing::World world = real_world();
    world.now_ns = [this] {
      now_ += 10 * kUs;
      const std::int64_t begun = now_ / 1'000'000 * 1'000'000;
      begin_step(*server_, begun);
      if (now_ > begun + 300 * kUs) end_step(*server_, begun + 300 * kUs, begun + 1000 * kUs);
      return now_;
    };
    world.sleep = [this](std::int64_t ns) { now_ += ns; };
    return world;
  }
  std::shared_ptr<GpuPage> page() { return page_; }

 private:
  std::int64_t now_ = 1'000'000'000;
  std::shared_ptr<GpuPage> page_;
  GpuUse* server_;
};

class Pieces : public testing::TestWithParam<const char*> {};

TEST_P(Pieces, MakeTheSamePicture) {
  StageOptions options;
  options.headless = true;
  options.gpu = "cpu";
  options.width = 320;
  options.height = 240;
  int errors = 0;
  options.on_gl_error = [&](const std::string& error) {
    ++errors;
    ADD_FAILURE() << error;
  };
  Stage stage(options);
  SyntheticScene s = synthetic_scene();
  const std::string look = GetParam();
  if (look == "beads")
    stage.scene().set_beads(true);
  else
    make_look(s.scene.bodies[0], GetParam());
  set_scene(stage, s.scene);
  stage.scene().set_poses(s.poses);
  // more than there are sets of arrays, and the last one taken over once, but drawn twice
  const auto draw = [&] {
    std::vector<Picture> pictures(6);
    for (std::size_t k = 0; k < pictures.size(); ++k) {
      if (k < 5) stage.scene().set_frame(synthetic_scene(0.02 * static_cast<double>(k)).frame);
      if (k == 0) stage.go_home();
      stage.draw([&](Picture&& picture) { pictures[k] = std::move(picture); });
    }
    return pictures;
  };
  const std::vector<Picture> whole = draw();
  EXPECT_NE(whole[0].rgb, whole[4].rgb);
  EXPECT_EQ(stage.pacing(), nullptr) << "a software rasteriser shares no GPU";

  SteppingClock clock;
  stage.pace(new GpuPacing(clock.page(), clock.world()));
  for (int round = 0; round < 2; ++round) {
    const std::vector<Picture> pieces = draw();
    for (std::size_t k = 0; k < whole.size(); ++k) EXPECT_EQ(pieces[k].rgb, whole[k].rgb) << "picture " << k;
  }
  EXPECT_TRUE(stage.pacing()->shared());
  EXPECT_GT(stage.pacing()->waited_ns(), 0);
  EXPECT_GT(clock.page()->drawn_ns, 0);
  stage.pace(nullptr);
  EXPECT_EQ(draw()[4].rgb, whole[4].rgb);
  EXPECT_EQ(errors, 0);
}

INSTANTIATE_TEST_SUITE_P(Media, Pieces, testing::Values("water", "batter", "beads"),
                         [](const auto& look) { return std::string(look.param); });

}  // namespace
}  // namespace palp::test::pieces_image_test
