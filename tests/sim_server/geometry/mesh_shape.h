// A solid as a mesh in a file.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "sim_server/geometry/surface.h"
#include "tests/support/files.h"
#include "tests/support/scene_builder.h"

namespace palp::test {

// A closed mesh of the solid that the shapes make, with cells of `spacing`, in a file that goes away with the process.
inline ShapeConfig as_mesh(const std::vector<ShapeConfig>& shapes, const std::string& name, double spacing) {
  static const ScratchFolder folder;
  ShapeConfig shape = box(Eigen::Vector3d::Zero());
  shape.type = ShapeType::mesh;
  shape.file = folder / name;
  std::ofstream out(shape.file);
  const SurfaceMesh mesh = solid_surface(make_solid(shapes), spacing);
  for (const Eigen::Vector3d& v : mesh.vertices) out << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  for (const auto& t : mesh.triangles) out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return shape;
}

}  // namespace palp::test
