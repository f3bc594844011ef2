// Pictures of liquids and soft bodies as smooth surfaces: what must be seen is computed here, not compared with a
// stored picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/viewer/block_scene.h"
#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/stage.h"

namespace palp::test::medium_image_test {
namespace {

// A tray of still liquid without its paddle, seen from above the rim.
SyntheticScene still_tray(const char* name) {
  SyntheticScene s = synthetic_scene();
  make_look(s.scene.bodies[0], name);
  s.scene.bodies.pop_back();
  s.poses = {};
  std::size_t kept = 0;
  for (std::size_t i = 0; i + 2 < s.frame.positions.size(); i += 3) {
    if (s.frame.positions[i + 2] > kDepth) continue;
    for (std::size_t k = 0; k < 3; ++k) s.frame.positions[kept + k] = s.frame.positions[i + k];
    kept += 3;
  }
  s.frame.positions.resize(kept);
  s.frame.scalars.assign(kept / 3, 0.2f);
  return s;
}

// How much brightness changes from pixel to pixel in the middle of the liquid's surface.
double roughness(Stage& stage, const Picture& picture) {
  const osg::Vec2d a = stage.project({-0.06, 0.02, kDepth}), b = stage.project({0.06, 0.02, kDepth});
  double sum = 0;
  int count = 0;
  for (int line = -8; line <= 8; ++line) {
    for (int x = static_cast<int>(a.x()); x < static_cast<int>(b.x()); ++x) {
      const int y = static_cast<int>(a.y() + (b.y() - a.y()) * (x - a.x()) / (b.x() - a.x())) + line;
      sum += std::abs(at(picture, x + 1, y).g - at(picture, x, y).g);
      ++count;
    }
  }
  return sum / count;
}

TEST(MediumImage, ALiquidIsOneSmoothSurface) {
  for (const char* name : {"water", "batter"}) {
    Stage stage(small_stage(640, 480));
    put_on(stage, still_tray(name));
    const double smooth = roughness(stage, shoot(stage));
    stage.scene().set_beads(true);
    stage.scene().set_frame(still_tray(name).frame);
    const double beads = roughness(stage, shoot(stage));
    EXPECT_GT(beads, 4) << name << ": beads have a bright and a dark side";
    EXPECT_LT(smooth, 0.25 * beads) << name;
  }
}

// How far the upper outline of what is bright is from a straight line between two places [pixels, root mean square].
double waviness(const Picture& picture, const osg::Vec2d& a, const osg::Vec2d& b) {
  std::vector<osg::Vec2d> outline;
  for (int x = static_cast<int>(std::min(a.x(), b.x())); x < static_cast<int>(std::max(a.x(), b.x())); ++x) {
    int y = picture.height - 1;
    while (y > 0 && at(picture, x, y).g < 90) --y;
    outline.emplace_back(x, y);
  }
  return off_line(outline);
}

// The same of the border between bluish and yellowish, from above, within 20 pixels of the line.
double border(const Picture& picture, const osg::Vec2d& a, const osg::Vec2d& b) {
  std::vector<osg::Vec2d> outline;
  for (int x = static_cast<int>(std::min(a.x(), b.x())); x < static_cast<int>(std::max(a.x(), b.x())); ++x) {
    int y = static_cast<int>(a.y() + (b.y() - a.y()) * (x - a.x()) / (b.x() - a.x())) + 20;
    while (y > 0 && at(picture, x, y).b <= at(picture, x, y).r) --y;
    outline.emplace_back(x, y);
  }
  return off_line(outline);
}

TEST(MediumImage, AnOutlineIsALineAndNotARowOfBeads) {
  const SyntheticScene s = block("batter");
  for (const Surfaces quality : {Surfaces::quick, Surfaces::fine}) {
    StageOptions options = small_stage(640, 480);
    options.surfaces = quality;
    Stage stage(options);
    put_on(stage, s);
    const Picture surface = shoot(stage);
    // the far upper edge, but for its ends
    const osg::Vec2d a = stage.project({2 * kSpacing, 9.5 * kSpacing, 5.5 * kSpacing});
    const osg::Vec2d b = stage.project({11 * kSpacing, 9.5 * kSpacing, 5.5 * kSpacing});
    const double smooth = waviness(surface, a, b);
    stage.scene().set_beads(true);
    stage.scene().set_frame(s.frame);
    const double beads = waviness(shoot(stage), a, b);
    EXPECT_GT(beads, 1.5) << "pixels";
    EXPECT_LT(smooth, 0.6) << "pixels; rounding alone is 0.3";
  }
}

// A wave's crest hides a part of the trough behind it: their border is a row of beads, too, in the picture of spheres.
TEST(MediumImage, ACrestBeforeItsOwnLiquidIsALine) {
  SyntheticScene s = block("batter", {14, 60, 8});
  // a wall of liquid in front, the pool behind it half as high
  std::size_t kept = 0;
  for (std::size_t i = 0; i < s.frame.positions.size(); i += 3) {
    if (s.frame.positions[i + 1] > 3.0 * kSpacing && s.frame.positions[i + 2] > 3.6 * kSpacing) continue;
    std::copy_n(s.frame.positions.begin() + static_cast<std::ptrdiff_t>(i), 3,
                s.frame.positions.begin() + static_cast<std::ptrdiff_t>(kept));
    kept += 3;
  }
  std::fill(s.frame.positions.begin() + static_cast<std::ptrdiff_t>(kept), s.frame.positions.end(),
            std::numeric_limits<float>::quiet_NaN());
  // their colours tell them apart
  s.frame.field = ScalarField::speed;
  for (std::size_t i = 0; i < kept / 3; ++i) s.frame.scalars[i] = s.frame.positions[3 * i + 1] > 3 * kSpacing ? 1 : 0;
  for (const Surfaces quality : {Surfaces::quick, Surfaces::fine}) {
    StageOptions options = small_stage(640, 480);
    options.surfaces = quality;
    Stage stage(options);
    put_on(stage, s, ScalarField::speed);
    const Picture surface = shoot(stage);
    const osg::Vec2d a = stage.project({7 * kSpacing, 3 * kSpacing, 7.5 * kSpacing});
    const osg::Vec2d b = stage.project({12 * kSpacing, 3 * kSpacing, 7.5 * kSpacing});
    const double smooth = border(surface, a, b);
    stage.scene().set_beads(true);
    stage.scene().set_frame(s.frame);
    const double beads = border(shoot(stage), a, b);
    EXPECT_GT(beads, 1.5) << "pixels";
    EXPECT_LT(smooth, 0.9) << "pixels; the border has steps of a texel, and rounding alone is 0.3";
  }
}

TEST(MediumImage, WhatLiesInAClearLiquidIsSeenAndInAnOpaqueOneNot) {
  for (const char* name : {"water", "batter"}) {
    Picture pictures[2];
    osg::Vec2d place;
    for (const bool with : {false, true}) {
      Stage stage(small_stage());
      SyntheticScene s = still_tray(name);
      BodyDescription ball;
      ball.kind = BodyKind::fixed;
      ball.name = "brick";
      ball.color = {1, 0, 0};
      add_box(ball, {-0.04, -0.03, 0.02}, {0.04, 0.03, 0.042}, true, true);
      if (with) s.scene.bodies.push_back(ball);
      put_on(stage, s);
      pictures[with] = shoot(stage);
      place = stage.project({0, 0, kDepth});
    }
    const Pixel before = at(pictures[0], place), after = at(pictures[1], place);
    if (std::string(name) == "water") {
      EXPECT_GT(after.r, before.r + 30);
    } else {
      EXPECT_LE(std::abs(after.r - before.r), 2) << "rounding alone";
    }
  }
}

TEST(MediumImage, WhatStandsBeforeALiquidHidesIt) {
  Stage stage(small_stage());
  SyntheticScene s = still_tray("water");
  BodyDescription screen;
  screen.kind = BodyKind::fixed;
  screen.name = "screen";
  screen.color = {1, 0, 0};
  add_box(screen, {-0.2, -0.16, -0.02}, {0.2, -0.15, 0.2}, true, true);
  s.scene.bodies.push_back(screen);
  put_on(stage, s);
  const Picture picture = shoot(stage);
  EXPECT_TRUE(reddish(at(picture, stage.project({0, -0.16, 0.02}))));
}

TEST(MediumImage, ColorsThatStandForNumbersAreNotLookedThrough) {
  Stage stage(small_stage());
  SyntheticScene s = still_tray("water");
  std::fill(s.frame.scalars.begin(), s.frame.scalars.end(), 0.0f);
  s.frame.scalars[0] = s.frame.scalars[1] = 1;
  s.frame.field = ScalarField::speed;
  BodyDescription brick;
  brick.kind = BodyKind::fixed;
  brick.name = "brick";
  brick.color = {1, 0, 0};
  add_box(brick, {-0.04, -0.03, 0.02}, {0.04, 0.03, 0.042}, true, true);
  s.scene.bodies.push_back(brick);
  put_on(stage, s, ScalarField::speed);
  const Pixel p = at(shoot(stage), stage.project({0, 0, kDepth}));
  EXPECT_GT(p.b, 2 * p.r) << "the low end of the map is blue";
}

TEST(MediumImage, SenselessParticlesLeaveTheOthersAsTheyAre) {
  const float nan = std::nanf(""), infinity = std::numeric_limits<float>::infinity();
  const std::vector<float> senseless{nan, infinity, -infinity, 3e38f, -2e9f};
  for (const ScalarField field : {ScalarField::none, ScalarField::speed}) {
    Picture pictures[2];
    for (const bool bad : {false, true}) {
      Stage stage(small_stage());
      SyntheticScene s = still_tray("water");
      s.frame.field = ScalarField::speed;
      for (std::size_t i = 0; i < s.frame.positions.size(); i += 30) {
        s.frame.positions[i + i % 3] = bad ? senseless[i / 30 % senseless.size()] : 1e6f;
        s.frame.scalars[i / 3 + 1] = bad ? nan : -3.1e38f;
      }
      put_on(stage, s, field);
      pictures[bad] = shoot(stage);
    }
    EXPECT_EQ(differing(pictures[0], pictures[1]), 0);
  }
}

// A picture of a block as one body, of which most particles hide others, or as many of the same look that are too small
// for that.
Picture block_of(bool pieces, const char* name, bool beads) {
  constexpr std::uint32_t kPiece = 100;
  SyntheticScene s = block(name, {20, 16, 14}, 0.3);
  const std::uint32_t count = s.scene.particle_count;
  BodyDescription body = s.scene.bodies[0];
  s.scene.bodies.clear();
  for (body.first = 0; body.first < count; body.first += body.count) {
    body.count = pieces ? std::min(kPiece, count - body.first) : count;
    s.scene.bodies.push_back(body);
  }
  Stage stage(small_stage(640, 480));
  stage.scene().set_beads(beads);
  put_on(stage, s);
  const ParticleCloud& cloud = stage.scene().cloud();
  EXPECT_EQ(cloud.drawn(), count);
  EXPECT_EQ(cloud.seen() == count, pieces);
  return shoot(stage);
}

// However many bodies can change, each keeps the look that it has at first.
TEST(MediumImage, ManyBodiesThatCanChangeKeepTheirLooks) {
  SyntheticScene s = block("batter", {20, 16, 14}, 0.3);
  BodyDescription body = s.scene.bodies[0];
  const std::uint32_t count = body.count / 20;
  Picture pictures[2];
  for (const bool can_change : {false, true}) {
    s.scene.bodies.clear();
    for (std::uint32_t k = 0; k < 20; ++k) {
      body.first = k * count;
      body.count = count;
      body.look.roughness = 0.2f + 0.03f * static_cast<float>(k);
      body.changed_look = body.look;
      body.changed_color = body.color;
      if (can_change) body.changed_look.roughness = 0.01f * static_cast<float>(k);
      s.scene.bodies.push_back(body);
    }
    Stage stage(small_stage());
    put_on(stage, s);
    pictures[can_change] = shoot(stage);
  }
  EXPECT_EQ(largest_difference(pictures[0], pictures[1]), 0);
}

// Where all that is opaque has one tint, tints are not drawn; a particle of another one, out of sight, has them drawn.
TEST(MediumImage, OneTintIsWhatParticlesAddUpTo) {
  for (const char* name : {"batter", "chocolate"}) {
    SyntheticScene s = block(name, {20, 16, 14}, 0.3);
    Picture pictures[2];
    for (const bool other : {false, true}) {
      if (other) {
        BodyDescription speck = s.scene.bodies[0];
        speck.color = {0, 1, 0};
        speck.first = speck.count;
        speck.count = 1;
        s.scene.bodies.push_back(speck);
        ++s.scene.particle_count;
        for (const int layers : {10, 8, 7}) s.frame.positions.push_back(static_cast<float>(layers * kSpacing));
        s.frame.scalars.push_back(0);
      }
      Stage stage(small_stage(640, 480));
      put_on(stage, s);
      EXPECT_EQ(stage.scene().cloud().one_tint(Medium::opaque).has_value(), !other);
      pictures[other] = shoot(stage);
    }
    // where matter is thin, light comes through by its depth there, and not by that of deeper matter
    EXPECT_LE(largest_difference(pictures[0], pictures[1]), 8) << name;
  }
}

// Matter that changes state goes from one look to the other in steps that nobody sees, and ends as the other.
TEST(MediumImage, MatterPassesFromOneLookToTheOther) {
  const std::pair<const char*, const char*> changes[] = {{"batter", "crepe"}, {"ice", "water"}};
  for (const auto& [first, then] : changes) {
    for (const BodyKind kind : {BodyKind::fluid, BodyKind::elastic}) {
      SCOPED_TRACE(std::string(first) + (kind == BodyKind::fluid ? ", a fluid" : ", elastic"));
      SyntheticScene s = block(first, {20, 16, 14}, 0.3);
      BodyDescription& body = s.scene.bodies[0];
      body.kind = kind;
      body.changed_look = named_look(then).look;
      body.changed_color = named_look(then).color;
      Stage stage(small_stage());
      put_on(stage, s);
      const auto changed_by = [&](int share) {
        s.frame.solid.assign(s.scene.particle_count,
                             static_cast<std::uint8_t>(kind == BodyKind::fluid ? share : 255 - share));
        stage.scene().set_frame(s.frame);
        return shoot(stage);
      };
      const Picture start = shoot(stage), end = changed_by(255);
      // of what is clear, what is within counts one by one once it changes, and in lumps before
      const int lumps = std::string(first) == "ice" ? 12 : 0;
      EXPECT_LE(largest_difference(start, changed_by(0)), lumps);
      EXPECT_GT(largest_difference(start, end), 40);
      Picture before = start;
      int most = 0;
      for (int share = 0; share <= 255; share += 5) {
        const Picture now = changed_by(share);
        most = std::max(most, largest_difference(before, now));
        before = now;
      }
      EXPECT_LE(most, 24) << "of 255, at a pixel, in a fiftieth of the change";
      EXPECT_EQ(largest_difference(before, end), 0);

      body.look = body.changed_look;
      body.color = body.changed_color;
      s.frame.solid.clear();
      put_on(stage, s);
      EXPECT_LE(largest_difference(shoot(stage), end), lumps) << "as what has always looked so";
    }
  }
}

TEST(MediumImage, ParticlesWithinABodyAreNotMissed) {
  EXPECT_EQ(largest_difference(block_of(true, "batter", true), block_of(false, "batter", true)), 0) << "beads";
  // colours are sums of half floats, in another order
  EXPECT_LE(largest_difference(block_of(true, "batter", false), block_of(false, "batter", false)), 3);
  // what is within counts lump by lump for how thick a clear medium is: blurred by a spacing
  EXPECT_LE(largest_difference(block_of(true, "honey", false), block_of(false, "honey", false)), 8);
}

TEST(MediumImage, AllParticlesSenselessIsAPictureWithoutThem) {
  Stage stage(small_stage());
  SyntheticScene s = still_tray("water");
  std::fill(s.frame.positions.begin(), s.frame.positions.end(), std::nanf(""));
  put_on(stage, s);
  EXPECT_GT(find(shoot(stage), [](Pixel p) { return p.r > 80; }).pixels, 500) << "the tray";
}

TEST(MediumImage, FineAndQuickSurfacesLookAlike) {
  Picture pictures[2];
  for (const bool fine : {false, true}) {
    StageOptions options = small_stage(800, 600);
    options.surfaces = fine ? Surfaces::fine : Surfaces::quick;
    Stage stage(options);
    put_on(stage, synthetic_scene());
    pictures[fine] = shoot(stage);
  }
  double difference = 0;
  for (std::size_t i = 0; i < pictures[0].rgb.size(); ++i)
    difference += std::abs(pictures[0].rgb[i] - pictures[1].rgb[i]);
  // ripples are smoothed a little differently: a grey level or two over the picture, many more were another picture
  EXPECT_LT(difference / static_cast<double>(pictures[0].rgb.size()), 2);
  EXPECT_GT(difference, 0);
}

TEST(MediumImage, ThePictureMayChangeItsSize) {
  Stage stage(small_stage(640, 480));
  put_on(stage, synthetic_scene());
  const Picture first = shoot(stage);
  for (const auto& [width, height] : {std::pair{320, 240}, {17, 33}, {640, 480}}) {
    stage.viewer().getCamera()->setViewport(0, 0, width, height);
    const Picture picture = shoot(stage);
    EXPECT_EQ(picture.width, width);
    if (width == first.width) {
      EXPECT_EQ(differing(first, picture), 0);
    }
  }
}

}  // namespace
}  // namespace palp::test::medium_image_test
