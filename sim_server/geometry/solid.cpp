#include "sim_server/geometry/solid.h"

#include <algorithm>
#include <cmath>

#include "config/error.h"

namespace palp {

namespace {

// Cuts [low, high] down to where origin + z * direction lies within -half..half.
void clip_slab(double origin, double direction, double half, Interval& z) {
  if (std::abs(direction) < 1e-12) {
    if (std::abs(origin) > half) z.high = z.low;
    return;
  }
  double a = (-half - origin) / direction, b = (half - origin) / direction;
  if (a > b) std::swap(a, b);
  z.low = std::max(z.low, a);
  z.high = std::min(z.high, b);
}

// Cuts down to where |o + z d| <= radius, for vectors of two or three components.
template <class Vector>
void clip_round(const Vector& o, const Vector& d, double radius, Interval& z) {
  const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - radius * radius;
  if (a < 1e-24) {
    if (c > 0) z.high = z.low;
    return;
  }
  const double root = b * b - a * c;
  if (root <= 0) {
    z.high = z.low;
    return;
  }
  z.low = std::max(z.low, (-b - std::sqrt(root)) / a);
  z.high = std::min(z.high, (-b + std::sqrt(root)) / a);
}

Eigen::Isometry3d pose_of(const ShapeConfig& shape) {
  return Eigen::Translation3d(shape.position) * shape.orientation.normalized();
}

Eigen::AlignedBox3d box_around(const Eigen::Isometry3d& pose, const Eigen::Vector3d& half) {
  const Eigen::Vector3d reach = pose.linear().cwiseAbs() * half;
  return {pose.translation() - reach, pose.translation() + reach};
}

Part make_part(const ShapeConfig& shape, const Eigen::Isometry3d& pose) {
  Part part;
  part.type = shape.type;
  part.subtract = shape.subtract;
  part.pose = pose;
  part.half = shape.size / 2;
  part.radius = shape.radius;
  part.half_height = shape.height / 2;
  if (shape.type == ShapeType::box) {
    part.moments = box_moments(shape.size).moved(pose);
    part.bounds = box_around(pose, part.half);
  } else if (shape.type == ShapeType::sphere) {
    part.moments = sphere_moments(shape.radius).moved(pose);
    part.bounds = box_around(Eigen::Isometry3d(Eigen::Translation3d(pose.translation())),
                             Eigen::Vector3d::Constant(shape.radius));
  } else if (shape.type == ShapeType::cylinder) {
    part.moments = cylinder_moments(shape.radius, shape.height).moved(pose);
    part.bounds = box_around(pose, {shape.radius, shape.radius, part.half_height});
  } else {
    SurfaceMesh mesh = load_mesh(shape.file, shape.scale);
    for (Eigen::Vector3d& v : mesh.vertices) v = pose * v;
    part.moments = mesh_moments(mesh);
    part.mesh = std::make_shared<ColumnMesh>(std::move(mesh));
    part.bounds = part.mesh->bounds();
  }
  return part;
}

// The union or difference of sorted, separate intervals.
void combine(std::vector<Interval>& solid, const std::vector<Interval>& part, bool subtract) {
  thread_local std::vector<Interval> out;
  out.clear();
  if (subtract) {
    for (Interval piece : solid) {
      for (const Interval& cut : part) {
        if (cut.high <= piece.low || cut.low >= piece.high) continue;
        if (cut.low > piece.low) out.push_back({piece.low, cut.low});
        piece.low = std::min(cut.high, piece.high);
      }
      if (piece.low < piece.high) out.push_back(piece);
    }
  } else {
    solid.insert(solid.end(), part.begin(), part.end());
    std::sort(solid.begin(), solid.end(), [](const Interval& a, const Interval& b) { return a.low < b.low; });
    for (const Interval& piece : solid) {
      if (!out.empty() && piece.low <= out.back().high) {
        out.back().high = std::max(out.back().high, piece.high);
      } else {
        out.push_back(piece);
      }
    }
  }
  solid.assign(out.begin(), out.end());
}

bool parts_apart(const Solid& solid) {
  for (std::size_t i = 0; i < solid.parts.size(); ++i) {
    if (solid.parts[i].subtract) return false;
    for (std::size_t j = 0; j < i; ++j) {
      if (!solid.parts[i].bounds.intersection(solid.parts[j].bounds).isEmpty()) return false;
    }
  }
  return true;
}

Moments box_between(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  return box_moments(high - low).moved(Eigen::Isometry3d(Eigen::Translation3d((low + high) / 2)));
}

Moments moments_by_boxes(const Solid& solid) {
  const BoxCells cells = box_cells(solid);
  Moments sum;
  for (std::size_t k = 0; k < cells.count(2); ++k) {
    for (std::size_t j = 0; j < cells.count(1); ++j) {
      for (std::size_t i = 0; i < cells.count(0); ++i) {
        if (!cells.at(i, j, k)) continue;
        sum += box_between({cells.cuts[0][i], cells.cuts[1][j], cells.cuts[2][k]},
                           {cells.cuts[0][i + 1], cells.cuts[1][j + 1], cells.cuts[2][k + 1]});
      }
    }
  }
  return sum;
}

// Strips of the solid's extent along an axis. They end where parts do, and a thin part has enough of them.
std::vector<Interval> strips(const Solid& solid, int axis) {
  constexpr double kStrips = 700, kLeast = 48;
  const double low = solid.bounds.min()[axis], high = solid.bounds.max()[axis];
  std::vector<double> cuts{low, high};
  for (const Part& part : solid.parts)
    for (const double end : {part.bounds.min()[axis], part.bounds.max()[axis]})
      cuts.push_back(std::clamp(end, low, high));
  std::sort(cuts.begin(), cuts.end());
  const double least = std::clamp(kStrips / static_cast<double>(cuts.size()), 1.0, kLeast);
  std::vector<Interval> out;
  for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
    const double length = cuts[c + 1] - cuts[c];
    if (!(length > 1e-9 * (high - low))) continue;
    const double count = std::ceil(std::max(least, kStrips * length / (high - low)));
    for (double i = 0; i < count; ++i)
      out.push_back({cuts[c] + i / count * length, cuts[c] + (i + 1) / count * length});
  }
  return out;
}

// Midpoint rule over x and y, exact along z.
Moments moments_by_lines(const Solid& solid) {
  const std::vector<Interval> along_x = strips(solid, 0), along_y = strips(solid, 1);
  Moments sum;
  std::vector<Interval> inside;
  for (const Interval& y : along_y) {
    for (const Interval& x : along_x) {
      solid.column((x.low + x.high) / 2, (y.low + y.high) / 2, inside);
      for (const Interval& z : inside) sum += box_between({x.low, y.low, z.low}, {x.high, y.high, z.high});
    }
  }
  return sum;
}

}  // namespace

