// The boxes around the particles of a body at the start. Host only.
#pragma once

#include "sim_server/scene/scene.h"

namespace palp {

// Returns the box around a body's particle centres, in the given axes [m].
inline Eigen::AlignedBox3d body_bounds(const Scene& scene, const Body& body,
                                       const Eigen::Quaterniond& axes = Eigen::Quaterniond::Identity()) {
  Eigen::AlignedBox3d box;
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
    box.extend(Eigen::Vector3d(axes.conjugate() * scene.position[i]));
  return box;
}

// Returns the same box along the body's axes, around the places of particles that were left out, too.
inline Eigen::AlignedBox3d own_bounds(const Scene& scene, const Body& body) {
  return body.extent.isEmpty() ? body_bounds(scene, body, body.orientation) : body.extent;
}

// Returns a box along the world's axes around the places of a body's particles, those that were left out, too.
inline Eigen::AlignedBox3d world_bounds(const Scene& scene, const Body& body) {
  return body.extent.isEmpty() ? body_bounds(scene, body)
                               : body.extent.transformed(Eigen::Isometry3d(body.orientation));
}

}  // namespace palp
