#include "sim_server/geometry/surface.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace palp {
namespace {

using Index = std::uint32_t;

void append(SurfaceMesh& to, const SurfaceMesh& part) {
  const auto base = static_cast<Index>(to.vertices.size());
  to.vertices.insert(to.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const auto& t : part.triangles) to.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

// Rings of points between two poles; each ring has the same number of points.
SurfaceMesh lathe(const std::vector<Eigen::Vector2d>& profile, Index around) {  // (radius, z) from bottom to top
  SurfaceMesh mesh;
  mesh.vertices.emplace_back(0, 0, profile.front().y());
  for (std::size_t r = 1; r + 1 < profile.size(); ++r) {
    for (Index i = 0; i < around; ++i) {
      const double angle = 2 * EIGEN_PI * i / around;
      mesh.vertices.emplace_back(profile[r].x() * std::cos(angle), profile[r].x() * std::sin(angle), profile[r].y());
    }
  }
  mesh.vertices.emplace_back(0, 0, profile.back().y());
  const auto rings = static_cast<Index>(profile.size() - 2), top = static_cast<Index>(mesh.vertices.size() - 1);
  for (Index i = 0; i < around; ++i) {
    const Index next = (i + 1) % around;
    mesh.triangles.push_back({0, 1 + next, 1 + i});
    for (Index r = 0; r + 1 < rings; ++r) {
      const Index a = 1 + r * around + i, b = 1 + r * around + next;
      mesh.triangles.push_back({a, b, b + around});
      mesh.triangles.push_back({a, b + around, a + around});
    }
    mesh.triangles.push_back({1 + (rings - 1) * around + i, 1 + (rings - 1) * around + next, top});
  }
  return mesh;
}

SurfaceMesh part_surface(const Part& part) {
  if (part.type == ShapeType::mesh) return part.mesh->mesh();
  SurfaceMesh mesh;
  if (part.type == ShapeType::sphere) {
    constexpr int kRings = 16;
    std::vector<Eigen::Vector2d> profile;
    for (int i = 0; i <= kRings; ++i) {
      const double angle = EIGEN_PI * i / kRings;
      profile.emplace_back(part.radius * std::sin(angle), -part.radius * std::cos(angle));
    }
    mesh = lathe(profile, 2 * kRings);
  } else {
    const double h = part.half_height, r = part.radius;
    mesh = lathe({{0, -h}, {r, -h}, {r, h}, {0, h}}, 32);
  }
  for (Eigen::Vector3d& v : mesh.vertices) v = part.pose * v;
  return mesh;
}

// The faces between cells inside and cells outside.
SurfaceMesh boxes_surface(const BoxCells& cells) {
  SurfaceMesh mesh;
  const std::size_t n[3] = {cells.count(0), cells.count(1), cells.count(2)};
  std::map<std::array<std::size_t, 3>, Index> vertex;
  const auto corner = [&](const std::array<std::size_t, 3>& c) {
    const auto [found, added] = vertex.emplace(c, static_cast<Index>(mesh.vertices.size()));
    if (added) mesh.vertices.emplace_back(cells.cuts[0][c[0]], cells.cuts[1][c[1]], cells.cuts[2][c[2]]);
    return found->second;
  };
  const auto inside = [&](std::array<std::size_t, 3> c, std::size_t axis, int step) {
    if ((step < 0 && c[axis] == 0) || (step > 0 && c[axis] + 1 == n[axis])) return false;
    c[axis] += static_cast<std::size_t>(step);
    return cells.at(c[0], c[1], c[2]);
  };
  for (std::size_t k = 0; k < n[2]; ++k) {
    for (std::size_t j = 0; j < n[1]; ++j) {
      for (std::size_t i = 0; i < n[0]; ++i) {
        if (!cells.at(i, j, k)) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          for (const int step : {-1, 1}) {
            const std::array<std::size_t, 3> c{i, j, k};
            if (inside(c, axis, step)) continue;
            const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
            auto p = c;
            p[axis] += step > 0 ? 1 : 0;
            auto q = p, r = p, s = p;
            q[u] += 1, r[u] += 1, r[v] += 1, s[v] += 1;
            if (step < 0) std::swap(q, s);
            mesh.triangles.push_back({corner(p), corner(q), corner(r)});
            mesh.triangles.push_back({corner(p), corner(r), corner(s)});
          }
        }
      }
    }
  }
  return mesh;
}

// Marching tetrahedra: six to a cell around its diagonal. The surface crosses the edges between points inside and
// outside where halving finds it.
class Marching {
 public:
  Marching(const Solid& solid, double cell) : solid_(solid) {
    constexpr double kMostCells = 48;
    const Eigen::Vector3d size = solid.bounds.sizes();
    cell = std::max(cell, size.maxCoeff() / kMostCells);
    for (int a = 0; a < 3; ++a) n_[a] = static_cast<Index>(std::ceil(size[a] / cell)) + 2;
    origin_ = solid.bounds.center() - 0.5 * cell * Eigen::Vector3d(n_[0], n_[1], n_[2]);
    // off the faces of boxes, so that no corner lies on one
    origin_ += 1e-4 * cell * Eigen::Vector3d(1, 0.7, 0.4);
    cell_ = cell;
  }

