// Keys and mouse of a recording that is played, and the timeline that they act on.
#include "viewer/playback_keys.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/files.h"
#include "tests/viewer/recorded_scene.h"

namespace palp::test {
namespace {

using Event = osgGA::GUIEventAdapter;

class NoAction : public osgGA::GUIActionAdapter {
 public:
  osg::View* asView() override { return nullptr; }
  void requestRedraw() override {}
  void requestContinuousUpdate(bool) override {}
  void requestWarpPointer(float, float) override {}
};

class PlaybackKeysTest : public testing::Test {
 protected:
  PlaybackKeysTest() {
    overlay_.set_size(400, 300);
    overlay_.set_timeline_shown(true);
  }
  bool press(int key) {
    osg::ref_ptr<Event> event = new Event;
    event->setEventType(Event::KEYDOWN);
    event->setKey(key);
    return keys_->handle(*event, action_, nullptr, nullptr);
  }
  bool mouse(Event::EventType type, float x, float y) {
    osg::ref_ptr<Event> event = new Event;
    event->setEventType(type);
    event->setX(x);
    event->setY(y);
    return keys_->handle(*event, action_, nullptr, nullptr);
  }
  static std::string recorded(const ScratchFolder& folder) {
    record_scene(folder / "r.mcap");
    return folder / "r.mcap";
  }

  ScratchFolder folder_;
  Playback playback_{recorded(folder_)};
  ReplayOverlay overlay_;
  osg::ref_ptr<PlaybackKeys> keys_ = new PlaybackKeys(playback_, overlay_);
  NoAction action_;
};

TEST_F(PlaybackKeysTest, KeysPauseStepAndChangeTheSpeed) {
  EXPECT_TRUE(press(' '));
  EXPECT_TRUE(playback_.paused());
  press('.');
  EXPECT_DOUBLE_EQ(playback_.time(), 0.05);
  press(',');
  EXPECT_DOUBLE_EQ(playback_.time(), 0);
  press(']');
  EXPECT_DOUBLE_EQ(playback_.speed(), 2);
  for (int i = 0; i < 9; ++i) press('[');
  EXPECT_DOUBLE_EQ(playback_.speed(), 0.1);
  for (int i = 0; i < 9; ++i) press(']');
  EXPECT_DOUBLE_EQ(playback_.speed(), 10);
  press(Event::KEY_End);
  EXPECT_DOUBLE_EQ(playback_.time(), 1);
  press(Event::KEY_Left);
  EXPECT_DOUBLE_EQ(playback_.time(), 0);
  press(Event::KEY_Right);
  EXPECT_DOUBLE_EQ(playback_.time(), 1);
  press(Event::KEY_Home);
  EXPECT_DOUBLE_EQ(playback_.time(), 0);
  EXPECT_FALSE(press('c'));  // the viewer's own keys are left to it
}

TEST_F(PlaybackKeysTest, DraggingAlongTheTimelineScrubs) {
  float left = 0, right = 0;
  for (float x = 0; x < 400; ++x) {
    if (overlay_.share_at(x) == 0) left = x;
    if (right == 0 && overlay_.share_at(x) == 1) right = x;
  }
  ASSERT_LT(left, right);
  float y = 0;
  while (y < 100 && !overlay_.on_timeline(left + 5, y)) ++y;
  ASSERT_LT(y, 100);
  EXPECT_FALSE(mouse(Event::PUSH, 200, 200)) << "the camera's";
  EXPECT_FALSE(mouse(Event::DRAG, 100, y));
  EXPECT_DOUBLE_EQ(playback_.time(), 0);
  EXPECT_TRUE(mouse(Event::PUSH, left + 5, y));
  EXPECT_TRUE(mouse(Event::DRAG, (left + right) / 2, 200));
  EXPECT_NEAR(playback_.time(), 0.5, 0.01);
  EXPECT_TRUE(mouse(Event::DRAG, 399, 200));
  EXPECT_DOUBLE_EQ(playback_.time(), 1);
  EXPECT_TRUE(mouse(Event::RELEASE, 399, 200));
  EXPECT_FALSE(mouse(Event::DRAG, 200, y));
  overlay_.set_timeline_shown(false);
  EXPECT_FALSE(mouse(Event::PUSH, left + 5, y));
}

TEST_F(PlaybackKeysTest, TheTimelineSaysTimeAndSpeed) {
  overlay_.set_timeline(0, 8, 2.5, 0.5, true);
  EXPECT_EQ(overlay_.words(), "2.50 of 8.00 s  ·  ×0.5  ·  paused");
}

// Beside panels the timeline is shorter, and still goes from first to last.
TEST_F(PlaybackKeysTest, TheTimelineKeepsClearOfPanels) {
  overlay_.set_size(400, 300, 150);
  EXPECT_FALSE(overlay_.on_timeline(255, 8));
  EXPECT_TRUE(overlay_.on_timeline(100, 8));
  EXPECT_EQ(overlay_.share_at(250), 1);
}

TEST_F(PlaybackKeysTest, ACommandThatPanelsSendTellsNothing) {
  playback_.obey(CommandKind::get_parameter, "");
  EXPECT_EQ(playback_.view(0).notice, "");
  playback_.obey(CommandKind::quit, "");
  EXPECT_NE(playback_.view(0).notice, "");
}

TEST(PlaybackHelp, NamesEachKeyOnce) {
  std::set<std::string> keys;
  for (const auto& [key, meaning] : playback_help_lines()) EXPECT_TRUE(keys.insert(key).second) << key;
  for (const char* key : {"space", ". ,", "Home End", "h", "Esc"}) EXPECT_TRUE(keys.contains(key)) << key;
  EXPECT_FALSE(keys.contains("n"));
}

}  // namespace
}  // namespace palp::test
