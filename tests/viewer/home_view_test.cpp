// The camera that shows a whole scene.
#include "viewer/home_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include <osg/Math>
#include <osg/Matrixd>

#include "tests/support/seed.h"

namespace palp::test {
namespace {

// The points as a picture of height 2 and width 2 aspect shows them, its middle at 0.
std::vector<osg::Vec3d> projected(const std::vector<osg::Vec3d>& points, const CameraPose& pose, double aspect) {
  const osg::Matrixd view = osg::Matrixd::lookAt(pose.eye, pose.center, {0, 0, 1});
  const osg::Matrixd all = view * osg::Matrixd::perspective(kFieldOfView, aspect, 1e-3, 1e3);
  std::vector<osg::Vec3d> out;
  for (const osg::Vec3d& p : points) out.push_back(p * all);
  return out;
}

TEST(HomeView, HoldsAllPointsAndTouchesTwoMargins) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int round = 0; round < 50; ++round) {
    const osg::Vec3d size(std::exp(2 * number(random)), std::exp(2 * number(random)), std::exp(2 * number(random)));
    const double aspect = round % 2 == 0 ? 16.0 / 9 : 0.7;
    std::vector<osg::Vec3d> points;
    for (int i = 0; i < 30; ++i)
      points.emplace_back(5 + size.x() * number(random), size.y() * number(random), size.z() * number(random));
    double x_min = 1, x_max = -1, y_min = 1, y_max = -1;
    for (const osg::Vec3d& p : projected(points, home_view(points, aspect), aspect)) {
      x_min = std::min(x_min, p.x()), x_max = std::max(x_max, p.x());
      y_min = std::min(y_min, p.y()), y_max = std::max(y_max, p.y());
    }
    // distances to the margins; rounding alone is allowed
    const double left = 0.9 + x_min, right = 0.9 - x_max, bottom = 0.92 + y_min, top = 0.78 - y_max;
    EXPECT_GE(std::min({left, right, bottom, top}), -1e-9);
    EXPECT_NEAR(std::min(std::max(left, right), std::max(bottom, top)), 0, 1e-9) << "both edges of one axis";
  }
}

TEST(HomeView, APointAloneIsBetweenTheMargins) {
  const std::vector<osg::Vec3d> point{{3, 2, 1}};
  const CameraPose pose = home_view(point, 1.5);
  EXPECT_GT((pose.eye - pose.center).length(), 1e-5);
  const osg::Vec3d seen = projected(point, pose, 1.5)[0];
  EXPECT_NEAR(seen.x(), 0, 1e-6);
  EXPECT_NEAR(seen.y(), (0.78 - 0.92) / 2, 1e-6) << "between the margins";
}

}  // namespace
}  // namespace palp::test
