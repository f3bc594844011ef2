// The viewer's answers to what it hears and to its keys: a session with a stage and views made by hand.
#include "viewer/session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/follow.h"

namespace palp::test {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

class SessionTest : public testing::Test {
 protected:
  Session& start(ScalarField color) {
    session_ = std::make_unique<Session>(
        stage_, color, [this](CommandKind, const std::string&, const std::string& value) { asked_.push_back(value); });
    const SyntheticScene s = synthetic_scene();
    view_.scene = std::make_shared<const SceneDescription>(s.scene);
    return *session_;
  }
  void hear_frame(ScalarField field) {
    view_.frame = std::make_shared<const ParticleFrame>(synthetic_scene(0.4, field).frame);
    view_.frame_time_ns = now_;
    ++view_.frames;
  }
  void hear_status(const std::string& state) {
    Status& status = view_.status["sim_server"];
    status.process = "sim_server";
    status.state = state;
    status.metrics = {{"real_time_factor", 1}};
    ++status.header.sequence;
  }
  std::string banner_after(double seconds) {
    now_ += static_cast<std::int64_t>(seconds * 1e9);
    session_->update(view_, now_);
    return hud_banner(session_->figures());
  }

  // Surfaces are built in the clock's time and not in the test's: what is shown of them must not depend on the machine.
  void wait_for_surfaces() {
    session_->update(view_, now_);
    ASSERT_TRUE(eventually([&] { return (session_->update(view_, now_), session_->surfaces_complete()); },
                           std::chrono::seconds(30)));
    now_ += kSecond;  // the figures are made anew with the next view
  }

