#include "viewer/home_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <osg/Math>

namespace palp {
namespace {

// How far from the middle of the picture to its sides, bottom and top points may lie: figures stand at the top.
constexpr double kSide = 0.90, kBottom = 0.92, kTop = 0.78;
constexpr double kNearestOverDepth = 0.2;  // a single point has no size to fit

// One axis of the picture. A point p is within its high edge where (p - eye) . axis <= slope (eye - p) . back, so one
// number a point says how far it reaches, and the largest of them where the eye must be.
struct Reach {
  osg::Vec3d axis;
  double high_slope, low_slope;
  double high = -std::numeric_limits<double>::infinity();
  double low = -std::numeric_limits<double>::infinity();

  void add(const osg::Vec3d& p, double depth) {
    high = std::max(high, p * axis + high_slope * depth);
    low = std::max(low, low_slope * depth - p * axis);
  }
  // The least depth of the eye from which both edges are kept.
  double depth() const { return (high + low) / (high_slope + low_slope); }
  // The eye's place along the axis, in the middle of those from which both edges are kept.
  double middle(double depth) const { return (high - low + (low_slope - high_slope) * depth) / 2; }
};

}  // namespace

CameraPose home_view(std::span<const osg::Vec3d> points, double aspect) {
  osg::Vec3d back = kHomeSide;
  back.normalize();
  osg::Vec3d right = osg::Vec3d(0, 0, 1) ^ back;
  right.normalize();
  const osg::Vec3d up = back ^ right;
  const double slope = std::tan(osg::DegreesToRadians(kFieldOfView) / 2);
  Reach across{right, kSide * aspect * slope, kSide * aspect * slope};
  Reach upward{up, kTop * slope, kBottom * slope};
  double nearest = -std::numeric_limits<double>::infinity(), farthest = std::numeric_limits<double>::infinity();
  for (const osg::Vec3d& p : points) {
    across.add(p, p * back);
    upward.add(p, p * back);
    nearest = std::max(nearest, p * back);
    farthest = std::min(farthest, p * back);
  }
  const double least = nearest + kNearestOverDepth * std::max(nearest - farthest, 1e-3);
  const double depth = std::max({across.depth(), upward.depth(), least});
  const osg::Vec3d axis = right * across.middle(depth) + up * upward.middle(depth);
  return {axis + back * depth, axis + back * (0.5 * (nearest + farthest))};
}

}  // namespace palp
