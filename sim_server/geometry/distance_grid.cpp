// Signed distances to a mesh: exact at nodes near a triangle, handed on from node to node elsewhere (Bridson's level
// sets from meshes).
#include <algorithm>
#include <cmath>

#include "sim_server/geometry/contact_shape.h"

namespace palp {

namespace {

constexpr double kMostNodes = 2e6;
constexpr int kMargin = 3;  // cells around the mesh

// The point of a triangle nearest to p (Ericson 2005, 5.1.5).
Eigen::Vector3d nearest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double sum = va + vb + vc;
  return sum > 0 ? Eigen::Vector3d(a + vb / sum * ab + vc / sum * ac) : a;
}

struct Nearest {
  double distance = 1e30;
  std::uint32_t triangle = 0xffffffffu;
};

class GridMaker {
 public:
  GridMaker(const Part& part, double cell) : part_(part), mesh_(part.mesh->mesh()) {
    const Eigen::Vector3d size = part.bounds.sizes();
    const double nodes = (size.array() / cell + 2 * kMargin + 1).prod();
    if (nodes > kMostNodes) cell *= std::cbrt(nodes / kMostNodes) * 1.05;
    grid_.cell = cell;
    for (Eigen::Index a = 0; a < 3; ++a)
      grid_.n[static_cast<std::size_t>(a)] = static_cast<int>(std::ceil(size[a] / cell)) + 2 * kMargin + 1;
    const Eigen::Vector3d extent = cell * Eigen::Vector3d(grid_.n[0] - 1, grid_.n[1] - 1, grid_.n[2] - 1);
    grid_.origin = part.bounds.center() - extent / 2;
    nearest_.resize(static_cast<std::size_t>(grid_.n[0]) * static_cast<std::size_t>(grid_.n[1]) *
                    static_cast<std::size_t>(grid_.n[2]));
  }

  DistanceGrid run() {
    near_triangles();
    for (int round = 0; round < 2; ++round)
      for (int way = 0; way < 8; ++way) hand_on(way);
    for (int k = 0; k < grid_.n[2]; ++k)
      for (int j = 0; j < grid_.n[1]; ++j)
        for (int i = 0; i < grid_.n[0]; ++i) store(i, j, k);
    return std::move(grid_);
  }

 private:
  Eigen::Vector3d node(int i, int j, int k) const { return grid_.origin + grid_.cell * Eigen::Vector3d(i, j, k); }
  std::size_t at(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(grid_.n[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(grid_.n[0]) +
           static_cast<std::size_t>(i);
  }
  Eigen::Vector3d foot(std::uint32_t t, const Eigen::Vector3d& x) const {
    const auto& v = mesh_.triangles[t];
    return nearest_on_triangle(x, mesh_.vertices[v[0]], mesh_.vertices[v[1]], mesh_.vertices[v[2]]);
  }
  void offer(std::uint32_t t, int i, int j, int k) {
    Nearest& best = nearest_[at(i, j, k)];
    const Eigen::Vector3d x = node(i, j, k);
    const double d = (foot(t, x) - x).norm();
    if (d < best.distance) best = {d, t};
  }

  void near_triangles() {
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      Eigen::AlignedBox3d box;
      for (const std::uint32_t v : mesh_.triangles[t]) box.extend(mesh_.vertices[v]);
      int low[3], high[3];
      for (int a = 0; a < 3; ++a) {
        const int most = grid_.n[static_cast<std::size_t>(a)] - 1;
        low[a] = std::clamp(static_cast<int>((box.min()[a] - grid_.origin[a]) / grid_.cell) - 1, 0, most);
        high[a] = std::clamp(static_cast<int>((box.max()[a] - grid_.origin[a]) / grid_.cell) + 2, 0, most);
      }
      for (int k = low[2]; k <= high[2]; ++k)
        for (int j = low[1]; j <= high[1]; ++j)
          for (int i = low[0]; i <= high[0]; ++i) offer(t, i, j, k);
    }
  }

  // From each node's neighbours behind it, along one of the eight diagonals.
  void hand_on(int way) {
    const int dx = way & 1 ? 1 : -1, dy = way & 2 ? 1 : -1, dz = way & 4 ? 1 : -1;
    for (int c = 0; c < grid_.n[2]; ++c)
      for (int b = 0; b < grid_.n[1]; ++b)
        for (int a = 0; a < grid_.n[0]; ++a) {
          const int i = dx > 0 ? a : grid_.n[0] - 1 - a, j = dy > 0 ? b : grid_.n[1] - 1 - b;
          const int k = dz > 0 ? c : grid_.n[2] - 1 - c;
          take(i, j, k, i - dx, j, k);
          take(i, j, k, i, j - dy, k);
          take(i, j, k, i, j, k - dz);
        }
  }
  void take(int i, int j, int k, int p, int q, int r) {
    if (p < 0 || q < 0 || r < 0 || p >= grid_.n[0] || q >= grid_.n[1] || r >= grid_.n[2]) return;
    const std::uint32_t t = nearest_[at(p, q, r)].triangle;
    if (t != 0xffffffffu && t != nearest_[at(i, j, k)].triangle) offer(t, i, j, k);
  }

  void store(int i, int j, int k) {
    const Nearest& best = nearest_[at(i, j, k)];
    const Eigen::Vector3d x = node(i, j, k);
    const double sign = part_.contains(x) ? -1 : 1;
    Eigen::Vector3d normal = sign * (x - foot(best.triangle, x));
    // on the surface the triangle's own
    const auto& v = mesh_.triangles[best.triangle];
    if (best.distance < 1e-6 * grid_.cell)
      normal = (mesh_.vertices[v[1]] - mesh_.vertices[v[0]]).cross(mesh_.vertices[v[2]] - mesh_.vertices[v[0]]);
    normal.normalize();
    grid_.distance.push_back(static_cast<float>(sign * best.distance));
    for (int a = 0; a < 3; ++a) grid_.normal.push_back(static_cast<float>(normal[a]));
  }

  const Part& part_;
  const SurfaceMesh& mesh_;
  DistanceGrid grid_;
  std::vector<Nearest> nearest_;
};

}  // namespace

DistanceGrid distance_grid(const Part& mesh, double cell) { return GridMaker(mesh, cell).run(); }

}  // namespace palp