  SurfaceMesh run() {
    for (Index k = 0; k <= n_[2]; ++k) {
      for (Index j = 0; j <= n_[1]; ++j) {
        for (Index i = 0; i <= n_[0]; ++i) inside_.push_back(solid_.contains(point({i, j, k})));
      }
    }
    for (Index k = 0; k < n_[2]; ++k) {
      for (Index j = 0; j < n_[1]; ++j) {
        for (Index i = 0; i < n_[0]; ++i) cell(i, j, k);
      }
    }
    return std::move(mesh_);
  }

 private:
  using Corner = std::array<Index, 3>;

  Eigen::Vector3d point(const Corner& c) const { return origin_ + cell_ * Eigen::Vector3d(c[0], c[1], c[2]); }
  Index number(const Corner& c) const { return (c[2] * (n_[1] + 1) + c[1]) * (n_[0] + 1) + c[0]; }
  bool inside(const Corner& c) const { return inside_[number(c)]; }

  void cell(Index i, Index j, Index k) {
    static constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (const auto& order : kOrders) {
      std::array<Corner, 4> t;
      t[0] = {i, j, k};
      for (std::size_t s = 0; s < 3; ++s) {
        t[s + 1] = t[s];
        ++t[s + 1][static_cast<std::size_t>(order[s])];
      }
      tetrahedron(t);
    }
  }

  Index crossing(const Corner& in, const Corner& out) {
    const std::pair<Index, Index> key = std::minmax({number(in), number(out)});
    const auto [found, added] = edge_.emplace(key, static_cast<Index>(mesh_.vertices.size()));
    if (added) {
      Eigen::Vector3d a = point(in), b = point(out);
      for (int halving = 0; halving < 16; ++halving) {
        const Eigen::Vector3d middle = (a + b) / 2;
        (solid_.contains(middle) ? a : b) = middle;
      }
      mesh_.vertices.push_back((a + b) / 2);
    }
    return found->second;
  }

  // Turned so that it faces away from `within`.
  void triangle(Index a, Index b, Index c, const Eigen::Vector3d& forth) {
    const auto& v = mesh_.vertices;
    if ((v[b] - v[a]).cross(v[c] - v[a]).dot(forth) < 0) std::swap(b, c);
    mesh_.triangles.push_back({a, b, c});
  }