bool Part::contains(const Eigen::Vector3d& point) const {
  if (!bounds.contains(point)) return false;
  if (type == ShapeType::mesh) {
    thread_local std::vector<Interval> inside;
    inside.clear();
    mesh->column(point.x(), point.y(), inside);
    return std::any_of(inside.begin(), inside.end(),
                       [&](const Interval& z) { return point.z() >= z.low && point.z() < z.high; });
  }
  const Eigen::Vector3d p = pose.linear().transpose() * (point - pose.translation());
  if (type == ShapeType::box) return (p.cwiseAbs().array() <= half.array()).all();
  if (type == ShapeType::sphere) return p.squaredNorm() <= radius * radius;
  return p.head<2>().squaredNorm() <= radius * radius && std::abs(p.z()) <= half_height;
}

void Part::column(double x, double y, std::vector<Interval>& out) const {
  if (x < bounds.min().x() || x > bounds.max().x() || y < bounds.min().y() || y > bounds.max().y()) return;
  if (type == ShapeType::mesh) {
    mesh->column(x, y, out);
    return;
  }
  const Eigen::Vector3d o = pose.linear().transpose() * (Eigen::Vector3d(x, y, 0) - pose.translation());
  const Eigen::Vector3d d = pose.linear().row(2).transpose();
  Interval z{bounds.min().z(), bounds.max().z()};
  if (type == ShapeType::box) {
    for (int axis = 0; axis < 3; ++axis) clip_slab(o[axis], d[axis], half[axis], z);
  } else if (type == ShapeType::sphere) {
    clip_round<Eigen::Vector3d>(o, d, radius, z);
  } else {
    clip_slab(o.z(), d.z(), half_height, z);
    clip_round<Eigen::Vector2d>(o.head<2>(), d.head<2>(), radius, z);
  }
  if (z.low < z.high) out.push_back(z);
}

