// A plane that cuts the scene open. Pure.
#pragma once

#include <osg/BoundingBox>
#include <osg/Vec3d>
#include <osg/Vec4d>

namespace palp {

// A plane across an axis of the world. The home view looks along +y, from the right and from above: what is nearer to
// it is cut away, unless the plane is flipped.
struct ClipPlane {
  bool on = false;
  int axis = 1;        // 0 x, 1 y, 2 z
  double share = 0.5;  // where the plane stands between the two sides of the scene's box, 0 .. 1
  bool flipped = false;
  bool operator==(const ClipPlane&) const = default;
};

// Keeps everything.
inline const osg::Vec4d kNoClip(0, 0, 0, 1);

// Returns where the plane stands along its axis [m].
double position_of(const ClipPlane& clip, const osg::BoundingBoxd& box);
// Returns the share that puts a plane there, within 0 .. 1. position: [m].
double share_at(double position, int axis, const osg::BoundingBoxd& box);
// Returns (n, d) so that a point p [m] of the world is kept where n . p + d >= 0; kNoClip for a plane that is off.
osg::Vec4d equation_of(const ClipPlane& clip, const osg::BoundingBoxd& box);

inline bool keeps(const osg::Vec4d& equation, const osg::Vec3d& p) {
  return equation.x() * p.x() + equation.y() * p.y() + equation.z() * p.z() + equation.w() >= 0;
}

}  // namespace palp
