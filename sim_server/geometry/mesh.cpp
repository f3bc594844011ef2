#include "sim_server/geometry/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_map>

#include "config/error.h"
#include "config/text_file.h"

namespace palp {

namespace {

constexpr std::size_t kMaxMeshBytes = std::size_t{512} << 20;
constexpr double kWeld = 1e-7;  // of the mesh's size: vertices nearer than this are one

std::string place(const Eigen::Vector3d& p) { return fmt::format("({:g}, {:g}, {:g})", p.x(), p.y(), p.z()); }

// Makes one vertex of those that coincide, by rounding to a grid of kWeld and looking into the cells around.
void weld(SurfaceMesh& mesh, double cell) {
  using Key = std::array<std::int64_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& k) const {
      std::uint64_t hash = 0;
      for (const std::int64_t index : k) hash = (hash ^ static_cast<std::uint64_t>(index)) * 0x9E3779B97F4A7C15ULL;
      return static_cast<std::size_t>(hash ^ hash >> 32);
    }
  };
  std::unordered_map<Key, std::uint32_t, Hash> seen;
  std::vector<std::uint32_t> to(mesh.vertices.size());
  std::vector<Eigen::Vector3d> kept;
  const auto find = [&](const Key& base, const Eigen::Vector3d& p) -> const std::uint32_t* {
    for (int n = 0; n < 27; ++n) {
      const auto found = seen.find({base[0] + n % 3 - 1, base[1] + n / 3 % 3 - 1, base[2] + n / 9 - 1});
      if (found != seen.end() && (kept[found->second] - p).norm() <= cell) return &found->second;
    }
    return nullptr;
  };
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d& p = mesh.vertices[i];
    Key key;
    for (int a = 0; a < 3; ++a) key[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(std::floor(p[a] / cell));
    if (const std::uint32_t* same = find(key, p)) {
      to[i] = *same;
    } else {
      to[i] = static_cast<std::uint32_t>(kept.size());
      seen.emplace(key, to[i]);
      kept.push_back(p);
    }
  }
  mesh.vertices = std::move(kept);
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& vertex : triangle) vertex = to[vertex];
  }
}

// Each edge must lie between two triangles that run along it in opposite directions.
void check_closed(const SurfaceMesh& mesh, const std::string& path) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<int, int>> edges;  // low, high vertex -> forth, back
  for (const auto& t : mesh.triangles) {
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = t[e], b = t[(e + 1) % 3];
      auto& count = edges[{std::min(a, b), std::max(a, b)}];
      ++(a < b ? count.first : count.second);
    }
  }
  std::size_t open = 0, twisted = 0, crowded = 0;
  const std::pair<std::uint32_t, std::uint32_t>* first = nullptr;
  for (const auto& [edge, count] : edges) {
    const int total = count.first + count.second;
    if (total == 2 && count.first == 1) continue;
    ++(total < 2 ? open : total > 2 ? crowded : twisted);
    if (!first) first = &edge;
  }
  if (!first) return;
  const std::string where = place(mesh.vertices[first->first]) + " to " + place(mesh.vertices[first->second]);
  if (open > 0) {
    throw ConfigError(
        fmt::format("{}: the mesh is open: {} edges have only one triangle, the first from {}; expected a "
                    "closed surface",
                    path, open, where));
  }
  if (crowded > 0) {
    throw ConfigError(
        fmt::format("{}: {} edges have more than two triangles, the first from {}; expected a closed "
                    "surface with two triangles on each edge",
                    path, crowded, where));
  }
  throw ConfigError(
      fmt::format("{}: neighbouring triangles face opposite ways at {} edges, the first from {}; expected "
                  "all to be counter-clockwise seen from outside",
                  path, twisted, where));
}

}  // namespace

Moments mesh_moments(const SurfaceMesh& mesh) {
  Eigen::Vector3d base = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& v : mesh.vertices) base += v / static_cast<double>(mesh.vertices.size());
  Moments sum;  // of tetrahedra between each triangle and the base
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]] - base, b = mesh.vertices[t[1]] - base,
                          c = mesh.vertices[t[2]] - base;
    const double volume = a.dot(b.cross(c)) / 6;
    const Eigen::Vector3d s = a + b + c;
    sum.volume += volume;
    sum.first += volume / 4 * s;
    sum.second += volume / 20 * (s * s.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
  }
  return sum.moved(Eigen::Isometry3d(Eigen::Translation3d(base)));
}

