#include "viewer/mirror_images.h"

#include <algorithm>
#include <cmath>

namespace palp {
namespace {

// Lengths in particle spacings. A medium's first layer lies half a spacing off a wall.
constexpr float kTouching = 0.8f;
constexpr float kThickness = 1.3f;  // that a wall must have to hold an image and half a spacing around it
constexpr std::size_t kMostTriangles = 20'000;
constexpr std::size_t kMostWork = 20'000'000;  // cells that may list a face, of all faces
constexpr float kMostCells = 128;              // along each axis
constexpr float kBeside = 0.1f;                // a face: facets of a round wall leave gaps between what stands on them
constexpr float kSameFace = 0.9f;              // the cosine between normals from which two facets are one wall
constexpr float kFacing = 0.1f;                // the cosine between a wall and what may be its other side, at least
constexpr float kMostOblique = 0.35f;  // the cosine between normals up to which two walls have an image in their edge

}  // namespace

MirrorImages::MirrorImages(const osg::Geometry* solid, const osg::Geometry* shell, double spacing)
    : spacing_(static_cast<float>(spacing)) {
  if (add_faces(solid, shell != nullptr) && add_faces(shell, false))
    sort_into_cells();
  else
    faces_.clear();
}

// Returns false where there are too many.
bool MirrorImages::add_faces(const osg::Geometry* part, bool in_hollow) {
  if (part == nullptr) return true;
  const Surface surface = surface_of(*part);
  if (faces_.size() + surface.triangles.size() > kMostTriangles) return false;
  for (const Triangle& t : surface.triangles) {
    const osg::Vec3f a = surface.vertices[t.corner[0]];
    const osg::Vec3f u = surface.vertices[t.corner[1]] - a, v = surface.vertices[t.corner[2]] - a;
    const float uu = u * u, uv = u * v, vv = v * v, area2 = uu * vv - uv * uv;
    if (!(area2 > 0)) continue;
    const osg::Vec3f p = (u * vv - v * uv) / area2, q = (v * uu - u * uv) / area2;
    const float beside = kBeside * spacing_;
    faces_.push_back({a,
                      {u, v},
                      t.normal,
                      {p, q},
                      {beside * p.length(), beside * q.length(), beside * (p + q).length()},
                      in_hollow});
  }
  return true;
}

// Returns whether a place lies above or below the face. way: to it from the face's corner.
bool MirrorImages::holds(const Face& face, const osg::Vec3f& way) {
  const float a = way * face.shares[0], b = way * face.shares[1];
  return a >= -face.slack[0] && b >= -face.slack[1] && a + b <= 1 + face.slack[2];
}

// The lattice of cells around all faces, while it is filled.
struct MirrorImages::Lattice {
  osg::Vec3f low;
  float cell;                          // [m]
  float reach;                         // of a face that may matter to a particle [m]
  std::array<std::uint32_t, 3> cells;  // along each axis

  struct Range {
    std::array<std::uint32_t, 3> from, to;  // both within
    std::size_t count() const {
      std::size_t n = 1;
      for (std::size_t k = 0; k < 3; ++k) n *= to[k] - from[k] + 1;
      return n;
    }
  };

  // The cells that the box around the face and its reach has.
  Range range_of(const Face& face) const {
    osg::BoundingBox box;
    for (const osg::Vec3f& to : {osg::Vec3f(), face.edge[0], face.edge[1]}) box.expandBy(face.corner + to);
    Range range{};
    for (int k = 0; k < 3; ++k) {
      const auto axis = static_cast<std::size_t>(k);
      const auto at = [&](float x) {
        return static_cast<std::uint32_t>(std::clamp((x - low[k]) / cell, 0.0f, static_cast<float>(cells[axis] - 1)));
      };
      range.from[axis] = at(box._min[k] - reach);
      range.to[axis] = at(box._max[k] + reach);
    }
    return range;
  }

