// The file of settings: what is written is read back, and whatever else stands there does no harm.
#include "viewer/settings.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <random>

#include "config/error.h"
#include "tests/support/files.h"
#include "tests/support/seed.h"

namespace palp::test::settings_test {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

ViewerSettings full() {
  ViewerSettings s;
  s.map = ColorMapKind::cividis;
  s.held[1] = ValueRange{0, 0.1};
  s.held[3] = ValueRange{-1e5, 2.5e5};
  s.theme = Theme::light;
  s.panels = PanelDetail::all;
  s.reading = false;
  s.bill = true;
  s.touch = true;
  s.text_scale = 1.3;
  s.store_view("tray \"fluid\" \\ µ\n", 3, {{1, 2, 3}, {0.1, 0.2, 0.3}, {0, 0, 1}});
  s.store_view("other", 9, {{1, -2, 3}, {0, 0, 0}, {0, 0, 1}});
  return s;
}

TEST(Settings, AreReadBackAsTheyWereWritten) {
  EXPECT_EQ(parse_settings(settings_text(full()), "f"), full());
  EXPECT_EQ(parse_settings(settings_text({}), "f"), ViewerSettings());
  EXPECT_EQ(parse_settings("", "f"), ViewerSettings());
}

TEST(Settings, ViewsAreOfTheirSceneAndNumber) {
  ViewerSettings s = full();
  EXPECT_EQ(s.view_of("tray \"fluid\" \\ µ\n", 3)->eye, osg::Vec3d(1, 2, 3));
  EXPECT_FALSE(s.view_of("other", 3));
  s.store_view("other", 9, {{7, 0, 0}, {0, 0, 0}, {0, 0, 1}});
  EXPECT_EQ(s.view_of("other", 9)->eye, osg::Vec3d(7, 0, 0));
  EXPECT_EQ(s.views.size(), 2u);
}

TEST(Settings, FaultsNameFileAndLine) {
  const std::pair<const char*, const char*> bad[] = {
      {"color_map = \"rainbow\"", "f:1"},
      {"\ntext_scale = 40", "f:2"},
      {"colour = 1", "unknown key"},
      {"[range]\nspeed = [2, 1]", "the range of speed ends at 1, expected more than 2"},
      {"[range]\nspeed = [nan, 1]", "f:2"},
      {"[[view]]\nscene = \"a\"\nnumber = 1\neye = [0,0,0]\ncenter = [0,0,0]\nup = [0,0,1]", "no direction"},
      {"[[view]]\nscene = \"a\"\nnumber = 10\neye = [0,1,0]\ncenter = [0,0,0]\nup = [0,0,1]", "f:3"},
      {"theme = ", "f:1"}};
  for (const auto& [text, expected] : bad) {
    try {
      parse_settings(text, "f");
      ADD_FAILURE() << text << " was accepted";
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    }
  }
}

TEST(Settings, RandomBytesAreRefusedOrRead) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("PALP_SEED=" + std::to_string(seed));
  std::mt19937 random(seed);
  const std::string sound = settings_text(full());
  for (int i = 0; i < 3000; ++i) {
    std::string text = i % 2 == 0 ? sound : std::string(random() % 200, ' ');
    const std::size_t spoilt = i % 2 == 0 ? 1 + random() % 4 : text.size();
    for (std::size_t k = 0; k < spoilt; ++k) {
      const std::size_t at = i % 2 == 0 ? random() % text.size() : k;
      text[at] = static_cast<char>(random());
    }
    try {
      const ViewerSettings s = parse_settings(text, "f");
      EXPECT_TRUE(s.text_scale >= kSmallestTextScale && s.text_scale <= kLargestTextScale);
      for (const SceneView& v : s.views) EXPECT_TRUE(v.view.eye.valid() && v.number >= 1 && v.number <= kMostViews);
    } catch (const ConfigError&) {
    }
  }
}

TEST(SettingsFile, KeepsChangesOnceTheyHaveSettled) {
  const ScratchFolder folder;
  const std::string path = folder / "palp/viewer.toml";
  SettingsFile file(path, true);
  EXPECT_EQ(file.settings(), ViewerSettings());
  file.keep(ViewerSettings(), 0);
  EXPECT_FALSE(std::filesystem::exists(path)) << "nothing was changed";
  file.keep(full(), 10 * kSecond);
  file.keep(full(), 11 * kSecond);
  EXPECT_FALSE(std::filesystem::exists(path)) << "more changes may follow";
  file.keep(full(), 13 * kSecond);
  EXPECT_EQ(SettingsFile(path, true).settings(), full());
  file.keep(ViewerSettings(), 14 * kSecond, true);
  EXPECT_EQ(SettingsFile(path, true).settings(), ViewerSettings());
  for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "palp"))
    EXPECT_EQ(entry.path().filename(), "viewer.toml");
}

TEST(SettingsFile, ABrokenFileIsToldOfAndLeftAsItIs) {
  const ScratchFolder folder;
  const std::string path = folder / "viewer.toml";
  write_text(path, "theme = \"light\"\ntext_scale = \"huge\"\n");
  SettingsFile file(path, true);
  EXPECT_EQ(file.settings(), ViewerSettings());
  file.keep(full(), kSecond, true);
  EXPECT_EQ(text_of(path), "theme = \"light\"\ntext_scale = \"huge\"\n");
}

TEST(SettingsFile, IsNotWrittenWhereThatWasNotAsked) {
  const ScratchFolder folder;
  const std::string path = folder / "viewer.toml";
  write_text(path, settings_text({}));
  SettingsFile file(path, false);
  file.keep(full(), kSecond, true);
  EXPECT_EQ(text_of(path), settings_text({}));
  SettingsFile(folder / "viewer.toml/below", true).keep(full(), kSecond, true);  // cannot be written: no harm
  SettingsFile("", true).keep(full(), kSecond, true);
}

TEST(SettingsFile, LiesInTheUsersFolderOfConfiguration) {
  const char* before = std::getenv("XDG_CONFIG_HOME");
  const std::string kept = before != nullptr ? before : "";
  setenv("XDG_CONFIG_HOME", "/somewhere", 1);
  EXPECT_EQ(settings_path(), "/somewhere/palp/viewer.toml");
  setenv("XDG_CONFIG_HOME", "relative", 1);
  EXPECT_EQ(settings_path().find("relative"), std::string::npos);
  before != nullptr ? setenv("XDG_CONFIG_HOME", kept.c_str(), 1) : unsetenv("XDG_CONFIG_HOME");
}

}  // namespace
}  // namespace palp::test::settings_test
