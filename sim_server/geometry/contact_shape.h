// The shape of a body's solid as contact needs it: its signed distance, and the points of its surface that other solids
// can touch first. Host only; contact_store.h lays it out for the kernels, physics/rigid_contact.h evaluates it.
#pragma once

#include <memory>
#include <vector>

#include "sim_server/geometry/solid.h"

namespace palp {

// Signed distances to a mesh at the nodes of a lattice, with unit normals, in the solid's frame.
struct DistanceGrid {
  Eigen::Vector3d origin;       // of node (0, 0, 0)
  double cell = 0;              // [m]
  std::array<int, 3> n{};       // nodes per axis, x fastest
  std::vector<float> distance;  // [m]
  std::vector<float> normal;    // x y z
};

// Box: low and high corner in its own frame, +-1e30 where it has no end. Sphere: its radius in high.x. Cylinder along
// z: its radius in high.x, half its height in high.z.
struct ContactPiece {
  ShapeType type = ShapeType::box;
  bool subtract = false;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // in the solid's frame
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
  int grid = -1;  // mesh: index into ContactShape::grids
};

struct ContactPoint {
  Eigen::Vector3d position;  // body frame
  double radius = 0;         // a ball around it belongs to the solid
  int round = -1;            // index into ContactShape::rounds
};

// A circle all of which is on the surface, so that its points may move along it (physics/distance.h, Round).
struct ContactRound {
  Eigen::Vector3d center, axis, zero;  // body frame
  double reach = 0;                    // [m]
  double points = 0;
};

struct ContactShape {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();  // of the solid in the body frame
  // Boxes along the solid's axes: the pieces that are added fill the solid, those that are subtracted all the space
  // around it, so that distances are exact on both sides. Otherwise: pieces are added and subtracted in order,
  // distances being exact where one piece is nearest.
  bool boxes = false;
  std::vector<ContactPiece> pieces;
  std::vector<DistanceGrid> grids;
  Eigen::AlignedBox3d bounds;  // in the solid's frame
  std::vector<ContactPoint> points;
  std::vector<ContactRound> rounds;
};

// surface: the solid's, in the body frame. spacing: points are nowhere further apart along an edge than this, and the
// nodes of a mesh's distances are half of it apart, further where that would be more than two million.
std::shared_ptr<const ContactShape> make_contact_shape(const Solid& solid, const SurfaceMesh& surface, double spacing);

// Distance and normals of a mesh from its triangles; parts of contact_shape.cpp for tests.
DistanceGrid distance_grid(const Part& mesh, double cell);

}  // namespace palp
