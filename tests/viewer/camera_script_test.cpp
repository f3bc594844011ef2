// The camera of a film: the way that it takes between its keys, and what is wrong with scripts.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "config/error.h"
#include "viewer/camera_script.h"

namespace palp::test {
namespace {

std::vector<CameraKey> keys() {
  return {{0, {1, 0, 1}, {0, 0, 0}, 30},
          {1, {1, 1, 1}, {0, 0, 0}, 30},
          {1.5, {0, 4, 1}, {0, 0, 0.2}, 20},
          {4, {0, 4.1, 2}, {0, 0, 0.2}, 40}};
}

TEST(CameraScript, GoesThroughItsKeysAndStandsBesideThem) {
  const auto all = keys();
  for (const CameraKey& key : all) {
    EXPECT_LT((camera_at(all, key.time).eye - key.eye).norm(), 1e-12);
    EXPECT_NEAR(camera_at(all, key.time).field_of_view, key.field_of_view, 1e-12);
  }
  EXPECT_EQ(camera_at(all, -5).eye, all.front().eye);
  EXPECT_EQ(camera_at(all, 50).eye, all.back().eye);
  EXPECT_EQ(camera_at({all[0]}, 3).eye, all[0].eye);
}

TEST(CameraScript, NeverLeavesTheRangeOfTheKeysBesideIt) {
  const auto all = keys();
  for (double t = 0; t < 4; t += 0.003) {
    const auto next = std::find_if(all.begin(), all.end(), [&](const CameraKey& key) { return key.time > t; });
    const CameraKey &a = *(next - 1), &b = *next, c = camera_at(all, t);
    for (int i = 0; i < 3; ++i) {
      EXPECT_GE(c.eye[i], std::min(a.eye[i], b.eye[i])) << t;
      EXPECT_LE(c.eye[i], std::max(a.eye[i], b.eye[i])) << t;
    }
    EXPECT_GE(c.field_of_view, std::min(a.field_of_view, b.field_of_view)) << t;
    EXPECT_LE(c.field_of_view, std::max(a.field_of_view, b.field_of_view)) << t;
  }
}

// Differences over a tenth of a millisecond: the speeds before and after it differ by no more than the acceleration,
// below 100 m/s^2 here, makes of that; a linear path would jump by 5 m/s at a key, one that is cut off by more.
TEST(CameraScript, HasNoJumpInSpeedAndRestsAtBothEnds) {
  const auto all = keys();
  constexpr double kStep = 1e-4;
  const auto speed = [&](double t) -> Eigen::Vector3d {
    return (camera_at(all, t + kStep).eye - camera_at(all, t).eye) / kStep;
  };
  for (double t = 0; t < 4.1; t += kStep) EXPECT_LT((speed(t) - speed(t - kStep)).norm(), 100 * kStep) << t;
  EXPECT_LT(speed(0).norm(), 0.01);
  EXPECT_LT(speed(4 - kStep).norm(), 0.01);
}

TEST(CameraScript, FadesCaptions) {
  const std::vector<Caption> captions{{1, 3, "pour"}};
  EXPECT_EQ(caption_at(captions, 0.9).opacity, 0);
  EXPECT_EQ(caption_at(captions, 2).text, "pour");
  EXPECT_EQ(caption_at(captions, 2).opacity, 1);
  EXPECT_NEAR(caption_at(captions, 1.15).opacity, 0.5, 1e-9);
  EXPECT_NEAR(caption_at(captions, 2.85).opacity, 0.5, 1e-9);
}

TEST(CameraScript, ReadsAWholeScript) {
  const CameraScript script = parse_camera_script(
      "description = \"a test\"\n[[key]]\ntime = 0\neye = [1, 2, 3]\nlook_at = [0, 0, 0]\n"
      "[[key]]\ntime = 2\neye = [2, 2, 3]\nlook_at = [0, 0, 1]\nfield_of_view_deg = 20\n"
      "[follow]\ndevice = 1\nshare = 0.5\n[[caption]]\nfrom = 1\nto = 2\ntext = \"hello\"\n",
      "s.toml");
  ASSERT_EQ(script.keys.size(), 2u);
  EXPECT_EQ(script.keys[0].field_of_view, kFieldOfView);
  EXPECT_EQ(script.keys[1].field_of_view, 20);
  ASSERT_TRUE(script.follow);
  EXPECT_EQ(script.follow->device, 1u);
  EXPECT_EQ(script.captions.at(0).text, "hello");
}

TEST(CameraScript, FaultsNameFileAndLine) {
  const std::string key = "[[key]]\ntime = 1\neye = [1, 0, 1]\nlook_at = [0, 0, 0]\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "s.toml"},
      {"", "no [[key]]"},
      {key + "[[key]]\ntime = 1\neye = [1, 0, 1]\nlook_at = [0, 0, 0]\n", "s.toml:6"},
      {"[[key]]\ntime = 1\neye = [1, 0]\nlook_at = [0, 0, 0]\n", "s.toml:3"},
      {"[[key]]\ntime = 1\neye = [1, nan, 0]\nlook_at = [0, 0, 0]\n", "s.toml:3"},
      {"[[key]]\neye = [1, 0, 1]\nlook_at = [0, 0, 0]\n", "time"},
      {"[[key]]\ntime = 1\neye = [1, 1, 1]\nlook_at = [1, 1, 1]\n", "less than 1 mm from eye"},
      {"[[key]]\ntime = 1\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\n", "2 degrees of vertical"},
      {key + "field_of_view_deg = 180\n", "s.toml:5"},
      {key + "fov = 20\n", "fov"},
      {key + "[follow]\ndevice = 8\n", "s.toml:6"},
      {key + "[[caption]]\nfrom = 2\nto = 1\ntext = \"x\"\n", "s.toml:7"},
      {key + "[[caption]]\nfrom = 0\nto = 2\ntext = \"x\"\n[[caption]]\nfrom = 1\nto = 3\ntext = \"y\"\n", "s.toml:10"},
  };
  for (const auto& [text, expected] : cases) {
    try {
      parse_camera_script(text, "s.toml");
      ADD_FAILURE() << "accepted: " << text;
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << text << "\n" << error.what();
    }
  }
}

TEST(CameraScript, ThoseThatComeWithPalpAreSound) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(PALP_SOURCE_DIR "/config/films")) {
    if (entry.path().extension() != ".toml") continue;
    ++count;
    EXPECT_NO_THROW(read_camera_script(entry.path())) << entry.path();
  }
  EXPECT_GE(count, 4);
}

}  // namespace
}  // namespace palp::test
