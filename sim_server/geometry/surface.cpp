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

}  // namespace

SurfaceMesh solid_surface(const Solid& solid, double cell) {
  SurfaceMesh mesh;
  if (solid.aligned_boxes()) {
    mesh = boxes_surface(box_cells(solid));
  } else if (std::none_of(solid.parts.begin(), solid.parts.end(), [](const Part& part) { return part.subtract; })) {
    for (const Part& part : solid.parts) {
      if (part.type != ShapeType::box) {
        append(mesh, part_surface(part));
        continue;
      }
      Solid box;
      box.parts = {part};
      box.parts[0].pose.setIdentity();
      box.bounds = box.parts[0].bounds = Eigen::AlignedBox3d(-part.half, part.half);
      SurfaceMesh faces = boxes_surface(box_cells(box));
      for (Eigen::Vector3d& v : faces.vertices) v = part.pose * v;
      append(mesh, faces);
    }
  } else {
    mesh = Marching(solid, cell).run();
  }
  for (Eigen::Vector3d& v : mesh.vertices) v = solid.frame * v;
  return mesh;
}

}  // namespace palp