  void tetrahedron(const std::array<Corner, 4>& t) {
    std::vector<Corner> in, out;
    Eigen::Vector3d forth = Eigen::Vector3d::Zero();
    for (const Corner& c : t) (inside(c) ? in : out).push_back(c);
    if (in.empty() || out.empty()) return;
    for (const Corner& c : in) forth -= point(c) / static_cast<double>(in.size());
    for (const Corner& c : out) forth += point(c) / static_cast<double>(out.size());
    if (in.size() == 1) triangle(crossing(in[0], out[0]), crossing(in[0], out[1]), crossing(in[0], out[2]), forth);
    if (out.size() == 1) triangle(crossing(in[0], out[0]), crossing(in[1], out[0]), crossing(in[2], out[0]), forth);
    if (in.size() == 2) {
      const Index a = crossing(in[0], out[0]), b = crossing(in[0], out[1]);
      const Index c = crossing(in[1], out[1]), d = crossing(in[1], out[0]);
      triangle(a, b, c, forth);
      triangle(a, c, d, forth);
    }
  }

  const Solid& solid_;
  std::array<Index, 3> n_{};
  Eigen::Vector3d origin_;
  double cell_ = 0;
  std::vector<bool> inside_;
  std::map<std::pair<Index, Index>, Index> edge_;
  SurfaceMesh mesh_;
};

// The outline of a solid of revolution in the half plane (distance from the axis, along the axis): marching triangles,
// two to a square. Lines run with the solid on their left. They are closed, or end on the axis.
class Outline {
 public:
  Outline(const Solid& solid, const Eigen::Isometry3d& axis, double radius, double low, double high)
      : solid_(solid), axis_(axis) {
    constexpr int kCells = 400;  // along the larger side
    cell_ = std::max(radius, high - low) / kCells;
    n_[0] = static_cast<Index>(radius / cell_) + 3;
    n_[1] = static_cast<Index>((high - low) / cell_) + 4;
    low_ = low - 1.37 * cell_;  // off the faces
    for (Index j = 0; j <= n_[1]; ++j)
      for (Index i = 0; i <= n_[0]; ++i) inside_.push_back(contains(at(number(i, j))));
    for (Index j = 0; j < n_[1]; ++j)
      for (Index i = 0; i < n_[0]; ++i) {
        triangle(number(i, j), number(i + 1, j), number(i + 1, j + 1));
        triangle(number(i, j), number(i + 1, j + 1), number(i, j + 1));
      }
  }

  std::vector<std::vector<Eigen::Vector2d>> lines() {
    std::vector<std::vector<Eigen::Vector2d>> out;
    std::vector<bool> follows(point_.size(), false);
    for (const auto& [from, to] : next_) follows[to] = true;
    // those that begin on the axis first: the rest are closed
    for (const bool open : {true, false})
      for (Index k = 0; k < point_.size(); ++k)
        if ((!open || !follows[k]) && next_.count(k) > 0) out.push_back(simple(line_from(k)));
    return out;
  }

