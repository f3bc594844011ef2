#include "viewer/sharpen.h"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <unordered_map>

namespace palp {
namespace {

// Surfaces with fewer vertices are no lattice's: the corners of a box lie on a sphere. Finer ones come from mesh files.
constexpr std::size_t kFewestVertices = 100, kMostVertices = 150'000;
constexpr double kLongestEdge = 3;        // of a lattice, over the usual one; exact surfaces have longer ones
constexpr double kToleranceShare = 2e-3;  // of the length of a lattice's edges
constexpr double kUnknownShare = 0.02;    // of the vertices that may lie on nothing
constexpr double kFarthestShare = 1.5;    // of an edge's length: how far off an edge of the solid may be

constexpr double kAligned = 0.9;  // least cosine between a triangle's normal and that of what it lies on

using Mask = std::uint32_t;  // one bit a primitive
constexpr unsigned kNone = ~0u;

// The length of the edges of a surface.
struct EdgeLengths {
  double usual, longest;
};

EdgeLengths edge_lengths(const Surface& surface) {
  std::vector<float> lengths;
  for (const Triangle& t : surface.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      lengths.push_back((surface.vertices[t.corner[(k + 1) % 3]] - surface.vertices[t.corner[k]]).length());
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return {*middle, *std::max_element(middle, lengths.end())};
}

class Sharpening {
 public:
  explicit Sharpening(Surface& surface) : surface_(surface) {}

  void run() {
    const std::size_t count = surface_.vertices.size();
    if (surface_.triangles.empty() || count < kFewestVertices || count > kMostVertices) return;
    const EdgeLengths edges = edge_lengths(surface_);
    if (edges.longest > kLongestEdge * edges.usual) return;
    std::vector<std::array<unsigned, 3>> corners;
    for (const Triangle& t : surface_.triangles) corners.push_back(t.corner);
    const double tolerance = kToleranceShare * edges.usual;
    surface_.primitives = find_primitives(surface_.vertices, corners, tolerance);
    if (!label(tolerance)) {
      surface_.primitives.clear();
      return;
    }
    std::vector<Triangle> before;
    before.swap(surface_.triangles);
    for (const Triangle& t : before) cut(t);
  }

 private:
  // Finds the primitives of each vertex. Returns false if too many have none.
  bool label(double tolerance) {
    std::size_t unknown = 0;
    for (const osg::Vec3f& v : surface_.vertices) {
      Mask mask = 0;
      for (std::size_t i = 0; i < surface_.primitives.size(); ++i)
        if (std::abs(surface_.primitives[i].distance(v)) < tolerance) mask |= Mask{1} << i;
      masks_.push_back(mask);
      unknown += mask == 0;
    }
    return static_cast<double>(unknown) <= kUnknownShare * static_cast<double>(masks_.size());
  }

  void cut(const Triangle& t) {
    const auto& c = t.corner;
    if ((masks_[c[0]] & masks_[c[1]] & masks_[c[2]]) != 0) return add(c[0], c[1], c[2]);
    std::array<unsigned, 3> on{};  // the new vertex of the edge from corner k to the next
    int found = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      on[k] = vertex_between(c[k], c[(k + 1) % 3]);
      found += on[k] != kNone;
    }
    if (found == 0) return add(c[0], c[1], c[2]);
    if (found == 3) return cut_corner(c, on);
    // turned so that the first edge is the one that is cut, or of two the one that is not
    std::size_t k = 0;
    while ((on[k] != kNone) != (found == 1)) ++k;
    const unsigned a = c[k], b = c[(k + 1) % 3], d = c[(k + 2) % 3];
    if (found == 1) {
      add(a, on[k], d);
      add(on[k], b, d);
      return;
    }
    const unsigned right = on[(k + 1) % 3], left = on[(k + 2) % 3];
    add(a, b, right);
    add(a, right, left);
    add(left, right, d);
  }

  // A corner of the solid, where three primitives meet.
  void cut_corner(const std::array<unsigned, 3>& c, const std::array<unsigned, 3>& on) {
    osg::Vec3d middle;
    double size = 0;
    std::vector<int> meeting;
    for (std::size_t k = 0; k < 3; ++k) {
      middle += osg::Vec3d(surface_.vertices[on[k]]) / 3;
      size = std::max<double>(size, (surface_.vertices[c[k]] - surface_.vertices[c[(k + 1) % 3]]).length());
      meeting.push_back(std::countr_zero(masks_[c[k]]));
    }
    const Mask mask = masks_[on[0]] | masks_[on[1]] | masks_[on[2]];
    const unsigned tip = add_vertex(meeting_point(meeting, middle, kFarthestShare * size).value_or(middle), mask);
    for (std::size_t k = 0; k < 3; ++k) {
      add(c[k], on[k], tip);
      add(c[k], tip, on[(k + 2) % 3]);
    }
  }

  // Returns the vertex where an edge between two primitives crosses the edge of the solid, or kNone where it does not.
  unsigned vertex_between(unsigned a, unsigned b) {
    if (masks_[a] == 0 || masks_[b] == 0 || (masks_[a] & masks_[b]) != 0) return kNone;
    const std::uint64_t key = std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    const auto [entry, added] = between_.emplace(key, kNone);
    if (!added) return entry->second;
    const osg::Vec3d p = surface_.vertices[a], q = surface_.vertices[b];
    const double farthest = kFarthestShare * (p - q).length();
    const std::vector<int> meeting{std::countr_zero(masks_[a]), std::countr_zero(masks_[b])};
    if (const auto point = meeting_point(meeting, (p + q) / 2, farthest))
      entry->second = add_vertex(*point, Mask{1} << meeting[0] | Mask{1} << meeting[1]);
    return entry->second;
  }

  // Returns the point nearest to the start where the primitives meet, by Newton's method, if it is near.
  std::optional<osg::Vec3d> meeting_point(const std::vector<int>& meeting, const osg::Vec3d& start,
                                          double farthest) const {
    osg::Vec3d p = start;
    double off = 0;
    for (int round = 0; round < 8; ++round) {
      // the shortest step: with two primitives it leaves the direction along their edge free
      Eigen::Matrix3d normals = Eigen::Matrix3d::Identity() * 1e-12;
      Eigen::Vector3d pull = Eigen::Vector3d::Zero();
      off = 0;
      for (const int i : meeting) {
        const Primitive& primitive = surface_.primitives[static_cast<std::size_t>(i)];
        const osg::Vec3d along = primitive.normal(p);
        const Eigen::Vector3d normal(along.x(), along.y(), along.z());
        const double distance = primitive.distance(p);
        normals += normal * normal.transpose();
        pull += normal * distance;
        off = std::max(off, std::abs(distance));
      }
      const Eigen::Vector3d step = normals.inverse() * pull;
      p -= osg::Vec3d(step.x(), step.y(), step.z());
      if (!p.valid() || (p - start).length() > farthest) return std::nullopt;
    }
    if (off > 1e-6 * farthest) return std::nullopt;
    return p;
  }

  unsigned add_vertex(const osg::Vec3d& p, Mask mask) {
    surface_.vertices.emplace_back(p);
    masks_.push_back(mask);
    return static_cast<unsigned>(surface_.vertices.size() - 1);
  }

  void add(unsigned a, unsigned b, unsigned c) {
    Triangle t{{a, b, c}, {}, 0};
    if (a == b || b == c || c == a || !measure(surface_, t)) return;
    const osg::Vec3d middle = osg::Vec3d(surface_.vertices[a] + surface_.vertices[b] + surface_.vertices[c]) / 3.0;
    double best = kAligned;
    for (Mask left = masks_[a] & masks_[b] & masks_[c]; left != 0; left &= left - 1) {
      const int i = std::countr_zero(left);
      const double along =
          std::abs(surface_.primitives[static_cast<std::size_t>(i)].normal(middle) * osg::Vec3d(t.normal));
      if (along > best) t.primitive = i, best = along;
    }
    surface_.triangles.push_back(t);
  }

  Surface& surface_;
  std::vector<Mask> masks_;  // by vertex
  std::unordered_map<std::uint64_t, unsigned> between_;
};

}  // namespace

void sharpen(Surface& surface) { Sharpening(surface).run(); }

}  // namespace palp
