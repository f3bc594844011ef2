// Finds what lies under the mouse: brute force over particles and triangles, a few milliseconds for a million. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <osg/Matrixd>
#include <osg/Vec3d>

#include "viewer/clip_plane.h"

namespace palp {

// A ray in the world.
struct Ray {
  osg::Vec3d origin;     // [m]
  osg::Vec3d direction;  // of unit length
};

struct Hit {
  std::size_t index = 0;
  double distance = 0;  // from the ray's origin [m]
};

// Returns the nearest of the spheres about the positions [first, first + count) that the ray enters, if any. positions:
// x y z [m] each; what is not finite is passed over. radius: [m]. clip: centres that it cuts away are passed over.
std::optional<Hit> pick_particle(const Ray& ray, std::span<const float> positions, std::size_t first, std::size_t count,
                                 double radius, const osg::Vec4d& clip);

// Returns where the ray first meets a surface, if it does; the index is the triangle's. vertices: x y z [m] in the
// frame of the body; to_world: its pose. Triangles with indices past the vertices are passed over. clip: places that it
// cuts away are passed over.
std::optional<Hit> pick_surface(const Ray& ray, std::span<const float> vertices,
                                std::span<const std::uint32_t> triangles, const osg::Matrixd& to_world,
                                const osg::Vec4d& clip);

}  // namespace palp
