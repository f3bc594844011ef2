// A surface whose triangles share vertices, on its way from the bus to OSG.
#pragma once

#include <array>
#include <vector>

#include <osg/BoundingBox>
#include <osg/Geometry>
#include <osg/Vec3f>

#include "viewer/primitives.h"

namespace palp {

struct Triangle {
  std::array<unsigned, 3> corner;  // vertices, counter-clockwise seen from outside
  osg::Vec3f normal;
  float area;
  int primitive = -1;  // that all of it lies on; -1: none is known
};

struct Surface {
  std::vector<osg::Vec3f> vertices;
  std::vector<Triangle> triangles;
  std::vector<Primitive> primitives;
  osg::BoundingBox box;
};

// Sets normal and area from the corners. Returns false for a triangle too small to have a direction.
bool measure(const Surface& surface, Triangle& triangle);

// Returns the triangles of a drawn part, with the vertices as it has them: shared where it is smooth and not along its
// edges.
Surface surface_of(const osg::Geometry& part);

}  // namespace palp