bool Solid::contains(const Eigen::Vector3d& point) const {
  bool inside = false;
  for (const Part& part : parts) {
    if (part.subtract == inside && part.contains(point)) inside = !part.subtract;
  }
  return inside;
}

void Solid::column(double x, double y, std::vector<Interval>& out) const {
  thread_local std::vector<Interval> piece;
  out.clear();
  for (const Part& part : parts) {
    piece.clear();
    part.column(x, y, piece);
    if (!piece.empty()) combine(out, piece, part.subtract);
  }
}

bool Solid::aligned_boxes() const {
  constexpr std::size_t kMostBoxes = 40;  // cells grow with the cube
  return parts.size() <= kMostBoxes && std::all_of(parts.begin(), parts.end(), [](const Part& part) {
           return part.type == ShapeType::box && part.pose.linear().isIdentity(1e-12);
         });
}

Solid make_solid(const std::vector<ShapeConfig>& shapes) {
  Solid solid;
  solid.frame = pose_of(shapes.front());
  for (const ShapeConfig& shape : shapes) {
    Part part;
    try {
      part = make_part(shape, solid.frame.inverse() * pose_of(shape));
    } catch (const ConfigError& error) {
      throw ConfigError(shape.where + ": " + error.what());
    }
    if (!part.subtract) solid.bounds.extend(part.bounds);
    solid.parts.push_back(std::move(part));
  }
  return solid;
}

BoxCells box_cells(const Solid& solid) {
  BoxCells cells;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> faces;
    const double low = solid.bounds.min()[axis], high = solid.bounds.max()[axis];
    for (const Part& part : solid.parts) {
      faces.push_back(std::clamp(part.bounds.min()[axis], low, high));
      faces.push_back(std::clamp(part.bounds.max()[axis], low, high));
    }
    std::sort(faces.begin(), faces.end());
    const double same = 1e-9 * (high - low);
    for (const double face : faces) {
      if (cells.cuts[axis].empty() || face - cells.cuts[axis].back() > same) cells.cuts[axis].push_back(face);
    }
  }
  for (std::size_t k = 0; k < cells.count(2); ++k) {
    for (std::size_t j = 0; j < cells.count(1); ++j) {
      for (std::size_t i = 0; i < cells.count(0); ++i) {
        cells.inside.push_back(solid.contains({(cells.cuts[0][i] + cells.cuts[0][i + 1]) / 2,
                                               (cells.cuts[1][j] + cells.cuts[1][j + 1]) / 2,
                                               (cells.cuts[2][k] + cells.cuts[2][k + 1]) / 2}));
      }
    }
  }
  return cells;
}

Moments solid_moments(const Solid& solid) {
  if (parts_apart(solid)) {
    Moments sum;
    for (const Part& part : solid.parts) sum += part.moments;
    return sum;
  }
  return solid.aligned_boxes() ? moments_by_boxes(solid) : moments_by_lines(solid);
}

}  // namespace palp
