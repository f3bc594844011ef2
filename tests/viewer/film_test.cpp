// Films as people make them: the real program, a recording, no bus and no display.
#include <gtest/gtest.h>

#include <filesystem>

#include <osg/Image>
#include <osgDB/ReadFile>

#include "tests/support/process.h"
#include "tests/viewer/recorded_scene.h"

namespace palp::test {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

class Film : public testing::Test {
 protected:
  void SetUp() override { record_scene(folder_ / "r.mcap"); }

  Outcome make(const std::vector<std::string>& more, const std::string& size = "160x120") const {
    std::vector<std::string> command{std::string(PALP_BIN_DIR) + "/palp-viewer",
                                     "--headless",
                                     "--gpu",
                                     "cpu",
                                     "--gl-errors",
                                     "--size",
                                     size,
                                     "--replay",
                                     folder_ / "r.mcap"};
    command.insert(command.end(), more.begin(), more.end());
    return run_program(command, 60s);
  }
  std::string script() const {
    write_text(folder_ / "s.toml",
               "[[key]]\ntime = 0\neye = [0.5, -0.6, 0.4]\nlook_at = [0, 0, 0]\n"
               "[[key]]\ntime = 1\neye = [-0.2, -0.3, 0.3]\nlook_at = [0, 0, 0.05]\nfield_of_view_deg = 40\n"
               "[follow]\nshare = 0.3\n[[caption]]\nfrom = 0\nto = 1\ntext = \"stirring\"\n");
    return folder_ / "s.toml";
  }
  static int files_in(const std::string& folder) {
    return static_cast<int>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }

  ScratchFolder folder_;
};

TEST_F(Film, TheSameCommandGivesTheSameBytes) {
  std::vector<std::string> first, second;
  for (auto* pictures : {&first, &second}) {
    const std::string folder = folder_ / (pictures == &first ? "a" : "b");
    fs::create_directory(folder);
    const Outcome made = make({"--frames", folder + "/f.png", "--fps", "10", "--script", script(), "--mean-of", "2"});
    ASSERT_EQ(made.status, 0) << made.output;
    ASSERT_EQ(files_in(folder), 10);
    for (int i = 1; i <= 10; ++i)
      pictures->push_back(text_of(folder + "/f-" + (i < 10 ? "000" : "00") + std::to_string(i) + ".png"));
  }
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_GT(first[i].size(), 500u) << i;
    EXPECT_TRUE(first[i] == second[i]) << "picture " << i + 1 << " differs";
    EXPECT_TRUE(i == 0 || first[i] != first[i - 1]) << "picture " << i + 1 << " is that before it";
  }
}

// A picture depends on its simulated time alone, however many a second there are.
TEST_F(Film, PicturesAreOfExactSimulatedTimes) {
  const std::vector<std::string> plain{"--no-figures", "--script", script()};
  const auto picture = [&](std::vector<std::string> more, const std::string& file) {
    more.insert(more.end(), plain.begin(), plain.end());
    const Outcome made = make(more);
    EXPECT_EQ(made.status, 0) << made.output;
    return text_of(file);
  };
  fs::create_directory(folder_ / "a");
  const std::string fast = picture({"--frames", folder_ / "a/f.png", "--fps", "20"}, folder_ / "a/f-0011.png"),
                    still = picture({"--png", folder_ / "p.png", "--png-at", "0.5"}, folder_ / "p.png"),
                    slow = picture({"--png", folder_ / "q.png", "--png-at", "5", "--speed", "0.1"}, folder_ / "q.png"),
                    late = picture({"--png", folder_ / "l.png", "--png-at", "0.2", "--from", "0.3"}, folder_ / "l.png");
  ASSERT_GT(still.size(), 500u);
  EXPECT_TRUE(fast == still);
  EXPECT_TRUE(slow == still);
  EXPECT_TRUE(late == still);
}

TEST_F(Film, VideosHoldEveryPicture) {
  const Outcome made = make({"--video", folder_ / "v.mp4", "--fps", "25", "--summary", folder_ / "s.json"});
  ASSERT_EQ(made.status, 0) << made.output;
  EXPECT_NE(text_of(folder_ / "s.json").find("\"pictures\": 25"), std::string::npos);
  const Outcome probed = run_program({"ffprobe", "-v", "error", "-count_frames", "-show_entries",
                                      "stream=nb_read_frames,duration", "-of", "csv=p=0", folder_ / "v.mp4"});
  EXPECT_EQ(probed.output, "1.000000,25\n");
}

TEST_F(Film, StillsMayBeLarge) {
  const Outcome made = make({"--png", folder_ / "p.png", "--png-at", "0"}, "4096x2304");
  ASSERT_EQ(made.status, 0) << made.output;
  const osg::ref_ptr<osg::Image> image = osgDB::readRefImageFile(folder_ / "p.png");
  ASSERT_TRUE(image);
  EXPECT_EQ(image->s(), 4096);
  EXPECT_EQ(image->t(), 2304);
}

TEST_F(Film, SaysInOneSentenceWhatCannotBe) {
  write_text(folder_ / "bad.toml", "[[key]]\ntime = 0\n");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--from", "7"}, "--from 7: the recording ends at 1 s"},
      {{"--script", folder_ / "bad.toml"}, "bad.toml:1: key 1"},
      {{"--script", folder_ / "none.toml"}, "none.toml"},
      {{"--speed", "0.01"}, "--speed"},
      {{"--frames", "/no/such/folder/f.png", "--seconds", "0.1"}, "cannot write /no/such/folder/f-0001.png"},
  };
  for (const auto& [more, expected] : cases) {
    const Outcome made = make(more);
    EXPECT_NE(made.status, 0) << made.output;
    EXPECT_NE(made.output.find(expected), std::string::npos) << made.output;
  }
  const Outcome alone = run_program({std::string(PALP_BIN_DIR) + "/palp-viewer", "--headless", "--speed", "2"});
  EXPECT_EQ(alone.status, 2);
  EXPECT_NE(alone.output.find("--replay"), std::string::npos) << alone.output;
}

// One command from a scene to a film: as tools/film is called, but with programs that are built already.
TEST(FilmScript, MakesAFilmAndAStillOfAScene) {
  const ScratchFolder folder;
  const std::string out = folder / "film.mp4";
  const auto film = [&](std::vector<std::string> more) {
    std::vector<std::string> command{"env", "-u", "DISPLAY", std::string("PALP_BIN=") + PALP_BIN_DIR,
                                     std::string(PALP_SOURCE_DIR) + "/tools/film"};
    command.insert(command.end(), more.begin(), more.end());
    return run_program(command, 120s);
  };
  const Outcome made =
      film({"crepe", "--accuracy", "fast", "--seconds", "0.4", "--size", "160x90", "--still", "0.2", "--out", out});
  ASSERT_EQ(made.status, 0) << made.output;
  EXPECT_GT(fs::file_size(out), 1000u);
  EXPECT_EQ(text_of(folder / "film.png").substr(1, 3), "PNG");
  EXPECT_FALSE(fs::exists(folder / "film.log"));
  const std::string still = text_of(folder / "film.png");
  // of the recording alone the same still comes
  const Outcome again = film({"crepe", "--from", folder / "film.mcap", "--seconds", "0.4", "--size", "160x90",
                              "--still", "0.2", "--out", folder / "again.mp4"});
  ASSERT_EQ(again.status, 0) << again.output;
  EXPECT_TRUE(text_of(folder / "again.png") == still);
  EXPECT_FALSE(fs::exists(folder / "again.mcap"));
}

}  // namespace
}  // namespace palp::test
