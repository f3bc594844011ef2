// Several windows on one scene: off-screen surfaces of one context, steered by events as windows send them.
#include "viewer/windows.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>

#include "tests/support/eventually.h"
#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"

namespace palp::test::windows_test {
namespace {

const StoredView kFromAbove{{0.01, -0.1, 0.6}, {0, 0, 0.02}, {0, 0, 1}};

osgViewer::GraphicsWindow& window_of(Stage& stage) {
  return dynamic_cast<osgViewer::GraphicsWindow&>(*stage.viewer().getCamera()->getGraphicsContext());
}

void show(Stage& stage, const char* look) {
  SyntheticScene s = synthetic_scene();
  if (std::string(look) == "beads")
    stage.scene().set_beads(true);
  else
    make_look(s.scene.bodies[0], look);
  set_scene(stage, s.scene);
  stage.scene().set_poses(s.poses);
  stage.scene().set_proxy(s.proxy);
  stage.scene().set_frame(s.frame);
  stage.go_home();
}

class Views : public testing::TestWithParam<const char*> {};

TEST_P(Views, OfOneSceneAreThoseThatWindowsOfTheirOwnWouldHave) {
  Stage first(small_stage());
  show(first, GetParam());
  const Picture alone = shoot(first);
  first.set_view(kFromAbove);
  const Picture above = shoot(first);
  first.go_home();

  Stage second(small_stage(), first), small(small_stage(160, 200), first);
  second.set_view(kFromAbove);
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(shoot(first).rgb, alone.rgb);
    EXPECT_EQ(shoot(second).rgb, above.rgb);
    EXPECT_GT(differing(alone, above), 10000);
    const Picture third = shoot(small);
    EXPECT_EQ(third.width, 160);
    EXPECT_EQ(third.height, 200);
    EXPECT_GT(find(third, [](Pixel p) { return p.r > 40; }).pixels, 1000);
  }
}

TEST_P(Views, KnowTheNextFrame) {
  Stage first(small_stage());
  show(first, GetParam());
  const SyntheticScene later = synthetic_scene(0.4);
  Stage second(small_stage(), first);
  const Picture before = shoot(second);
  first.scene().set_frame(later.frame);
  const Picture alone = shoot(first), beside = shoot(second);
  EXPECT_GT(differing(before, beside), 500);
  EXPECT_EQ(beside.rgb, alone.rgb);
}

INSTANTIATE_TEST_SUITE_P(Media, Views, testing::Values("water", "batter", "beads"),
                         [](const auto& look) { return std::string(look.param); });

TEST(SharedContext, HasTheParticlesOnce) {
  Stage first(small_stage()), second(small_stage(), first);
  show(first, "water");
  shoot(first);
  shoot(second);
  EXPECT_EQ(&first.scene(), &second.scene());
  EXPECT_EQ(window_of(first).getState(), window_of(second).getState());
}

TEST(SharedContext, LeavesTheOtherWindowWhenOneCloses) {
  Stage first(small_stage());
  show(first, "water");
  const Picture alone = shoot(first);
  {
    Stage second(small_stage(), first);
    shoot(second);
  }
  EXPECT_EQ(shoot(first).rgb, alone.rgb);
  // as a window manager closes it
  auto third = std::make_unique<Stage>(small_stage(200, 150), first);
  shoot(*third);
  window_of(*third).getEventQueue()->quitApplication();
  third->draw();
  EXPECT_TRUE(third->viewer().done());
  EXPECT_EQ(shoot(first).rgb, alone.rgb);
  third.reset();
  EXPECT_EQ(shoot(first).rgb, alone.rgb);
  EXPECT_FALSE(first.viewer().done());
}

TEST(SharedContext, EndsWithTheFirstWindow) {
  Stage first(small_stage());
  show(first, "water");
  Stage second(small_stage(), first);
  shoot(first);
  shoot(second);
  window_of(first).getEventQueue()->closeWindow();
  first.draw();
  second.draw();
  EXPECT_TRUE(first.viewer().done());
  EXPECT_TRUE(second.viewer().done());
}

TEST(SharedContext, ResizesOneWindowAlone) {
  Stage first(small_stage());
  show(first, "water");
  const Picture alone = shoot(first);
  Stage second(small_stage(), first);
  shoot(second);
  window_of(second).resized(0, 0, 200, 160);
  window_of(second).getEventQueue()->windowResize(0, 0, 200, 160);
  shoot(second);
  second.go_home();
  const Picture smaller = shoot(second);
  Stage made_so(small_stage(200, 160), first);
  EXPECT_LT(differing(smaller, shoot(made_so)), 200) << "but for rounding";
  EXPECT_EQ(smaller.width, 200);
  EXPECT_EQ(smaller.height, 160);
  EXPECT_EQ(first.width(), 320);
  EXPECT_EQ(shoot(first).rgb, alone.rgb);
}

class WindowsTest : public testing::Test {
 protected:
  void SetUp() override {
    options_.stage = small_stage();
    const Session::Send send = [this](CommandKind kind, const std::string&, const std::string&) {
      paused_ = paused_ || kind == CommandKind::pause;
    };
    session_ = std::make_unique<Session>(first_, ScalarField::none, send);
    panels_ = std::make_unique<Panels>(first_, *session_, send, ViewerSettings(), PanelOptions{PanelDetail::none});
    windows_ = std::make_unique<Windows>(first_, options_, *session_, *panels_);
    const SyntheticScene s = synthetic_scene();
    view_.scene = std::make_shared<const SceneDescription>(s.scene);
    view_.frame = std::make_shared<const ParticleFrame>(s.frame);
    view_.poses = std::make_shared<const BodyPoses>(s.poses);
    view_.status["sim_server"].process = "sim_server";
    ASSERT_TRUE(eventually([&] { return (session_->update(view_, now_), session_->surfaces_complete()); },
                           std::chrono::seconds(30)));
    round();
  }
  // One round of the program's loop.
  void round() {
    now_ += 50'000'000;
    view_.frame_time_ns = now_;
    ++view_.status["sim_server"].header.sequence;
    session_->update(view_, now_);
    panels_->update(view_, now_);
    shoot(first_);
    windows_->draw([this](Picture&& picture) { saved_ = std::move(picture); });
    windows_->obey();
  }
  void press(Stage& in, int key) {
    window_of(in).getEventQueue()->keyPress(key, window_of(in).getEventQueue()->getTime());
    window_of(in).getEventQueue()->keyRelease(key, window_of(in).getEventQueue()->getTime());
    round();
  }