 private:
  bool contains(const Eigen::Vector2d& p) const { return solid_.contains(axis_ * Eigen::Vector3d(p.x(), 0, p.y())); }
  Index number(Index i, Index j) const { return j * (n_[0] + 1) + i; }
  Eigen::Vector2d at(Index node) const {
    const Index across = n_[0] + 1, column = node % across, row = node / across;
    return {cell_ * column, low_ + cell_ * row};
  }
  Index crossing(Index in, Index out) {
    const auto [found, added] = edge_.emplace(std::minmax(in, out), static_cast<Index>(point_.size()));
    if (added) {
      Eigen::Vector2d a = at(in), b = at(out);
      for (int halving = 0; halving < 30; ++halving) {
        const Eigen::Vector2d middle = (a + b) / 2;
        (contains(middle) ? a : b) = middle;
      }
      point_.push_back((a + b) / 2);
    }
    return found->second;
  }
  // a, b, c go around to the left.
  void triangle(Index a, Index b, Index c) {
    for (int turn = 0; turn < 3; ++turn) {
      if (inside_[a] && !inside_[b] && !inside_[c]) next_[crossing(a, b)] = crossing(a, c);
      if (!inside_[a] && inside_[b] && inside_[c]) next_[crossing(c, a)] = crossing(b, a);
      std::swap(a, b);
      std::swap(b, c);
    }
  }
  std::vector<Eigen::Vector2d> line_from(Index first) {
    std::vector<Eigen::Vector2d> line{point_[first]};
    for (auto step = next_.find(first); step != next_.end();) {
      line.push_back(point_[step->second]);
      const Index to = step->second;
      next_.erase(step);
      step = next_.find(to);
    }
    return line;
  }
  // Leaves out points that lie on the line between those that are kept (Ramer, Douglas and Peucker).
  std::vector<Eigen::Vector2d> simple(const std::vector<Eigen::Vector2d>& line) const {
    std::vector<bool> kept(line.size(), false);
    kept.front() = kept[line.size() / 2] = kept.back() = true;
    std::vector<std::pair<std::size_t, std::size_t>> open{{0, line.size() / 2}, {line.size() / 2, line.size() - 1}};
    while (!open.empty()) {
      const auto [from, to] = open.back();
      open.pop_back();
      const Eigen::Vector2d along = line[to] - line[from];
      std::size_t farthest = from;
      double most = 0.02 * cell_;
      for (std::size_t k = from + 1; k < to; ++k) {
        const Eigen::Vector2d d = line[k] - line[from];
        const double off = along.norm() > 0 ? std::abs(along.x() * d.y() - along.y() * d.x()) / along.norm() : d.norm();
        if (off > most) most = off, farthest = k;
      }
      if (farthest == from) continue;
      kept[farthest] = true;
      open.push_back({from, farthest});
      open.push_back({farthest, to});
    }
    std::vector<Eigen::Vector2d> out;
    for (std::size_t k = 0; k < line.size(); ++k)
      if (kept[k]) out.push_back(line[k]);
    return with_corners(out);
  }
  // Puts corners back that the cells cut off: where the lines on both sides of a short one meet.
  std::vector<Eigen::Vector2d> with_corners(std::vector<Eigen::Vector2d> line) const {
    for (std::size_t k = 1; k + 2 < line.size(); ++k) {
      const Eigen::Vector2d before = line[k] - line[k - 1], cut = line[k + 1] - line[k],
                            after = line[k + 2] - line[k + 1];
      if (cut.norm() > 1.5 * cell_ || before.norm() < 2 * cell_ || after.norm() < 2 * cell_) continue;
      const double turn = before.x() * after.y() - before.y() * after.x();
      const double on = (cut.x() * after.y() - cut.y() * after.x()) / turn;  // of `before`, past its end
      if (!(on * before.norm() > 0 && on * before.norm() < 2 * cell_)) continue;
      line[k] += on * before;
      line.erase(line.begin() + static_cast<std::ptrdiff_t>(k) + 1);
    }
    return line;
  }