  // Calls f(number) for those of the range in which the face's plane may matter.
  template <class F>
  void each(const Face& face, F&& f) const {
    const Range range = range_of(face);
    const float around = reach + 0.5f * std::sqrt(3.0f) * cell;
    for (std::uint32_t z = range.from[2]; z <= range.to[2]; ++z)
      for (std::uint32_t y = range.from[1]; y <= range.to[1]; ++y)
        for (std::uint32_t x = range.from[0]; x <= range.to[0]; ++x) {
          const osg::Vec3f at(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
          const osg::Vec3f middle = low + (at + osg::Vec3f(0.5f, 0.5f, 0.5f)) * cell;
          if (std::abs(face.normal * (middle - face.corner)) <= around) f((z * cells[1] + y) * cells[0] + x);
        }
  }
};

// Each cell lists the faces that may matter to a particle in it: those that it touches, and those behind them.
void MirrorImages::sort_into_cells() {
  osg::BoundingBox box;
  for (const Face& face : faces_)
    for (const osg::Vec3f& to : {osg::Vec3f(), face.edge[0], face.edge[1]}) box.expandBy(face.corner + to);
  if (!box.valid() || !std::isfinite(box.radius())) return;
  const float touching = kTouching * spacing_;
  const osg::Vec3f margin(touching, touching, touching);
  box = {box._min - margin, box._max + margin};
  const osg::Vec3f size = box._max - box._min;
  const float cell = std::max(spacing_, std::max({size.x(), size.y(), size.z()}) / kMostCells);
  Lattice lattice{box._min, cell, touching + kThickness * spacing_, {}};
  for (int k = 0; k < 3; ++k)
    lattice.cells[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(size[k] / cell) + 1;
  std::size_t work = 0;
  for (const Face& face : faces_) work += lattice.range_of(face).count();
  if (work > kMostWork) return;
  first_.assign(std::size_t{lattice.cells[0]} * lattice.cells[1] * lattice.cells[2] + 1, 0);
  for (const Face& face : faces_) lattice.each(face, [&](std::size_t c) { ++first_[c + 1]; });
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  list_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t i = 0; i < faces_.size(); ++i)
    lattice.each(faces_[i], [&](std::size_t c) { list_[next[c]++] = i; });
  per_metre_ = 1 / cell;
  cells_ = lattice.cells;
  box_ = box;
}

std::span<const std::uint32_t> MirrorImages::near(const osg::Vec3f& x) const {
  if (!box_.contains(x)) return {};
  std::array<std::size_t, 3> at{};
  for (int k = 0; k < 3; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    at[axis] = std::min<std::size_t>(static_cast<std::size_t>((x[k] - box_._min[k]) * per_metre_), cells_[axis] - 1);
  }
  const std::size_t cell = (at[2] * cells_[1] + at[1]) * cells_[0] + at[0];
  return {list_.data() + first_[cell], first_[cell + 1] - first_[cell]};
}

// Returns whether no other side of the solid comes too soon behind that place of the face.
bool MirrorImages::is_thick(const Face& face, const osg::Vec3f& foot, std::span<const std::uint32_t> near) const {
  for (const std::uint32_t i : near) {
    const Face& other = faces_[i];
    const float facing = other.normal * face.normal;
    if (facing > -kFacing) continue;
    const float depth = (other.normal * (foot - other.corner)) / facing;
    if (!(depth > 0) || depth > kThickness * spacing_) continue;
    if (holds(other, foot - face.normal * depth - other.corner)) return false;
  }
  return true;
}

// The faces that a particle stands on, no two of the same wall.
std::size_t MirrorImages::touched_by(const osg::Vec3f& x, std::array<Touched, 3>& out) const {
  const std::span<const std::uint32_t> candidates = near(x);
  std::size_t count = 0;
  for (const std::uint32_t i : candidates) {
    const Face& face = faces_[i];
    const osg::Vec3f way = x - face.corner;
    const float height = face.normal * way;
    if (!(height > 0) || height > kTouching * spacing_) continue;
    if (!holds(face, way)) continue;
    const auto known = std::find_if(out.begin(), out.begin() + count,
                                    [&](const Touched& t) { return t.normal * face.normal > kSameFace; });
    if (known != out.begin() + count || count == out.size()) continue;
    if (face.in_hollow || is_thick(face, x - face.normal * height, candidates))
      out[count++] = {face.normal, height, face.in_hollow};
  }
  return count;
}

bool MirrorImages::add_of(const osg::Vec3f& x, std::vector<osg::Vec3f>& images) const {
  std::array<Touched, 3> walls;
  const std::size_t count = touched_by(x, walls);
  for (unsigned in = 1; in < 1u << count; ++in) {  // the walls of one image, a bit each
    osg::Vec3f image = x;
    bool square = true;
    for (std::size_t k = 0; k < count; ++k) {
      if ((in >> k & 1u) == 0) continue;
      for (std::size_t l = 0; l < k; ++l)
        if ((in >> l & 1u) != 0) square = square && std::abs(walls[k].normal * walls[l].normal) <= kMostOblique;
      image -= walls[k].normal * (2 * walls[k].height);
    }
    if (square) images.push_back(image);
  }
  return std::any_of(walls.begin(), walls.begin() + count, [](const Touched& wall) { return wall.in_hollow; });
}

}  // namespace palp
