// A triangulated surface, as mesh files hold it and the viewer draws it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace palp {

struct SurfaceMesh {
  std::vector<Eigen::Vector3d> vertices;                // body frame [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from outside
};

}  // namespace palp