  ViewerOptions options_;
  Stage first_{small_stage()};
  std::unique_ptr<Session> session_;
  std::unique_ptr<Panels> panels_;
  std::unique_ptr<Windows> windows_;
  FeedView view_;
  Picture saved_;
  bool paused_ = false;
  std::int64_t now_ = 100'000'000'000;
};

TEST_F(WindowsTest, OpenAndCloseByKey) {
  EXPECT_EQ(windows_->further(), 0u);
  press(first_, 'w');
  ASSERT_EQ(windows_->further(), 1u);
  press(windows_->at(0), 'w');
  ASSERT_EQ(windows_->further(), 2u);
  press(windows_->at(0), osgGA::GUIEventAdapter::KEY_Escape);
  EXPECT_EQ(windows_->further(), 1u);
  press(first_, 'W');
  EXPECT_EQ(windows_->further(), 0u);
  press(first_, 'W');
  EXPECT_FALSE(first_.viewer().done());
  for (int i = 0; i < kMostWindows + 2; ++i) press(first_, 'w');
  EXPECT_EQ(windows_->further(), static_cast<std::size_t>(kMostWindows - 1));
}

TEST_F(WindowsTest, HaveCamerasOfTheirOwn) {
  press(first_, 'w');
  Stage& second = windows_->at(0);
  const StoredView home = first_.view();
  second.set_view(kFromAbove);
  EXPECT_EQ(first_.view().eye, home.eye);
  panels_->act({Action::store_view, 3}, second);
  press(second, 'r');
  EXPECT_NEAR((second.view().eye - home.eye).length(), 0, 0.2) << "its own shape";
  const StoredView second_home = second.view();
  panels_->act({Action::recall_view, 3}, first_);
  EXPECT_NEAR((first_.view().eye - kFromAbove.eye).length(), 0, 1e-6);
  EXPECT_EQ(second.view().eye, second_home.eye);
  press(second, 't');
  EXPECT_TRUE(second.following());
  EXPECT_FALSE(first_.following());
}

TEST_F(WindowsTest, StandForTheWholeViewerInAllElse) {
  press(first_, 'w');
  Stage& second = windows_->at(0);
  press(second, ' ');
  EXPECT_TRUE(paused_);
  press(second, 'b');
  EXPECT_TRUE(session_->beads());
  press(second, 'h');
  EXPECT_TRUE(second.hud().help_shown());
  EXPECT_FALSE(first_.hud().help_shown());
  press(second, 's');
  round();
  EXPECT_EQ(saved_.width, second.width());
}

TEST_F(WindowsTest, HaveNoFiguresButTheBanner) {
  press(first_, 'w');
  Stage& second = windows_->at(0);
  for (int i = 0; i < 10; ++i) round();
  const Picture calm = shoot(second);
  view_.status["sim_server"].state = "fault";
  for (int i = 0; i < 10; ++i) round();
  EXPECT_GT(differing(calm, shoot(second)), 200) << "sim_server stopped";
  second.hud().set_visible(false);
  EXPECT_EQ(shoot(second).rgb, calm.rgb) << "what stands in it but for a banner";
}

// A new scene sends the cameras of all windows home.
TEST_F(WindowsTest, GoHomeWithANewScene) {
  press(first_, 'w');
  Stage& second = windows_->at(0);
  const StoredView home = second.view();
  second.set_view(kFromAbove);
  view_.scene = std::make_shared<const SceneDescription>(*view_.scene);
  ASSERT_TRUE(eventually([&] { return (session_->update(view_, now_), session_->surfaces_complete()); },
                         std::chrono::seconds(30)));
  EXPECT_NEAR((second.view().eye - home.eye).length(), 0, 0.05);
}

}  // namespace
}  // namespace palp::test::windows_test
