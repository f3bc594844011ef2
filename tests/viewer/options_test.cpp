// The command line of the viewer.
#include "viewer/options.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <vector>

namespace palp::test {
namespace {

std::optional<ViewerOptions> parse(std::vector<const char*> arguments, int& code) {
  arguments.insert(arguments.begin(), "palp-viewer");
  testing::internal::CaptureStderr();
  const auto parsed = parse_viewer_options(static_cast<int>(arguments.size()), arguments.data());
  testing::internal::GetCapturedStderr();
  code = parsed.exit_status;
  return parsed.options;
}

TEST(Options, OffScreenIsModestUnlessTold) {
  int code = 0;
  const auto plain = parse({"--headless"}, code);
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->nice, 10);
  EXPECT_EQ(plain->stage.samples, 0);
  EXPECT_DOUBLE_EQ(plain->rate_hz, 5);
  EXPECT_EQ(plain->color, ScalarField::none);
  const auto told =
      parse({"--headless", "--video", "v.mp4", "--nice", "0", "--size", "320x200", "--color", "speed"}, code);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->nice, 0);
  EXPECT_DOUBLE_EQ(told->rate_hz, 30);
  EXPECT_EQ(told->stage.width, 320);
  EXPECT_EQ(told->color, ScalarField::speed);
}

TEST(Options, OffScreenReadsNoSettingsButThoseNamedAndWritesNone) {
  int code = 0;
  EXPECT_EQ(parse({"--headless"}, code)->settings, "");
  const auto named = parse({"--headless", "--settings", "s.toml"}, code);
  EXPECT_EQ(named->settings, "s.toml");
  EXPECT_FALSE(named->writes_settings);
  setenv("DISPLAY", ":9", 0);
  const auto window = parse({"--panels"}, code);
  EXPECT_TRUE(window->settings.ends_with("palp/viewer.toml")) << window->settings;
  EXPECT_TRUE(window->writes_settings && window->panels);
  EXPECT_EQ(parse({"--no-settings"}, code)->settings, "");
  EXPECT_FALSE(parse({"--no-settings", "--settings", "s.toml"}, code));
}

TEST(Options, SeveralWindowsNeedADisplayAndNoFilm) {
  int code = 0;
  setenv("DISPLAY", ":9", 0);
  EXPECT_EQ(parse({}, code)->windows, 1);
  EXPECT_EQ(parse({"--windows", "3"}, code)->windows, 3);
  EXPECT_EQ(parse({"--windows", "3", "--replay", "r.mcap"}, code)->windows, 3);
  const std::vector<std::vector<const char*>> bad{{"--windows", "0"},
                                                  {"--windows", "10"},
                                                  {"--windows", "2", "--headless"},
                                                  {"--windows", "2", "--bench", "1000"},
                                                  {"--windows", "2", "--replay", "r.mcap", "--video", "v.mp4"}};
  for (const auto& arguments : bad) {
    EXPECT_FALSE(parse(arguments, code)) << arguments[1];
    EXPECT_EQ(code, 2) << arguments[1];
  }
}

TEST(Options, SenselessOnesAreRefused) {
  const std::vector<std::vector<const char*>> bad{{"--size", "12"},        {"--size", "10x10"}, {"--size", "99999x2"},
                                                  {"--size", "640x480x2"}, {"--fps", "-3"},     {"--color", "smell"},
                                                  {"--png-at", "3"},       {"--domain", "999"}, {"--nonsense"}};
  for (const auto& arguments : bad) {
    int code = 0;
    EXPECT_FALSE(parse(arguments, code)) << arguments[0];
    EXPECT_NE(code, 0) << arguments[0];
  }
}

}  // namespace
}  // namespace palp::test
