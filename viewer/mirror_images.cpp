#include "viewer/mirror_images.h"

#include <algorithm>
#include <cmath>

namespace palp {
namespace {

// Lengths in particle spacings. A medium's first layer lies half a spacing off a wall.
constexpr float kTouching = 0.8f;
constexpr float kThickness = 1.3f;  // that a wall must have to hold an image and half a spacing around it
constexpr std::size_t kMostTriangles = 20'000;
constexpr std::size_t kMostListed = 4'000'000;
constexpr float kMostCells = 128;      // along each axis
constexpr float kBeside = 0.1f;        // a face: facets of a round wall leave gaps between what stands on them
constexpr float kSameFace = 0.9f;      // the cosine between normals from which two facets are one wall
constexpr float kMostOblique = 0.35f;  // the cosine between normals up to which two walls have an image in their edge

}  // namespace

MirrorImages::MirrorImages(std::span<const osg::ref_ptr<osg::Geometry>> parts, double spacing)
    : spacing_(static_cast<float>(spacing)) {
  for (const auto& part : parts) {
    if (!part) continue;
    const Surface surface = surface_of(*part);
    if (faces_.size() + surface.triangles.size() > kMostTriangles) {
      faces_.clear();
      return;
    }
    for (const Triangle& t : surface.triangles) {
      const osg::Vec3f a = surface.vertices[t.corner[0]];
      const osg::Vec3f u = surface.vertices[t.corner[1]] - a, v = surface.vertices[t.corner[2]] - a;
      const float uu = u * u, uv = u * v, vv = v * v, area2 = uu * vv - uv * uv;
      if (!(area2 > 0)) continue;
      const osg::Vec3f p = (u * vv - v * uv) / area2, q = (v * uu - u * uv) / area2;
      const float beside = kBeside * spacing_;
      faces_.push_back(
          {a, {u, v}, t.normal, {p, q}, {beside * p.length(), beside * q.length(), beside * (p + q).length()}});
    }
  }
  sort_into_cells();
}

// Returns whether a place lies above or below the face. way: to it from the face's corner.
bool MirrorImages::holds(const Face& face, const osg::Vec3f& way) {
  const float a = way * face.shares[0], b = way * face.shares[1];
  return a >= -face.slack[0] && b >= -face.slack[1] && a + b <= 1 + face.slack[2];
}

// Each cell lists the faces that may matter to a particle in it: those that it touches, and those behind them.
void MirrorImages::sort_into_cells() {
  osg::BoundingBox box;
  for (const Face& face : faces_)
    for (const osg::Vec3f& to : {osg::Vec3f(), face.edge[0], face.edge[1]}) box.expandBy(face.corner + to);
  if (!box.valid() || !std::isfinite(box.radius())) return;
  const float touching = kTouching * spacing_, reach = touching + kThickness * spacing_;
  const osg::Vec3f margin(touching, touching, touching);
  box = {box._min - margin, box._max + margin};
  const osg::Vec3f size = box._max - box._min;
  const float cell = std::max(spacing_, std::max({size.x(), size.y(), size.z()}) / kMostCells);
  per_metre_ = 1 / cell;
  for (int k = 0; k < 3; ++k)
    cells_[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(size[k] * per_metre_) + 1;
  const float half = 0.5f * cell, around = reach + half * std::sqrt(3.0f);
  const osg::Vec3f away(reach, reach, reach);
  // calls f(cell) for those whose middle is near enough to the face's box and plane
  const auto each_cell = [&](const Face& face, auto&& f) {
    osg::BoundingBox near;
    for (const osg::Vec3f& to : {osg::Vec3f(), face.edge[0], face.edge[1]}) near.expandBy(face.corner + to);
    std::array<std::uint32_t, 3> from{}, to{};
    for (int k = 0; k < 3; ++k) {
      const auto at = [&](float x) {
        const float most = static_cast<float>(cells_[static_cast<std::size_t>(k)] - 1);
        return static_cast<std::uint32_t>(std::clamp((x - box._min[k]) * per_metre_, 0.0f, most));
      };
      from[static_cast<std::size_t>(k)] = at(near._min[k] - reach);
      to[static_cast<std::size_t>(k)] = at(near._max[k] + reach);
    }
    for (std::uint32_t z = from[2]; z <= to[2]; ++z)
      for (std::uint32_t y = from[1]; y <= to[1]; ++y)
        for (std::uint32_t x = from[0]; x <= to[0]; ++x) {
          const osg::Vec3f middle = box._min + osg::Vec3f(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f,
                                                          static_cast<float>(z) + 0.5f) *
                                                   cell;
          if (std::abs(face.normal * (middle - face.corner)) <= around) f((z * cells_[1] + y) * cells_[0] + x);
        }
  };
  first_.assign(std::size_t{cells_[0]} * cells_[1] * cells_[2] + 1, 0);
  for (const Face& face : faces_) each_cell(face, [&](std::size_t c) { ++first_[c + 1]; });
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  if (first_.back() > kMostListed) return;
  list_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t i = 0; i < faces_.size(); ++i) each_cell(faces_[i], [&](std::size_t c) { list_[next[c]++] = i; });
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
    if (facing > -0.1f) continue;
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
    if (is_thick(face, x - face.normal * height, candidates)) out[count++] = {face.normal, height};
  }
  return count;
}

void MirrorImages::add_of(const osg::Vec3f& x, std::vector<osg::Vec3f>& images) const {
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
}

}  // namespace palp