  const Solid& solid_;
  Eigen::Isometry3d axis_;
  double cell_ = 0, low_ = 0;
  Index n_[2] = {0, 0};
  std::vector<bool> inside_;
  std::vector<Eigen::Vector2d> point_;
  std::map<std::pair<Index, Index>, Index> edge_;
  std::map<Index, Index> next_;
};

// Returns the surface that a line makes as it turns about the axis z.
SurfaceMesh revolved(const std::vector<Eigen::Vector2d>& line, Index around) {
  SurfaceMesh mesh;
  const bool closed = line.front() == line.back();
  std::vector<Index> ring;  // the first vertex of each point's
  const auto on_axis = [](const Eigen::Vector2d& p) { return !(p.x() > 0); };
  for (std::size_t k = 0; k + (closed ? 1 : 0) < line.size(); ++k) {
    ring.push_back(static_cast<Index>(mesh.vertices.size()));
    for (Index i = 0; i < (on_axis(line[k]) ? 1 : around); ++i) {
      const double angle = 2 * EIGEN_PI * i / around;
      mesh.vertices.emplace_back(line[k].x() * std::cos(angle), line[k].x() * std::sin(angle), line[k].y());
    }
  }
  if (closed) ring.push_back(ring.front());
  for (std::size_t k = 0; k + 1 < line.size(); ++k)
    for (Index i = 0; i < around; ++i) {
      const Index next = (i + 1) % around;
      const bool from_axis = on_axis(line[k]), to_axis = on_axis(line[k + 1]);
      const Index a = ring[k] + (from_axis ? 0 : i), b = ring[k] + (from_axis ? 0 : next);
      const Index c = ring[k + 1] + (to_axis ? 0 : next), d = ring[k + 1] + (to_axis ? 0 : i);
      if (!from_axis) mesh.triangles.push_back({a, b, c});
      if (!to_axis) mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

// Returns the surface of a solid whose parts are spheres and cylinders about one axis; empty for another solid.
SurfaceMesh surface_of_revolution(const Solid& solid, double cell) {
  const double bit = 1e-9 * solid.bounds.sizes().norm();
  Eigen::Isometry3d axis = solid.parts.front().pose;
  for (const Part& part : solid.parts)
    if (part.type == ShapeType::cylinder) axis = part.pose;
  double radius = 0, low = 1e30, high = -1e30;
  for (const Part& part : solid.parts) {
    if (part.type != ShapeType::cylinder && part.type != ShapeType::sphere) return {};
    const Eigen::Isometry3d pose = axis.inverse() * part.pose;
    if (std::hypot(pose.translation().x(), pose.translation().y()) > bit) return {};
    if (part.type == ShapeType::cylinder && std::hypot(pose(0, 2), pose(1, 2)) > 1e-9) return {};
    if (part.subtract) continue;
    const double half = part.type == ShapeType::sphere ? part.radius : part.half_height;
    radius = std::max(radius, part.radius);
    low = std::min(low, pose.translation().z() - half);
    high = std::max(high, pose.translation().z() + half);
  }
  SurfaceMesh mesh;
  const double around = std::clamp(std::ceil(6.28 * radius / cell), 32.0, 96.0);
  for (const auto& line : Outline(solid, axis, radius, low, high).lines())
    append(mesh, revolved(line, static_cast<Index>(around)));
  for (Eigen::Vector3d& v : mesh.vertices) v = axis * v;
  return mesh;
}

// Adds the surface of a part by itself.
void append_part(SurfaceMesh& to, const Part& part) {
  if (part.type != ShapeType::box) return append(to, part_surface(part));
  Solid box{Eigen::Isometry3d::Identity(), {part}, {-part.half, part.half}};
  box.parts[0].pose.setIdentity();
  box.parts[0].bounds = box.bounds;
  SurfaceMesh faces = boxes_surface(box_cells(box));
  for (Eigen::Vector3d& v : faces.vertices) v = part.pose * v;
  append(to, faces);
}

}  // namespace

SurfaceMesh solid_surface(const Solid& solid, double cell) {
  SurfaceMesh mesh;
  if (solid.aligned_boxes()) {
    mesh = boxes_surface(box_cells(solid));
  } else {
    // what comes after all that is cut away stands beside the rest
    Solid cut = solid;
    std::vector<Part> whole;
    for (; !cut.parts.empty() && !cut.parts.back().subtract; cut.parts.pop_back()) whole.push_back(cut.parts.back());
    if (!cut.parts.empty()) mesh = surface_of_revolution(cut, cell);
    const bool beside = cut.parts.empty() || !mesh.triangles.empty();
    if (!beside) mesh = Marching(solid, cell).run();
    for (auto part = whole.rbegin(); beside && part != whole.rend(); ++part) append_part(mesh, *part);
  }
  for (Eigen::Vector3d& v : mesh.vertices) v = solid.frame * v;
  return mesh;
}

}  // namespace palp