  Stage stage_{small_stage(64, 48)};
  std::unique_ptr<Session> session_;
  FeedView view_;
  std::vector<std::string> asked_;
  std::int64_t now_ = 100 * kSecond;
};

TEST_F(SessionTest, TheColorKeyReachesEveryField) {
  Session& session = start(ScalarField::none);
  session.update(view_, now_);
  for (std::size_t i = 0; i < kScalarFields.size(); ++i) session.act({Action::next_color});
  EXPECT_EQ(asked_,
            (std::vector<std::string>{"speed", "density", "pressure", "temperature", "density_error", "state"}));
}

TEST_F(SessionTest, AFieldThatAnotherViewerAskedForIsNamed) {
  start(ScalarField::speed);
  wait_for_surfaces();
  hear_frame(ScalarField::density);
  EXPECT_EQ(banner_after(0.01), "") << "the server has had no time to answer";
  hear_frame(ScalarField::density);
  EXPECT_EQ(banner_after(1.5), "asked: speed, the server sends density");
  hear_frame(ScalarField::speed);
  EXPECT_EQ(banner_after(0.5), "");
  hear_frame(ScalarField::density);
  EXPECT_EQ(banner_after(0.5), "asked: speed, the server sends density (asked by another)");
  EXPECT_EQ(asked_, std::vector<std::string>{"speed"}) << "two viewers must not outbid each other for ever";
}

TEST_F(SessionTest, ASceneWithoutTemperaturesSaysSo) {
  start(ScalarField::temperature);
  wait_for_surfaces();
  hear_frame(ScalarField::temperature);
  EXPECT_EQ(banner_after(0.5), "");
  ParticleFrame cold = *view_.frame;
  std::ranges::fill(cold.scalars, 0.0f);
  view_.frame = std::make_shared<const ParticleFrame>(cold);
  EXPECT_EQ(banner_after(0.5), "this scene has no temperatures");
}

TEST_F(SessionTest, AViewerThatAskedForNothingShowsHowThingsLook) {
  start(ScalarField::none);
  for (const ScalarField field : {ScalarField::speed, ScalarField::density}) {
    hear_frame(field);
    EXPECT_EQ(banner_after(0.5), "");
    EXPECT_EQ(stage_.scene().cloud().shown_field(), ScalarField::none);
  }
  EXPECT_TRUE(asked_.empty());
}

TEST_F(SessionTest, AServerThatEndedIsNamedAndOneThatFellSilentToo) {
  start(ScalarField::none);
  wait_for_surfaces();
  hear_frame(ScalarField::speed);
  hear_status("running");
  EXPECT_EQ(banner_after(0.1), "");
  EXPECT_EQ(banner_after(2.5).substr(0, 12), "no particles");
  EXPECT_EQ(banner_after(2.5), "sim_server has ended or hangs: nothing heard for 5.0 s");
  hear_status("ended");
  EXPECT_EQ(banner_after(0.5), "sim_server has ended");
  view_.status.clear();  // as the feed forgets it
  EXPECT_EQ(banner_after(10), "sim_server has ended");
}

TEST_F(SessionTest, APausedServerHasNoPace) {
  start(ScalarField::none);
  hear_frame(ScalarField::speed);
  hear_status("paused");
  EXPECT_EQ(banner_after(0.1), "paused");
  std::string simulated;
  for (const HudRow& row : hud_rows(session_->figures()))
    if (row.label == "simulated") simulated = row.value;
  EXPECT_NE(simulated.find("paused, ×0 real time"), std::string::npos) << simulated;
  EXPECT_EQ(simulated.find("1.00"), std::string::npos) << simulated;
}

TEST_F(SessionTest, TheLegendFollowsMapAndHeldRange) {
  Session& session = start(ScalarField::speed);
  wait_for_surfaces();
  hear_frame(ScalarField::speed);
  session.update(view_, now_);
  const ParticleCloud& cloud = stage_.scene().cloud();
  EXPECT_EQ(cloud.color_map_kind(), ColorMapKind::sequential);
  const ValueRange suiting = cloud.range();
  for (const ColorMapKind kind : {ColorMapKind::sequential, ColorMapKind::diverging, ColorMapKind::viridis}) {
    session.act({Action::next_map});
    EXPECT_EQ(cloud.color_map_kind(), kind);
  }
  session.act({Action::hold_range});
  EXPECT_EQ(session.reading().held_of(ScalarField::speed), suiting);
  Reading reading = session.reading();
  reading.held_of(ScalarField::speed) = ValueRange{1, 2};
  session.set_reading(reading);
  EXPECT_EQ(cloud.range(), (ValueRange{1, 2}));
  session.act({Action::hold_range});
  EXPECT_EQ(cloud.range(), suiting);
}

TEST_F(SessionTest, TheCutMovesByKeyAndStaysInTheScene) {
  Session& session = start(ScalarField::none);
  wait_for_surfaces();
  EXPECT_EQ(stage_.scene().clip(), kNoClip);
  session.act({Action::clip});
  EXPECT_NE(stage_.scene().clip(), kNoClip);
  session.act({Action::clip_axis});
  EXPECT_EQ(session.reading().clip.axis, 2);
  const double before = session.reading().clip.share;
  session.act({Action::clip_forth});
  EXPECT_GT(session.reading().clip.share, before);
  for (int i = 0; i < 200; ++i) session.act({Action::clip_back});
  EXPECT_EQ(session.reading().clip.share, 0);
  session.act({Action::clip});
  EXPECT_EQ(stage_.scene().clip(), kNoClip);
}

TEST_F(SessionTest, WhatIsTouchedIsMarkedByKeyAndTold) {
  Session& session = start(ScalarField::none);
  SyntheticScene s = synthetic_scene(0.4, ScalarField::pressure);
  s.scene.proxies = {{0, 2, s.poses.pose[0]}};
  view_.scene = std::make_shared<const SceneDescription>(s.scene);
  view_.poses = std::make_shared<const BodyPoses>(s.poses);
  hear_frame(ScalarField::pressure);
  wait_for_surfaces();
  session.update(view_, now_);
  EXPECT_FALSE(session.touch_marked() || session.figures().touched);
  session.act({Action::touch});
  session.update(view_, now_);
  ASSERT_TRUE(session.touch_marked() && session.figures().touched);
  EXPECT_GT(session.figures().touched->area, 0);
  EXPECT_FALSE(session.figures().touched->pressure);
  session.show_field(ScalarField::pressure);
  session.update(view_, now_);
  EXPECT_TRUE(session.figures().touched->pressure);
  session.act({Action::touch});
  session.update(view_, now_);
  EXPECT_FALSE(session.touch_marked() || session.figures().touched);
}

TEST_F(SessionTest, TheCameraFollowsTheToolWhenAsked) {
  Session& session = start(ScalarField::none);
  SceneDescription scene = *view_.scene;
  scene.proxies.push_back({0, 2, {}});
  view_.scene = std::make_shared<const SceneDescription>(scene);
  view_.poses = std::make_shared<const BodyPoses>(synthetic_scene().poses);
  wait_for_surfaces();
  const osg::Vec3d before = stage_.view().center;
  now_ += kSecond / 10;
  session.update(view_, now_);
  EXPECT_EQ(stage_.view().center, before);
  session.act({Action::follow});
  double last = 1e9;
  for (int i = 0; i < 40; ++i) {
    now_ += kSecond / 10;
    session.update(view_, now_);
    const std::vector<osg::Vec3d> tools = stage_.scene().tools();
    ASSERT_FALSE(tools.empty());
    const double off = (stage_.view().center - middle_of(tools)).length();
    EXPECT_LE(off, last + 1e-9);
    last = off;
  }
  EXPECT_LT(last, 1e-3);
}

// The arrows follow every sample, and numbers that one can read stand still for a while: all of them say the same.
TEST_F(SessionTest, TheValuesBesideTheArrowsAreThoseOfTheFigures) {
  start(ScalarField::none);
  wait_for_surfaces();
  const auto figures = [this] {
    for (const HudRow& row : hud_rows(session_->figures()))
      if (row.label == "force") return row.value;
    return std::string();
  };
  view_.proxies[1] = synthetic_scene().proxy;
  view_.proxies[1]->device = 1;
  for (const double torque : {0.490, 0.435, 0.381}) {
    view_.proxies[1]->wrench.torque = {0, 0, torque};
    now_ += kSecond / 10;
    session_->update(view_, now_);
    EXPECT_EQ(stage_.scene().hand(1).values(), figures());
  }
  now_ += kSecond;
  session_->update(view_, now_);
  EXPECT_EQ(figures(), "2.05 N  ·  0.381 N m");
  EXPECT_EQ(stage_.scene().hand(1).values(), figures());
  view_.proxies[1].reset();
  session_->update(view_, now_);
  EXPECT_EQ(stage_.scene().hand(1).values(), "") << "the hand has gone";
}

// A surface of millions of triangles: the session goes on at once, says how far it is, and can be dropped.
TEST_F(SessionTest, ALargeSurfaceIsBuiltBesideThePictures) {
  Session& session = start(ScalarField::none);
  SceneDescription scene = *view_.scene;
  const BodyDescription block = scene.bodies[1];
  BodyDescription& large = scene.bodies[1];
  while (large.triangles.size() < 6'000'000)
    large.triangles.insert(large.triangles.end(), block.triangles.begin(), block.triangles.end());
  view_.scene = std::make_shared<const SceneDescription>(scene);
  hear_frame(ScalarField::speed);
  session.update(view_, now_);
  EXPECT_FALSE(session.surfaces_complete());
  EXPECT_EQ(session.frames_drawn(), 1u) << "particles are shown meanwhile";
  EXPECT_NE(banner_after(0.6).find("building surfaces: "), std::string::npos);
  EXPECT_FALSE(session.surfaces_complete());
}

}  // namespace
}  // namespace palp::test
