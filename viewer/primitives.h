// The planes, spheres and cylinders that the vertices of a surface lie on.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <osg/Vec3d>
#include <osg/Vec3f>

namespace palp {

struct Primitive {
  enum class Kind { plane, sphere, cylinder };

  Kind kind = Kind::plane;
  osg::Vec3d origin;  // a point of the plane, the centre, or a point of the axis
  osg::Vec3d axis;    // unit length: the plane's normal, the cylinder's axis
  double radius = 0;

  double distance(const osg::Vec3d& p) const;    // signed
  osg::Vec3d normal(const osg::Vec3d& p) const;  // unit length: the gradient of the distance
};

// Returns the primitives that many vertices lie on, within tolerance, the largest first. Vertices that a solid of
// boxes, spheres and cylinders was sampled with all lie on one; other surfaces have few or none. The same input gives
// the same result.
std::vector<Primitive> find_primitives(std::span<const osg::Vec3f> vertices,
                                       std::span<const std::array<unsigned, 3>> triangles, double tolerance);

}  // namespace palp