SurfaceMesh checked_mesh(SurfaceMesh mesh, const std::string& path) {
  if (mesh.vertices.empty() || mesh.triangles.empty()) throw ConfigError(path + ": the mesh has no triangles");
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& v : mesh.vertices) {
    if (!v.allFinite()) throw ConfigError(path + ": a vertex is not a finite number");
    box.extend(v);
  }
  const double size = box.diagonal().norm();
  const double far = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  if (!(size > 1e-12) || !(far < 1e9) || far > 1e8 * size) {
    throw ConfigError(
        fmt::format("{}: the mesh is {:g} m large and reaches {:g} m from its origin, expected a size above "
                    "1e-12 m, near the origin",
                    path, size, far));
  }
  weld(mesh, kWeld * size);
  std::erase_if(mesh.triangles, [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  if (mesh.triangles.empty()) throw ConfigError(path + ": all triangles of the mesh are degenerate");
  check_closed(mesh, path);
  const double volume = mesh_moments(mesh).volume;
  if (!(std::abs(volume) > 1e-12 * box.diagonal().cwiseMax(1e-6 * size).prod())) {
    throw ConfigError(path + ": the mesh encloses no volume");
  }
  if (volume < 0) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

SurfaceMesh load_mesh(const std::string& path, double scale) {
  SurfaceMesh mesh = read_mesh(read_text_file(path, kMaxMeshBytes), path);
  for (Eigen::Vector3d& v : mesh.vertices) v *= scale;
  return checked_mesh(std::move(mesh), path);
}

ColumnMesh::ColumnMesh(SurfaceMesh mesh) : mesh_(std::move(mesh)) {
  for (const Eigen::Vector3d& v : mesh_.vertices) bounds_.extend(v);
  // Bins of the triangle, with one further on each side, so that a shifted line finds it.
  struct Bins {
    int first[2], last[2];
    std::size_t count() const {
      return static_cast<std::size_t>(last[0] - first[0] + 1) * static_cast<std::size_t>(last[1] - first[1] + 1);
    }
  };
  const auto bins_of = [this](const std::array<std::uint32_t, 3>& triangle) {
    Eigen::AlignedBox3d box;
    for (const std::uint32_t v : triangle) box.extend(mesh_.vertices[v]);
    Bins b{};
    for (int a = 0; a < 2; ++a) {
      b.first[a] = std::max(0, bin(box.min()[a], a) - 1);
      b.last[a] = std::min(bins_ - 1, bin(box.max()[a], a) + 1);
    }
    return b;
  };
  // fewer bins where many triangles span many of them: their lists would fill the memory
  constexpr std::size_t kMostOfATriangle = 64;
  const auto entries = [&] {
    std::size_t sum = 0;
    for (const auto& triangle : mesh_.triangles) sum += bins_of(triangle).count();
    return sum;
  };
  bins_ = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(mesh_.triangles.size()))), 1, 512);
  while (bins_ > 1 && entries() > kMostOfATriangle * mesh_.triangles.size()) bins_ /= 2;
  std::vector<std::vector<std::uint32_t>> bins(bin_index(0, bins_));
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    const Bins b = bins_of(mesh_.triangles[t]);
    for (int j = b.first[1]; j <= b.last[1]; ++j)
      for (int i = b.first[0]; i <= b.last[0]; ++i) bins[bin_index(i, j)].push_back(static_cast<std::uint32_t>(t));
  }
  bin_first_.push_back(0);
  for (const auto& list : bins) {
    bin_triangle_.insert(bin_triangle_.end(), list.begin(), list.end());
    bin_first_.push_back(static_cast<std::uint32_t>(bin_triangle_.size()));
  }
}

int ColumnMesh::bin(double value, int axis) const {
  const double extent = bounds_.max()[axis] - bounds_.min()[axis];
  if (!(extent > 0)) return 0;
  const double at = (value - bounds_.min()[axis]) / extent * bins_;
  return static_cast<int>(std::clamp(std::floor(at), 0.0, static_cast<double>(bins_ - 1)));
}

namespace {

// Twice the area of (p, q, x) seen from above; when zero, that of x moved a little along x and less along y. Computed
// the same way whichever triangle asks.
double side(const std::vector<Eigen::Vector3d>& vertices, std::uint32_t from, std::uint32_t to, double x, double y) {
  const bool swapped = from > to;
  const Eigen::Vector3d& p = vertices[swapped ? to : from];
  const Eigen::Vector3d& q = vertices[swapped ? from : to];
  double area = (q.x() - p.x()) * (y - p.y()) - (q.y() - p.y()) * (x - p.x());
  if (area == 0) {
    const double tie = q.y() != p.y() ? p.y() - q.y() : q.x() - p.x();
    area = tie < 0 ? -1e-300 : 1e-300;
  }
  return swapped ? -area : area;
}

}  // namespace

// False when entries and exits do not match, which rounding can cause at a vertex.
bool ColumnMesh::crossings(double x, double y, std::vector<Crossing>& out) const {
  out.clear();
  if (x < bounds_.min().x() || x > bounds_.max().x() || y < bounds_.min().y() || y > bounds_.max().y()) return true;
  const std::size_t cell = bin_index(bin(x, 0), bin(y, 1));
  int sum = 0;
  for (std::uint32_t n = bin_first_[cell]; n < bin_first_[cell + 1]; ++n) {
    const auto& t = mesh_.triangles[bin_triangle_[n]];
    const double a = side(mesh_.vertices, t[1], t[2], x, y), b = side(mesh_.vertices, t[2], t[0], x, y);
    const double c = side(mesh_.vertices, t[0], t[1], x, y);
    if (!((a > 0 && b > 0 && c > 0) || (a < 0 && b < 0 && c < 0))) continue;
    const double total = a + b + c;
    const double z =
        (a * mesh_.vertices[t[0]].z() + b * mesh_.vertices[t[1]].z() + c * mesh_.vertices[t[2]].z()) / total;
    const int turn = total > 0 ? -1 : 1;
    out.push_back({std::isfinite(z) ? z : mesh_.vertices[t[0]].z(), turn});
    sum += turn;
  }
  return sum == 0;
}

void ColumnMesh::column(double x, double y, std::vector<Interval>& out) const {
  thread_local std::vector<Crossing> found;
  const double step = 1e-10 * bounds_.diagonal().norm();
  for (int attempt = 0; attempt < 8; ++attempt) {
    if (crossings(x + attempt * step, y + attempt * 0.618 * step, found)) break;
  }
  // at equal heights enter before leaving, so that touching parts join
  std::sort(found.begin(), found.end(),
            [](const Crossing& p, const Crossing& q) { return p.z != q.z ? p.z < q.z : p.turn > q.turn; });
  int depth = 0;
  double low = 0;
  for (const Crossing& crossing : found) {
    const int before = depth;
    depth += crossing.turn;
    if (before <= 0 && depth > 0) low = crossing.z;
    if (before > 0 && depth <= 0) out.push_back({low, crossing.z});
  }
}

}  // namespace palp
