// The places of the panels of the head-up display. No picture is needed: words are measured without OpenGL.
#include "viewer/hud.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace palp::test {
namespace {

// The widest figures that occur.
HudData full_data() {
  HudData data;
  data.connected = true;
  data.shown_rate_hz = 60;
  data.frame_rate_hz = 60;
  data.frame_age = 0.123;
  data.lost_frames = 12345;
  data.particles = 12'345'678;
  data.sim_time = 1234.56;
  data.real_time_factor = 0.99;
  data.step_time = 0.41e-3;
  data.bridge_rate_hz = 1000;
  data.bridge_late = 0.42e-3;
  data.bridge_data_age = 0.123;
  data.force = 12.34;
  data.arrow_force = 0.5;
  data.arrow_length = 0.353;
  return data;
}

Legend by_body(int bodies) {
  Legend legend;
  for (int i = 0; i < bodies; ++i)
    legend.bodies.emplace_back("body of a long name " + std::to_string(i), std::array{1.0f, 0.0f, 0.0f});
  return legend;
}

Legend by_density() {
  Legend legend;
  legend.field = ScalarField::density;
  legend.range = {1012.25, 1037.75};
  return legend;
}

// A group of the display: its panel is its first child, and holds its words.
osg::BoundingBox panel_of(Hud& hud, unsigned group) {
  const osg::Group* g = hud.camera()->getChild(group)->asGroup();
  return g->getNumChildren() == 0 ? osg::BoundingBox() : g->getChild(0)->asDrawable()->getBoundingBox();
}

void expect_words_inside(Hud& hud, unsigned group, const std::string& where) {
  const osg::BoundingBox panel = panel_of(hud, group);
  const osg::Group* g = hud.camera()->getChild(group)->asGroup();
  for (unsigned i = 1; i < g->getNumChildren(); ++i) {
    const osg::BoundingBox words = g->getChild(i)->asDrawable()->getBoundingBox();
    if (!words.valid()) continue;
    EXPECT_GE(words.xMin(), panel.xMin()) << where;
    EXPECT_LE(words.xMax(), panel.xMax()) << where;
    EXPECT_GE(words.yMin(), panel.yMin()) << where;
    EXPECT_LE(words.yMax(), panel.yMax()) << where;
  }
}

enum Group { kRows, kLegend, kBanner, kHelp };

void expect_sound_layout(int width, int height, const Legend& legend, HudDetail detail) {
  Hud hud;
  hud.set_detail(detail);
  hud.set_size(width, height);
  hud.set_legend(legend);
  HudData data = full_data();
  hud.set_data(data);
  data.paused = true;  // a banner
  hud.set_data(data);
  const std::string where = std::to_string(width) + "x" + std::to_string(height);
  for (const unsigned group : {kRows, kLegend, kBanner}) {
    expect_words_inside(hud, group, where + ", group " + std::to_string(group));
    const osg::BoundingBox panel = panel_of(hud, group);
    EXPECT_GE(panel.xMin(), 0) << where;
    EXPECT_LE(panel.xMax(), width) << where << ", group " << group;
    EXPECT_GE(panel.yMin(), 0) << where;
    EXPECT_LE(panel.yMax(), height) << where << ", group " << group;
  }
  EXPECT_FALSE(panel_of(hud, kRows).intersects(panel_of(hud, kLegend))) << where;
  EXPECT_FALSE(panel_of(hud, kBanner).intersects(panel_of(hud, kLegend))) << where;
  EXPECT_FALSE(panel_of(hud, kBanner).intersects(panel_of(hud, kRows))) << where;
}

TEST(Hud, PanelsHoldTheirWordsAndDoNotMeet) {
  for (const auto& [width, height] : {std::pair{420, 300}, {1280, 720}, {640, 360}, {1920, 1080}, {800, 600}}) {
    for (const Legend& legend : {by_body(3), by_body(30), by_density()}) {
      for (const HudDetail detail : {HudDetail::brief, HudDetail::full})
        expect_sound_layout(width, height, legend, detail);
    }
  }
}

TEST(Hud, KeepsClearOfPanelsAtTheEdges) {
  for (const auto& [width, height] : {std::pair{1280, 720}, {960, 540}}) {
    Hud hud;
    hud.set_size(width, height);
    const float top = 20, right = 24 * hud.font_size();
    hud.set_panels(top, right);
    hud.set_legend(by_density());
    HudData data = full_data();
    data.paused = true;
    hud.set_data(data);
    for (const unsigned group : {kRows, kLegend, kBanner}) {
      const osg::BoundingBox panel = panel_of(hud, group);
      EXPECT_LE(panel.xMax(), width - right) << width << ", group " << group;
      EXPECT_LE(panel.yMax(), height - top) << width << ", group " << group;
    }
    EXPECT_FALSE(panel_of(hud, kRows).intersects(panel_of(hud, kLegend))) << width;
  }
}

TEST(Hud, WordsGrowAndStillFit) {
  for (const float scale : {0.5f, 1.5f, 3.0f}) {
    for (const auto& [width, height] : {std::pair{1280, 720}, {420, 300}}) {
      Hud hud;
      hud.set_size(width, height);
      const float before = hud.font_size();
      hud.set_text_scale(scale);
      hud.set_theme(Theme::light);
      if (width == 1280) {
        EXPECT_TRUE(scale < 1 ? hud.font_size() < before : hud.font_size() > before) << scale;
      }
      hud.set_legend(by_density());
      hud.set_data(full_data());
      for (const unsigned group : {kRows, kLegend}) {
        expect_words_inside(hud, group, std::to_string(scale));
        EXPECT_LE(panel_of(hud, group).xMax(), width) << scale;
        EXPECT_GE(panel_of(hud, group).yMin(), 0) << scale;
      }
      EXPECT_FALSE(panel_of(hud, kRows).intersects(panel_of(hud, kLegend))) << scale << " at " << width;
    }
  }
}

// The panels are measured, not sized for one font.
TEST(Hud, PanelsSuitAnyFont) {
  for (const char* font : {"/usr/share/fonts/truetype/dejavu/DejaVuSansMono-Bold.ttf",
                           "/usr/share/fonts/truetype/dejavu/DejaVuSerif-Bold.ttf", "plain"}) {
    if (std::string(font) != "plain" && !std::filesystem::exists(font)) GTEST_SKIP() << "no " << font;
    setenv("PALP_FONT", font, 1);
    expect_sound_layout(1280, 720, by_body(3), HudDetail::full);
    expect_sound_layout(640, 480, by_density(), HudDetail::brief);
    unsetenv("PALP_FONT");
  }
}

TEST(Hud, HelpFitsThePictureAndStandsAlone) {
  for (const auto& [width, height] : {std::pair{420, 300}, {200, 150}, {1280, 720}}) {
    Hud hud;
    hud.set_size(width, height);
    hud.set_legend(by_body(3));
    hud.set_help(true);
    expect_words_inside(hud, kHelp, std::to_string(width));
    const osg::BoundingBox panel = panel_of(hud, kHelp);
    EXPECT_TRUE(panel.xMin() >= 0 && panel.xMax() <= width && panel.yMin() >= 0 && panel.yMax() <= height) << width;
    for (const unsigned other : {kRows, kLegend, kBanner}) EXPECT_EQ(hud.camera()->getChild(other)->getNodeMask(), 0u);
    hud.set_help(false);
    for (const unsigned other : {kRows, kLegend, kBanner}) EXPECT_NE(hud.camera()->getChild(other)->getNodeMask(), 0u);
  }
}

TEST(Hud, BriefFiguresLeaveThePictureFreeButNoWarningOut) {
  Hud hud;
  hud.set_size(1280, 720);
  HudData data;
  data.connected = true;
  data.frame_age = 0.01;
  hud.set_data(data);
  const auto area = [&] {
    const osg::BoundingBox panel = panel_of(hud, kRows);
    return (panel.xMax() - panel.xMin()) * (panel.yMax() - panel.yMin()) / (1280 * 720);
  };
  const double brief = area();
  EXPECT_LT(brief, 0.03);
  data.frame_age = 0.9;  // old data is a row more
  hud.set_data(data);
  EXPECT_GT(area(), 1.2 * brief);
  hud.show_next_detail();
  EXPECT_GT(area(), 2 * brief);
  hud.show_next_detail();
  EXPECT_EQ(hud.camera()->getNodeMask(), 0u);
  hud.show_next_detail();
  EXPECT_NE(hud.camera()->getNodeMask(), 0u);
}

}  // namespace
}  // namespace palp::test
