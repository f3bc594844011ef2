#include "sim_server/scene/thick_walls.h"

#include <algorithm>
#include <limits>

namespace palp {
namespace {

using Eigen::Vector3d;

constexpr double kTurned = 1e-6;  // of an axis, from which two shapes do not stand along the same ones
constexpr double kFlush = 1e-9;   // between two faces that are one [m]

bool is_round(const ShapeConfig& shape) { return shape.type == ShapeType::cylinder; }

// Returns half the shape's extent along its axes.
Vector3d half_of(const ShapeConfig& shape) {
  return is_round(shape) ? Vector3d(shape.radius, shape.radius, shape.height / 2) : Vector3d(shape.size / 2);
}

bool along_same_axes(const ShapeConfig& a, const ShapeConfig& b) {
  const Eigen::Matrix3d turn = (a.orientation.conjugate() * b.orientation).normalized().toRotationMatrix();
  return is_round(a) == is_round(b) && (turn - Eigen::Matrix3d::Identity()).norm() < kTurned;
}

// Returns by how much the side of a shape has to grow so that all that is cut away is `least` behind it; 0 where
// something is cut away up to there. along: axis of the shape. side: 1 or -1.
double missing(const ShapeConfig& shape, const std::vector<ShapeConfig>& all, int along, double side, double least) {
  double thinnest = std::numeric_limits<double>::infinity();
  for (const ShapeConfig& cut : all) {
    if (!cut.subtract || cut.type == ShapeType::sphere || cut.type == ShapeType::mesh || !along_same_axes(shape, cut))
      continue;
    const Vector3d way = shape.orientation.conjugate() * (cut.position - shape.position);
    const double wall = half_of(shape)[along] - half_of(cut)[along] - side * way[along];
    if (wall < kFlush) return 0;
    thinnest = std::min(thinnest, wall);
  }
  return thinnest < least ? least - thinnest : 0;
}

void grow(ShapeConfig& shape, int along, double side, double by) {
  (is_round(shape) ? shape.height : shape.size[along]) += by;
  shape.position += shape.orientation * (side * by / 2 * Vector3d::Unit(along));
}

}  // namespace

std::vector<ShapeConfig> with_thick_walls(std::vector<ShapeConfig> shapes, double least) {
  const std::vector<ShapeConfig> before = shapes;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    ShapeConfig& shape = shapes[k];
    if (shape.subtract || (shape.type != ShapeType::box && !is_round(shape))) continue;
    for (const double side : {-1.0, 1.0})
      for (int along = is_round(shape) ? 2 : 0; along < 3; ++along)
        if (const double by = missing(before[k], before, along, side, least); by > 0) grow(shape, along, side, by);
    if (is_round(shape))
      shape.radius += std::max(missing(before[k], before, 0, 1, least), missing(before[k], before, 0, -1, least));
  }
  return shapes;
}

}  // namespace palp
