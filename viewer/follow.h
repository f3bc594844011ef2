// A camera that goes with the tool. Pure.
#pragma once

#include <cmath>
#include <span>

#include <osg/Vec3d>

namespace palp {

// [s] after which a little more than a third of the way to a tool that stands still is left: slow enough not to shake
// with the hand, fast enough to keep it in the picture.
inline constexpr double kFollowTime = 0.4;

// Returns where the camera looks after so many seconds, when it looked at center and follows target; places in m.
inline osg::Vec3d followed(const osg::Vec3d& center, const osg::Vec3d& target, double seconds) {
  if (!target.valid() || !(seconds > 0)) return center;
  return center + (target - center) * (1 - std::exp(-seconds / kFollowTime));
}

// Returns the mean of the points, of which there is one at least.
inline osg::Vec3d middle_of(std::span<const osg::Vec3d> points) {
  osg::Vec3d sum;
  for (const osg::Vec3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

}  // namespace palp
