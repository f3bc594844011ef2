// Closed triangle meshes: reading, checking, integrating, and cutting with vertical lines.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_server/geometry/moments.h"
#include "sim_server/geometry/surface_mesh.h"

namespace palp {

// Reads an OBJ, STL (text or binary) or PLY (text or binary little endian) file by its ending and checks it: finite,
// not empty, welded, closed (each edge between exactly two triangles, in opposite directions), of positive volume (a
// mesh that is inside out is turned). Vertices are scaled by `scale`. Throws ConfigError with one sentence that begins
// with the file (and line), and for a mesh that is unfit says where it is open.
SurfaceMesh load_mesh(const std::string& path, double scale);

// The parts of load_mesh, for tests. read_mesh trusts nothing; its triangles only name vertices that exist.
SurfaceMesh read_mesh(const std::string& bytes, const std::string& path);
SurfaceMesh checked_mesh(SurfaceMesh mesh, const std::string& path);

// Exact integrals of the polyhedron, in the mesh's frame.
Moments mesh_moments(const SurfaceMesh& mesh);

struct Interval {
  double low, high;
};

// A mesh prepared for lines along z. Watertight: neighbouring triangles decide a shared edge with the same numbers.
class ColumnMesh {
 public:
  explicit ColumnMesh(SurfaceMesh mesh);
  // Appends the intervals of z inside the mesh over (x, y), in order.
  void column(double x, double y, std::vector<Interval>& out) const;
  const SurfaceMesh& mesh() const { return mesh_; }
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }

 private:
  struct Crossing {
    double z;
    int turn;  // +1 entering, -1 leaving
  };
  bool crossings(double x, double y, std::vector<Crossing>& out) const;
  int bin(double value, int axis) const;
  std::size_t bin_index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(bins_) + static_cast<std::size_t>(i);
  }

  SurfaceMesh mesh_;
  Eigen::AlignedBox3d bounds_;
  int bins_ = 1;                          // per axis
  std::vector<std::uint32_t> bin_first_;  // bins_^2 + 1
  std::vector<std::uint32_t> bin_triangle_;
};

}  // namespace palp
