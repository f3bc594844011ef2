// The solid that a body's shapes make, in a frame of its own: that of the first shape, in which lattices are laid.
// Everything is asked by lines along z, which suits lattices, integrals and meshes alike.
#pragma once

#include <memory>
#include <vector>

#include "config/scene_config.h"
#include "sim_server/geometry/mesh.h"

namespace palp {

struct Part {
  ShapeType type = ShapeType::box;  // box, sphere, cylinder, mesh
  bool subtract = false;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // of the shape in the solid's frame
  Eigen::Vector3d half = Eigen::Vector3d::Zero();          // box
  double radius = 0, half_height = 0;                      // sphere, cylinder
  std::shared_ptr<const ColumnMesh> mesh;                  // its vertices are in the solid's frame
  Eigen::AlignedBox3d bounds;                              // in the solid's frame
  Moments moments;                                         // in the solid's frame

  bool contains(const Eigen::Vector3d& point) const;  // solid's frame
  void column(double x, double y, std::vector<Interval>& out) const;
};

struct Solid {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();  // of the solid in the body frame
  std::vector<Part> parts;
  Eigen::AlignedBox3d bounds;  // of the parts that are added

  bool contains(const Eigen::Vector3d& point) const;
  // The intervals of z inside over (x, y): in order, apart from one another.
  void column(double x, double y, std::vector<Interval>& out) const;
  // All parts are boxes along the solid's axes.
  bool aligned_boxes() const;
};

// Loads meshes. Throws ConfigError. Not for `particles`.
Solid make_solid(const std::vector<ShapeConfig>& shapes);

// Exact for a single part, for parts that do not overlap, and for boxes along one set of axes; otherwise by lines,
// where volume and inertia are within 1e-3 of the exact value for parts not thinner than a twentieth of the whole
// (tested).
Moments solid_moments(const Solid& solid);

// Boxes along the solid's axes, cut at all their faces: cells between neighbouring cuts are wholly inside or outside.
struct BoxCells {
  std::vector<double> cuts[3];
  std::vector<bool> inside;  // x fastest
  std::size_t count(int axis) const { return cuts[axis].size() - 1; }
  bool at(std::size_t i, std::size_t j, std::size_t k) const { return inside[(k * count(1) + j) * count(0) + i]; }
};
BoxCells box_cells(const Solid& solid);

}  // namespace palp
