// The parts of the viewer that need no picture: colours, texts, surfaces, scales, keys and options.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/viewer/synthetic_scene.h"
#include "viewer/color_map.h"
#include "viewer/controls.h"
#include "viewer/force_arrow.h"
#include "viewer/hud_text.h"
#include "viewer/mesh.h"
#include "viewer/options.h"

namespace palp::test {
namespace {

TEST(ColorMap, LightnessOfTheSequentialMapRisesEvenly) {
  const auto map = color_map(ColorMapKind::sequential);
  const double first = lightness(map.front()), last = lightness(map.back());
  EXPECT_GT(last - first, 0.5);
  for (int i = 0; i < kColorMapSize; ++i) {
    const double even = first + (last - first) * i / (kColorMapSize - 1);
    EXPECT_NEAR(lightness(map[static_cast<std::size_t>(i)]), even, 0.02) << "entry " << i;
  }
}

TEST(ColorMap, TheDivergingMapIsLightInTheMiddleAndEvenToBothSides) {
  const auto map = color_map(ColorMapKind::diverging);
  for (std::size_t i = 0; i < kColorMapSize / 2; ++i) {
    EXPECT_NEAR(lightness(map[i]), lightness(map[kColorMapSize - 1 - i]), 0.02);
    EXPECT_LE(lightness(map[i]), lightness(map[i + 1]) + 0.004);
  }
  EXPECT_GT(map.front().b, map.front().r + 80);
  EXPECT_GT(map.back().r, map.back().b + 80);
}

TEST(ColorMap, RangesEndAtRoundNumbersAndHoldTheValues) {
  EXPECT_DOUBLE_EQ(nice_ceiling(0.3), 0.5);
  EXPECT_DOUBLE_EQ(nice_ceiling(1), 1);
  EXPECT_DOUBLE_EQ(nice_ceiling(5.1), 10);
  const std::vector<float> speeds{0.1f, 0.2f, 0.31f};
  EXPECT_EQ(suitable_range(ScalarField::speed, speeds, 0), (ValueRange{0, 0.5}));
  const std::vector<float> densities{997, 1001, 1004};
  EXPECT_EQ(suitable_range(ScalarField::density, densities, 1000), (ValueRange{995, 1005}));
  const std::vector<float> pressures{-120, 15, 430};
  const ValueRange range = suitable_range(ScalarField::pressure, pressures, 0);
  EXPECT_EQ(range, (ValueRange{-200, 600}));
  const std::vector<float> bad{std::nanf(""), INFINITY};
  const ValueRange none = suitable_range(ScalarField::speed, bad, 0);
  EXPECT_LT(none.low, none.high);
  EXPECT_LT(suitable_range(ScalarField::pressure, std::vector<float>(5, 7.0f), 0).low, 7.1);
}

TEST(ColorMap, ARangeStaysUntilItNoLongerFits) {
  SteadyRange steady;
  EXPECT_EQ(steady.update(ScalarField::speed, {0, 1}), (ValueRange{0, 1}));
  EXPECT_EQ(steady.update(ScalarField::speed, {0, 0.5}), (ValueRange{0, 1}));
  EXPECT_EQ(steady.update(ScalarField::speed, {0, 2}), (ValueRange{0, 2}));
  EXPECT_EQ(steady.update(ScalarField::speed, {0, 0.5}), (ValueRange{0, 0.5}));
  EXPECT_EQ(steady.update(ScalarField::density, {990, 1010}), (ValueRange{990, 1010}));
}

TEST(ForceScale, GrowsAtOnceAndFallsSlowly) {
  ForceScale scale;
  EXPECT_DOUBLE_EQ(scale.update(0.4, 0), 1);
  EXPECT_DOUBLE_EQ(scale.update(3, 0.001), 5);
  EXPECT_DOUBLE_EQ(scale.update(0, 1), 5);
  EXPECT_LT(scale.update(0, 30), 5);
  EXPECT_DOUBLE_EQ(scale.update(9, 0), 10) << "time runs backwards at a reset";
}

TEST(Mesh, AHollowFixedBodyIsSplitIntoInsideAndGlass) {
  const BodyMesh mesh = build_mesh(tray());
  ASSERT_TRUE(mesh.solid && mesh.glass && mesh.edges);
  EXPECT_EQ(mesh.solid->getVertexArray()->getNumElements(), 5u * 6);  // floor and four inner walls
  EXPECT_EQ(mesh.glass->getVertexArray()->getNumElements(), 9u * 6);  // five outer sides, four of the rim
}

TEST(Mesh, RigidAndFullBodiesAreSolid) {
  EXPECT_FALSE(build_mesh(paddle()).glass);
  BodyDescription block;
  block.kind = BodyKind::fixed;
  add_box(block, {0, 0, 0}, {1, 1, 1}, true, true);
  const BodyMesh mesh = build_mesh(block);
  EXPECT_TRUE(mesh.solid && !mesh.glass && !mesh.edges);
}

TEST(Mesh, NormalsAreSmoothOnCurvesAndFlatAtCreases) {
  BodyDescription ball;  // of latitude and longitude
  constexpr int kRows = 16, kColumns = 32;
  const auto point = [](int row, int column) {
    const double a = std::numbers::pi * row / kRows, b = 2 * std::numbers::pi * (column % kColumns) / kColumns;
    return std::array<double, 3>{std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)};
  };
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      add_quad(ball, {point(r, c), point(r + 1, c), point(r + 1, c + 1), point(r, c + 1)});
    }
  }
  const BodyMesh mesh = build_mesh(ball);
  const auto& vertices = static_cast<const osg::Vec3Array&>(*mesh.solid->getVertexArray());
  const auto& normals = static_cast<const osg::Vec3Array&>(*mesh.solid->getNormalArray());
  for (std::size_t i = 0; i < vertices.size(); ++i) EXPECT_GT(vertices[i] * normals[i], 0.99f);

  BodyDescription block;
  add_box(block, {-1, -1, -1}, {1, 1, 1}, true, true);
  const BodyMesh cube = build_mesh(block);
  for (const osg::Vec3f& n : static_cast<const osg::Vec3Array&>(*cube.solid->getNormalArray())) {
    EXPECT_NEAR(std::max({std::abs(n.x()), std::abs(n.y()), std::abs(n.z())}), 1, 1e-5);
  }
}

