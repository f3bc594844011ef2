// Tests which measured points a scene may be given, and what they mean for a scene that was not measured.
#include "sim_server/trade/scene_curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "sim_server/trade/scene_medium.h"
#include "tests/support/files.h"

namespace palp::test::scene_curve_test {
namespace {

const std::string kScenes = PALP_SOURCE_DIR "/config/scenes/";

TradeTable synthetic() { return read_trade_table(PALP_SOURCE_DIR "/tests/sim_server/trade/synthetic.json"); }

std::string refusal(const std::string& scene, const SceneOverrides& overrides = {}) {
  try {
    curve_of(synthetic(), scene, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

// tray_fluid with some text replaced, in a file of another name.
class OtherScene {
 public:
  OtherScene(const std::string& from, const std::string& to, const std::string& name = "other.toml") {
    std::string text = text_of(kScenes + "tray_fluid.toml");
    const std::size_t place = text.find(from);
    EXPECT_NE(place, std::string::npos);
    text.replace(place, from.size(), to);
    file_ = folder_ / name;
    write_text(file_, text);
  }
  const std::string& file() const { return file_; }

 private:
  ScratchFolder folder_;
  std::string file_;
};

TEST(SceneMedium, IsWhatTheHandFeels) {
  const std::pair<const char*, const char*> rows[] = {
      {"tray_fluid", "fluid"}, {"tray_elastic", "elastic"}, {"tray_rigid", "rigid"},    {"kitchen", "mixed"},
      {"butter", "changing"},  {"mixed", "changing"},       {"cuboid_static", "rigid"}, {"dam_break", "fluid"}};
  for (const auto& [scene, medium] : rows) EXPECT_EQ(medium_of(load_scene(kScenes + scene + ".toml")), medium) << scene;
}

TEST(SceneMedium, TheToolSaysWhatMustBeResolved) {
  EXPECT_NEAR(resolved_length(load_scene(kScenes + "tray_fluid.toml")), 0.1, 1e-9) << "the ladle's ball";
  EXPECT_GT(resolved_length(load_scene(kScenes + "tray_fluid.toml"), true), 0.2) << "the fluid";
  EXPECT_GT(resolved_length(load_scene(kScenes + "dam_break.toml")), 0) << "a scene without a tool";
}

TEST(SceneCurve, OfAMeasuredSceneIsAsItWasMeasured) {
  const SceneCurve curve = curve_of(synthetic(), kScenes + "tray_fluid.toml", {});
  EXPECT_TRUE(curve.own);
  EXPECT_EQ(curve.uncertainty, 0.02);
  ASSERT_EQ(curve.points.size(), 2u) << "method paper is not what the scene asks for";
  EXPECT_EQ(curve.points[0].spacing, 0.08) << "coarser than the scene's levels, but measured";
  EXPECT_EQ(curve.points[1].settings.size(), 2u);
}

TEST(SceneCurve, WhatTheCommandLineSetsIsKept) {
  SceneOverrides overrides;
  overrides.method = Method::paper;
  EXPECT_EQ(curve_of(synthetic(), kScenes + "tray_fluid.toml", overrides).points.size(), 1u);
  overrides = {};
  overrides.settings = {"numerics.support_over_spacing=3.0"};
  EXPECT_EQ(curve_of(synthetic(), kScenes + "tray_fluid.toml", overrides).points.size(), 2u);
  overrides.settings = {"numerics.support_over_spacing=2"};
  EXPECT_NE(refusal(kScenes + "tray_fluid.toml", overrides).find("no point of 'tray_fluid' has the method, rate and"),
            std::string::npos);
  for (const char* setting : {"numerics.spacing=0.02", "scene.accuracy=fast"}) {
    overrides.settings = {setting};
    EXPECT_NE(refusal(kScenes + "tray_fluid.toml", overrides).find("chooses that: leave out"), std::string::npos);
  }
}

TEST(SceneCurve, OfAnotherSceneFollowsTheLengthOfItsTool) {
  // a ball of a quarter of the diameter needs particles of a quarter of the spacing
  const OtherScene small("radius = 0.05", "radius = 0.0125");
  const SceneCurve curve = curve_of(synthetic(), small.file(), {});
  EXPECT_FALSE(curve.own);
  EXPECT_EQ(curve.measured_with, "tray_fluid");
  const double ratio = resolved_length(load_scene(small.file())) / 0.1;
  ASSERT_LT(ratio, 0.6);
  bool found = false;
  for (const TradePoint& point : curve.points) {
    EXPECT_LE(point.spacing, 0.04 * (1 + 1e-9)) << "no coarser than the scene's walls allow";
    if (point.error != 0.1) continue;
    found = true;
    EXPECT_NEAR(point.spacing, 0.04 * ratio, 1e-9);
  }
  EXPECT_TRUE(found);
}

TEST(SceneCurve, ALargerToolErrsLessAtTheSameSpacing) {
  const OtherScene large("radius = 0.05", "radius = 0.075");
  const SceneCurve curve = curve_of(synthetic(), large.file(), {});
  ASSERT_EQ(curve.points.size(), 1u) << "all measured points mean coarser particles than the scene's walls allow";
  EXPECT_EQ(curve.points[0].spacing, 0.03) << "the scene's own at its coarsest level";
  EXPECT_EQ(curve.points[0].error, 0.1) << "no better than the best that was measured";
}

TEST(SceneCurve, AnotherSceneOfTheSameNameIsAnother) {
  const OtherScene same("viscosity = 0.05", "viscosity = 0.06", "tray_fluid.toml");
  EXPECT_FALSE(curve_of(synthetic(), same.file(), {}).own);
}

TEST(SceneCurve, WhatAnotherScenesFileStatesIsKept) {
  const OtherScene stated("support_over_spacing = {fast = 2.8}", "support_over_spacing = 2");
  for (const TradePoint& point : curve_of(synthetic(), stated.file(), {}).points)
    EXPECT_EQ(point.settings, std::vector<std::string>{"numerics.artificial_viscosity=0.02"});
}

TEST(SceneCurve, ASceneWithoutACurveIsToldWhatThereIs) {
  const std::string said = refusal(kScenes + "butter.toml");
  EXPECT_NE(said.find("synthetic.json: no curve for a scene whose medium is changing"), std::string::npos) << said;
  EXPECT_NE(said.find("there are curves for fluid, elastic"), std::string::npos) << said;
  EXPECT_EQ(said.find('\n'), std::string::npos);
  EXPECT_NE(refusal(kScenes + "taylor_green.toml").find("are read from a file"), std::string::npos);
}

}  // namespace
}  // namespace palp::test::scene_curve_test
