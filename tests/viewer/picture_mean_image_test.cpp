// Pictures that are the mean of several ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/viewer/block_scene.h"
#include "tests/viewer/picture_tools.h"
#include "tests/viewer/synthetic_scene.h"
#include "viewer/stage.h"

namespace palp::test {
namespace {

// How far the upper edge of what is bright is from a straight line between two places, found between the levels of two
// pixels [pixels, root mean square].
double jaggedness(const Picture& picture, const osg::Vec2d& a, const osg::Vec2d& b) {
  constexpr double kEdge = 90;
  std::vector<osg::Vec2d> edge;
  for (int x = static_cast<int>(std::min(a.x(), b.x())); x < static_cast<int>(std::max(a.x(), b.x())); ++x) {
    int y = picture.height - 1;
    while (y > 0 && at(picture, x, y).r < kEdge) --y;
    const double bright = at(picture, x, y).r, dark = at(picture, x, y + 1).r;
    edge.emplace_back(x, y + (bright - kEdge) / std::max(bright - dark, 1.0));
  }
  return off_line(edge);
}

TEST(PictureMeanImage, HasNoStepsAlongEdges) {
  double jagged[2];
  for (const bool smooth : {false, true}) {
    StageOptions options = small_stage();
    options.mean_of = smooth ? 8 : 1;
    Stage stage(options);
    SyntheticScene s = synthetic_scene();
    s.scene.bodies.resize(1);
    s.scene.bodies[0] = {};
    s.scene.bodies[0].kind = BodyKind::fixed;
    s.scene.bodies[0].name = "brick";
    s.scene.bodies[0].color = {1, 0.9f, 0.9f};
    add_box(s.scene.bodies[0], {-0.1, -0.1, 0}, {0.1, 0.1, 0.1}, true, true);
    s.scene.particle_count = 0;
    s.frame = {};
    s.poses = {};
    put_on(stage, s);
    stage.set_camera({{0.3, -0.5, 0.4}, {0, 0, 0.05}}, 30);
    const Picture picture = shoot(stage);
    jagged[smooth] = jaggedness(picture, stage.project({-0.1, -0.05, 0.1}), stage.project({-0.1, 0.05, 0.1}));
  }
  EXPECT_GT(jagged[false], 0.2) << "pixels; rounding to whole ones is 0.29";
  EXPECT_LT(jagged[true], 0.4 * jagged[false]) << "pixels";
}

}  // namespace
}  // namespace palp::test
