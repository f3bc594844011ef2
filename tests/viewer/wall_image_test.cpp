// Pictures of still liquids in a tray whose walls one looks through: their surface ends at the walls.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/stage.h"

namespace palp::test::wall_image_test {
namespace {

constexpr double kThick = 3 * kSpacing, kThin = 0.3 * kSpacing;

// Particles of a lattice below the tray's depth.
SyntheticScene full_tray(const char* look, double wall = kThick) {
  SyntheticScene s = synthetic_scene();
  make_look(s.scene.bodies[0], look);
  s.scene.bodies[1] = tray(wall);
  s.scene.bodies.pop_back();
  s.poses = {};
  s.frame.positions.clear();
  for (double z = kSpacing / 2; z < kDepth; z += kSpacing)
    for (double y = -kHalfY + kSpacing / 2; y < kHalfY; y += kSpacing)
      for (double x = -kHalfX + kSpacing / 2; x < kHalfX; x += kSpacing)
        for (const double c : {x, y, z}) s.frame.positions.push_back(static_cast<float>(c));
  s.scene.bodies[0].count = s.scene.particle_count = static_cast<std::uint32_t>(s.frame.positions.size() / 3);
  s.frame.scalars.assign(s.frame.positions.size() / 3, 0.2f);
  return s;
}

double brightness(Stage& stage, const Picture& picture, const osg::Vec3d& place) {
  const osg::Vec2d p = stage.project(place);
  double sum = 0;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x) {
      const auto pixel = at(picture, static_cast<int>(p.x()) + x, static_cast<int>(p.y()) + y);
      sum += pixel.r + pixel.g + pixel.b;
    }
  return sum / 27;
}

// The near wall is at y = -kHalfY. Half a spacing below its edge a surface that turned round there would be as bright
// as one that leans.
TEST(WallImage, ALiquidIsFlatUpToTheWallsItTouches) {
  constexpr double kLevel = 6 * kSpacing;  // of the lattice
  for (const double wall : {kThick, kThin})
    for (const Surfaces quality : {Surfaces::quick, Surfaces::fine}) {
      StageOptions options = small_stage(640, 480);
      options.surfaces = quality;
      Stage stage(options);
      set_scene(stage, full_tray("batter", wall).scene);
      stage.scene().set_frame(full_tray("batter", wall).frame);
      stage.go_home();
      const Picture picture = shoot(stage);
      const double deep = brightness(stage, picture, {0.05, -kHalfY, kLevel - 3 * kSpacing});
      const double below_edge = brightness(stage, picture, {0.05, -kHalfY, kLevel - 0.7 * kSpacing});
      const double far_in = brightness(stage, picture, {0.05, -kHalfY + 5 * kSpacing, kLevel});
      const double beside_edge = brightness(stage, picture, {0.05, -kHalfY + 0.7 * kSpacing, kLevel});
      EXPECT_GT(std::abs(far_in - deep), 20) << "top and side are lit alike: the test sees no edge";
      EXPECT_NEAR(below_edge, deep, 8) << wall;
      EXPECT_NEAR(beside_edge, far_in, 8) << wall;
    }
}

// The difference in brightness at a place that a full tray makes to an empty one.
class Filling {
 public:
  Filling(const char* look, double wall) : stage_(small_stage(640, 480)) {
    SyntheticScene s = full_tray(look, wall);
    set_scene(stage_, s.scene);
    stage_.scene().set_frame(s.frame);
    stage_.go_home();
    full_ = shoot(stage_);
    for (std::size_t i = 2; i < s.frame.positions.size(); i += 3) s.frame.positions[i] = -1e9f;  // no places
    stage_.scene().set_frame(s.frame);
    empty_ = shoot(stage_);
  }
  double seen_at(const osg::Vec3d& place) {
    return brightness(stage_, full_, place) - brightness(stage_, empty_, place);
  }

 private:
  Stage stage_;
  Picture full_, empty_;
};

TEST(WallImage, NothingOfItIsSeenWithinTheWalls) {
  for (const char* look : {"batter", "water"}) {
    Filling filling(look, kThick);
    // in the corner of two walls, on whose other side there is the ground
    for (const double z : {0.01, 0.02, 0.03, 0.04, 0.05, 0.06})
      EXPECT_NEAR(filling.seen_at({-kHalfX - 0.5 * kSpacing, -kHalfY - 0.5 * kSpacing, z}), 0, 1.5) << look << " " << z;
  }
}

// Half a spacing past the outer corner of thin walls, where an image of what stands in the corner would be.
TEST(WallImage, NothingOfItIsSeenBesideThinWalls) {
  for (const char* look : {"batter", "water"}) {
    Filling filling(look, kThin);
    for (const double z : {0.01, 0.02, 0.03, 0.04})
      for (const double side : {-1.0, 1.0})
        EXPECT_NEAR(filling.seen_at({side * (kHalfX + 0.6 * kSpacing), side * (kHalfY + 0.6 * kSpacing), z}), 0, 1.5)
            << look << " " << side << " " << z;
  }
}

}  // namespace
}  // namespace palp::test::wall_image_test
