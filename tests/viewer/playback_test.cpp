// A recording played: the time that it is played in, what is shown at a time, the controls, and files that are damaged.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "idl/mcap/mcap_format.h"
#include "tests/support/files.h"
#include "tests/support/recordings.h"
#include "tests/viewer/recorded_scene.h"
#include "viewer/playback.h"

namespace palp::test {
namespace {

constexpr std::int64_t kNow = 5'000'000'000;

class PlaybackOf : public testing::Test {
 protected:
  std::string file() const { return folder_ / "r.mcap"; }
  std::string fault() const {
    try {
      Playback playback(file());
    } catch (const McapError& error) {
      return error.what();
    }
    return "";
  }
  void cut_to(double share) const {
    Bytes bytes = file_bytes(file());
    bytes.resize(static_cast<std::size_t>(share * static_cast<double>(bytes.size())));
    write_file(file(), bytes);
  }

  ScratchFolder folder_;
};

TEST_F(PlaybackOf, ShowsTheFramesOfTheFile) {
  record_scene(file());
  Playback playback(file());
  EXPECT_DOUBLE_EQ(playback.range().first, 0);
  EXPECT_DOUBLE_EQ(playback.range().last, 1);
  for (const double time : {0.0, 0.5, 0.05, 1.0}) {
    playback.seek(time);
    const FeedView view = playback.view(kNow);
    ASSERT_TRUE(view.scene && view.frame && view.poses && view.proxies[0]) << time;
    const SyntheticScene s = synthetic_scene(time);
    EXPECT_EQ(view.scene->name, s.scene.name);
    EXPECT_NEAR(view.frame->sim_time, time, 1e-9);
    // the first particles are of the formula at that very time
    for (std::size_t i = 0; i < 300; ++i) EXPECT_EQ(view.frame->positions[i], s.frame.positions[i]) << time;
    EXPECT_NEAR(view.poses->pose[0].position[0], s.poses.pose[0].position[0], 1e-9);
    EXPECT_EQ(view.proxies[0]->wrench, s.proxy.wrench);
    EXPECT_EQ(view.frame_time_ns, kNow);
  }
}

// Straight between frames: the path of the paddle, a circle of 5 cm in 3.1 s, is left by r (w dt)^2 / 8 = 6e-5 m, where
// the newest frame lags by up to 5e-3 m.
TEST_F(PlaybackOf, IsBetweenFramesBetweenThem) {
  record_scene(file());
  Playback playback(file());
  for (const double time : {0.025, 0.31, 0.987}) {
    playback.seek(time);
    const FeedView view = playback.view(kNow);
    const SyntheticScene s = synthetic_scene(time);
    EXPECT_NEAR(view.frame->sim_time, time, 1e-9);
    EXPECT_NEAR(view.poses->sim_time, time, 1e-9);
    for (int axis = 0; axis < 2; ++axis)
      EXPECT_NEAR(view.poses->pose[0].position[axis], s.poses.pose[0].position[axis], 7e-5) << time;
  }
}

// Speeds follow from where particles were one recorded frame before, whatever was shown before.
TEST_F(PlaybackOf, TellsWhereALiquidThatFoamsWasAFrameEarlier) {
  record_scene(file(), 21, 1);
  Playback playback(file());
  const auto seek = [&](double time) {
    playback.seek(time);
    return playback.view(kNow);
  };
  EXPECT_FALSE(seek(0).earlier) << "nothing was before";
  const auto lift = [&](double time) {  // of the first particle, which waves move
    const FeedView view = seek(time);
    if (!view.earlier) return std::nanf("");
    EXPECT_NEAR(view.earlier->sim_time, time - 0.05, 1e-9);
    return view.frame->positions[2] - view.earlier->positions[2];
  };
  for (const double frame : {0.25, 0.5}) {
    const float before = lift(frame - 1e-6), there = lift(frame), after = lift(frame + 1e-6);
    EXPECT_NEAR(before, there, 1e-6) << "without a step";
    EXPECT_NEAR(after, there, 1e-6);
  }
  const std::vector<float> once = seek(0.73).earlier->positions;
  seek(0.1);
  EXPECT_EQ(seek(0.73).earlier->positions, once);
}

TEST_F(PlaybackOf, DoesNotLookForSpeedsWhereNothingFoams) {
  record_scene(file());
  Playback playback(file());
  playback.seek(0.31);
  EXPECT_FALSE(playback.view(kNow).earlier);
}

TEST_F(PlaybackOf, AddsNoMotionWhereFramesAreFarApart) {
  SceneRecorder recorder(file());
  recorder.scene(0);
  recorder.frame(0, 0);
  recorder.frame(0.5, 0.5);
  recorder.close();
  Playback playback(file());
  playback.seek(0.4);
  const FeedView view = playback.view(kNow);
  EXPECT_EQ(view.frame->sim_time, 0);
  EXPECT_EQ(view.poses->pose[0].position, synthetic_scene(0).poses.pose[0].position);
}

TEST_F(PlaybackOf, PassesTimeAtItsSpeedAndPausesAtTheEnd) {
  record_scene(file());
  Playback playback(file());
  playback.advance(0.25);
  EXPECT_DOUBLE_EQ(playback.time(), 0.25);
  playback.set_speed(0.1);
  playback.advance(1);
  EXPECT_DOUBLE_EQ(playback.time(), 0.35);
  playback.set_paused(true);
  playback.advance(1);
  EXPECT_DOUBLE_EQ(playback.time(), 0.35);
  EXPECT_EQ(playback.view(kNow).status.at("sim_server").state, "paused");
  playback.set_paused(false);
  EXPECT_EQ(playback.view(kNow).status.at("sim_server").state, "running");
  playback.set_speed(1000);
  EXPECT_DOUBLE_EQ(playback.speed(), 10);
  playback.set_speed(std::numeric_limits<double>::quiet_NaN());
  EXPECT_DOUBLE_EQ(playback.speed(), 10);
  playback.advance(1);
  EXPECT_DOUBLE_EQ(playback.time(), 1);
  EXPECT_TRUE(playback.paused());
  playback.set_paused(false);  // at the end it begins again
  EXPECT_DOUBLE_EQ(playback.time(), 0);
}

TEST_F(PlaybackOf, StepsByRecordedFrames) {
  record_scene(file());
  Playback playback(file());
  playback.seek(0.26);
  playback.step(1);
  EXPECT_DOUBLE_EQ(playback.time(), 0.05 * 6);
  EXPECT_TRUE(playback.paused());
  playback.step(-1);
  EXPECT_DOUBLE_EQ(playback.time(), 0.05 * 5);
  playback.seek(0.26);
  playback.step(-1);  // to the frame that is shown in part
  EXPECT_DOUBLE_EQ(playback.time(), 0.05 * 5);
  playback.step(-100);
  EXPECT_DOUBLE_EQ(playback.time(), 0);
  playback.step(100);
  EXPECT_DOUBLE_EQ(playback.time(), 1);
  playback.seek(std::numeric_limits<double>::infinity());
  EXPECT_DOUBLE_EQ(playback.time(), 1);
}

TEST_F(PlaybackOf, ObeysAsAServerDoes) {
  record_scene(file());
  Playback playback(file());
  playback.seek(0.5);
  playback.obey(CommandKind::pause, "");
  EXPECT_TRUE(playback.paused());
  playback.obey(CommandKind::step, "");
  EXPECT_DOUBLE_EQ(playback.time(), 0.05 * 11);
  playback.obey(CommandKind::reset, "");
  EXPECT_DOUBLE_EQ(playback.time(), 0);
  playback.obey(CommandKind::set_parameter, "gravity");
  EXPECT_NE(playback.view(kNow).notice.find("gravity stays as it is"), std::string::npos);
  EXPECT_EQ(playback.view(kNow + 7'000'000'000).notice, "");
}

// A server that hangs falls silent; a player that is paused does not.
TEST_F(PlaybackOf, IsHeardWhilePaused) {
  record_scene(file());
  Playback playback(file());
  playback.set_paused(true);
  const auto first = playback.view(kNow).status.at("sim_server").header.sequence;
  EXPECT_NE(playback.view(kNow + 1).status.at("sim_server").header.sequence, first);
}

TEST_F(PlaybackOf, GoesOnWhereTheSimulationBeganAnew) {
  SceneRecorder recorder(file());
  recorder.scene(0);
  for (int i = 0; i < 11; ++i) recorder.frame(0.05 * i, 0.05 * i);
  for (int i = 0; i < 10; ++i) recorder.frame(1 + 0.05 * i, 0.5);       // paused
  for (int i = 0; i < 11; ++i) recorder.frame(2 + 0.05 * i, 0.05 * i);  // reset
  recorder.close();
  Playback playback(file());
  EXPECT_NEAR(playback.range().last, 1, 1e-9);
  playback.seek(0.75);
  EXPECT_NEAR(playback.view(kNow).frame->sim_time, 0.25, 1e-9);
  EXPECT_NEAR(playback.view(kNow).poses->sim_time, 0.25, 1e-9);
}

// A reset between two frames of the recording: nothing moves from the end of one run to the begin of the next.
TEST_F(PlaybackOf, ARunDoesNotGoOverIntoTheNext) {
  SceneRecorder recorder(file());
  recorder.scene(0);
  for (int i = 0; i < 11; ++i) recorder.frame(0.05 * i, 0.05 * i);
  recorder.proxy(0.51, 0.51);
  recorder.proxy(0.52, 0.52);
  for (int i = 0; i < 11; ++i) recorder.frame(0.53 + 0.05 * i, 0.05 * i);
  recorder.close();
  Playback playback(file());
  playback.seek(0.515);
  const FeedView view = playback.view(kNow);
  EXPECT_EQ(view.frame->sim_time, 0.5);
  EXPECT_EQ(view.poses->pose[0].position, synthetic_scene(0.5).poses.pose[0].position);
}

TEST_F(PlaybackOf, LeavesOutFramesThatAreNotWhole) {
  SceneRecorder recorder(file());
  recorder.scene(0);
  recorder.frame(0, 0);
  recorder.frame(0.05, 0.05, 0);
  recorder.frame(0.1, 0.1);
  recorder.close();
  Playback playback(file());
  playback.seek(0.06);
  playback.step(1);
  EXPECT_NEAR(playback.time(), 0.1, 1e-9);
}

TEST_F(PlaybackOf, TellsOfAFaultWhileItIsNews) {
  SceneRecorder recorder(file());
  recorder.scene(0);
  for (int i = 0; i < 200; ++i) {
    recorder.frame(0.05 * i, 0.05 * i);
    if (i == 20) recorder.event(0.05 * i, "it blew up");
  }
  recorder.close();
  Playback playback(file());
  EXPECT_EQ(playback.view(kNow).notice, "");
  playback.seek(2);
  EXPECT_EQ(playback.view(kNow).notice, "sim_server: it blew up");
  playback.seek(9);
  EXPECT_EQ(playback.view(kNow).notice, "");
}

TEST_F(PlaybackOf, ShowsWhatIsLeftOfAFileThatWasCut) {
  record_scene(file(), 201);
  cut_to(0.5);
  Playback playback(file());
  EXPECT_GT(playback.range().last, 2);
  EXPECT_LT(playback.range().last, 6);
  playback.seek(playback.range().last);
  EXPECT_TRUE(playback.view(kNow).frame);
}

TEST_F(PlaybackOf, ShowsWhatIsLeftOfADamagedFile) {
  record_scene(file(), 201);
  Bytes bytes = file_bytes(file());
  for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 100; ++i) bytes[i] ^= 0x55;
  write_file(file(), bytes);
  Playback playback(file());
  EXPECT_NEAR(playback.range().last, 10, 1e-9);
  for (double time = 0; time <= 10; time += 0.1) {
    playback.seek(time);
    EXPECT_TRUE(playback.view(kNow).frame) << time;
  }
}

TEST_F(PlaybackOf, RefusesInOneSentence) {
  EXPECT_NE(fault().find("cannot be opened"), std::string::npos);
  write_text(file(), "no recording at all, but long enough");
  EXPECT_NE(fault().find("is not an MCAP file"), std::string::npos) << fault();
  std::filesystem::remove(file());
  make_file(file(), 10, 1);
  EXPECT_NE(fault().find("holds no topic of palp"), std::string::npos) << fault();
  record_scene(file());
  cut_to(0.02);
  EXPECT_NE(fault().find("no whole frame"), std::string::npos) << fault();
}

TEST_F(PlaybackOf, NamesAProtocolThatItDoesNotRead) {
  {
    McapWriterOptions options;
    options.overwrite = true;
    McapWriter writer(file(), options);
    const std::uint16_t channel = add_topic(writer, topic_of<SceneDescription>());
    SceneDescription scene = synthetic_scene().scene;
    scene.header = {kProtocolVersion + 6, 7, 1, 1};
    const auto payload = to_cdr(scene);
    writer.write({channel, 1, 1, 1, payload});
    writer.close();
  }
  const std::string wanted = "recorded with protocol version " + std::to_string(kProtocolVersion + 6);
  EXPECT_NE(fault().find(wanted), std::string::npos) << fault();
}

TEST_F(PlaybackOf, KnowsWhereTheHandleIs) {
  record_scene(file());
  Playback playback(file());
  const auto start = playback.handle_at_start(0), later = playback.handle_at(0, 0.5);
  ASSERT_TRUE(start && later);
  EXPECT_NEAR(start->x(), 0.05, 1e-9);
  EXPECT_NEAR(later->x(), synthetic_scene(0.5).poses.pose[0].position[0], 1e-9);
  EXPECT_FALSE(playback.handle_at(1, 0.5));
  EXPECT_FALSE(playback.handle_at(99, 0.5));
}

}  // namespace
}  // namespace palp::test