TEST(HudText, UnknownFiguresAreDashesAndBadOnesWarn) {
  HudData data;
  EXPECT_EQ(hud_banner(data), "waiting for sim_server");
  for (const HudRow& row : hud_rows(data)) EXPECT_FALSE(row.warn) << row.label;
  data.connected = true;
  data.frame_age = 0.6;
  data.real_time_factor = 0.5;
  data.bridge_late = 2e-3;
  int warned = 0;
  for (const HudRow& row : hud_rows(data)) warned += row.warn;
  EXPECT_EQ(warned, 3);
  data.paused = true;
  EXPECT_EQ(hud_banner(data), "paused");
  data.server_state = "fault";
  data.server_text = "speed grew past the sound speed";
  EXPECT_EQ(hud_banner(data), "sim_server stopped: speed grew past the sound speed");
}

TEST(HudText, TimesHaveTheUnitThatSuits) {
  EXPECT_EQ(format_time(42e-6), "42 us");
  EXPECT_EQ(format_time(0.42e-3), "0.42 ms");
  EXPECT_EQ(format_time(0.123), "123 ms");
  EXPECT_EQ(format_time(1.26), "1.3 s");
}

TEST(HudText, TheWorstBridgeIsShown) {
  std::map<std::string, Status> status;
  status["haptic_bridge 0"].metrics = {{"rate_hz", 1000}, {"lateness_p99_us", 20}, {"sample_age_p50_ms", 3}};
  status["haptic_bridge 1"].metrics = {{"lateness_p99_us", 700}};
  status["sim_server"].metrics = {{"step_p50_us", 410}, {"real_time_factor", 0.99}};
  HudData data;
  read_status(status, data);
  EXPECT_DOUBLE_EQ(data.bridge_late.value(), 700e-6);
  EXPECT_DOUBLE_EQ(data.bridge_data_age.value(), 3e-3);
  EXPECT_DOUBLE_EQ(data.bridge_rate_hz.value(), 1000);
  EXPECT_DOUBLE_EQ(data.step_time.value(), 410e-6);
  EXPECT_DOUBLE_EQ(data.real_time_factor.value(), 0.99);
}

TEST(Keys, CapitalAndSmallLettersDiffer) {
  EXPECT_EQ(action_of('r'), Action::home);
  EXPECT_EQ(action_of('R'), Action::reset);
  EXPECT_EQ(action_of(' '), Action::pause_or_resume);
  EXPECT_FALSE(action_of('q'));
}

std::optional<ViewerOptions> parse(std::vector<const char*> arguments, int& code) {
  arguments.insert(arguments.begin(), "palp-viewer");
  testing::internal::CaptureStderr();
  auto options = parse_viewer_options(static_cast<int>(arguments.size()), arguments.data(), code);
  testing::internal::GetCapturedStderr();
  return options;
}

TEST(Options, OffScreenIsModestUnlessTold) {
  int code = 0;
  const auto plain = parse({"--headless"}, code);
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->nice, 10);
  EXPECT_EQ(plain->stage.samples, 0);
  EXPECT_DOUBLE_EQ(plain->rate_hz, 5);
  EXPECT_FALSE(plain->color);
  const auto told =
      parse({"--headless", "--video", "v.mp4", "--nice", "0", "--size", "320x200", "--color", "body"}, code);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->nice, 0);
  EXPECT_DOUBLE_EQ(told->rate_hz, 30);
  EXPECT_EQ(told->stage.width, 320);
  EXPECT_EQ(told->color, ScalarField::none);
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
