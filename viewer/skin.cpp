#include "viewer/skin.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "viewer/cells.h"

namespace palp {
namespace {

// How far from a vertex the particles are that it follows, in spacings: the corner of a block has ten, the middle of a
// face some thirty.
constexpr double kFollowed = 2.4;
// Least over largest eigenvalue of a vertex's moments, lengths in spacings: less, and its particles lie in a plane.
constexpr double kLeastSpread = 1e-4;
// How far apart particles are next to each other at rest, in spacings, and by how much such a pair is stretched when it
// is torn: far more than what a hand gives jelly, less than a gap that a particle fits into.
constexpr double kNextTo = 1.3, kTornStretch = 1.75;
constexpr int kBareRings = 2;  // of particles around a tear: the surface ends so far from it at least
// The share in a vertex of the particles that lie right beneath it: these alone are bare where the surface ends, since
// those farther on would stick out of what is left of it.
constexpr float kBeneath = 0.1f;

}  // namespace

std::optional<Skin> Skin::bind(std::span<const osg::Vec3f> vertices, std::span<const float> rest, double spacing) {
  const std::size_t count = rest.size() / 3;
  if (!(spacing > 0) || count > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  Skin skin;
  skin.torn_.assign(count, 0);
  skin.bare_ = skin.reached_ = skin.torn_;
  skin.ends_.assign(vertices.size(), 0);
  const Cells cells(rest, kFollowed * spacing);
  std::vector<std::pair<std::uint32_t, double>> found;  // particles of a vertex, and how much each counts
  skin.first_.push_back(0);
  for (const osg::Vec3f& vertex : vertices) {
    const Eigen::Vector3d X(vertex.x(), vertex.y(), vertex.z());
    const auto basis = [&](std::size_t j) {
      Eigen::Vector4d p;
      p << 1, (cells.place(j) - X) / spacing;
      return p;
    };
    Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
    found.clear();
    cells.around(X, [&](std::size_t j) {
      const Eigen::Vector4d p = basis(j);
      const double near = 1 - p.tail<3>().squaredNorm() / (kFollowed * kFollowed);
      if (!(near > 0)) return;
      found.emplace_back(static_cast<std::uint32_t>(j), near * near);
      moments += near * near * p * p.transpose();
    });
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> spread(moments);
    if (!(spread.eigenvalues()[0] > kLeastSpread * spread.eigenvalues()[3])) return std::nullopt;
    // the first column of the moments' inverse
    const Eigen::Vector4d of_X =
        spread.eigenvectors() * spread.eigenvectors().row(0).transpose().cwiseQuotient(spread.eigenvalues());
    for (const auto& [j, counts] : found) skin.weights_.push_back({j, static_cast<float>(counts * basis(j).dot(of_X))});
    skin.first_.push_back(static_cast<std::uint32_t>(skin.weights_.size()));
  }
  for (std::size_t i = 0; i < count; ++i) {
    cells.around(cells.place(i), [&](std::size_t j) {
      const double apart = (cells.place(j) - cells.place(i)).norm();
      if (j <= i || !(apart < kNextTo * spacing)) return;
      const double longest = kTornStretch * std::max(apart, 0.5 * spacing);
      skin.edges_.push_back(
          {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), static_cast<float>(longest * longest)});
    });
  }
  return skin;
}

bool Skin::find_tears(std::span<const float> places) {
  const auto place = [&](std::uint32_t i) {
    const float* p = places.data() + std::size_t{3} * i;
    return osg::Vec3f(p[0], p[1], p[2]);
  };
  std::ranges::fill(torn_, 0);
  bool whole = true;
  for (const Edge& e : edges_) {
    if ((place(e.b) - place(e.a)).length2() <= e.longest2) continue;  // what is no place is torn
    torn_[e.a] = torn_[e.b] = 1;
    whole = false;
  }
  bare_ = torn_;
  std::ranges::fill(ends_, 0);
  if (whole) return true;
  for (int ring = 0; ring < kBareRings; ++ring) spread_bareness();
  for (std::size_t v = 0; v < ends_.size(); ++v) {
    const std::span<const Weight> around(weights_.data() + first_[v], first_[v + 1] - first_[v]);
    ends_[v] = std::ranges::any_of(around, [&](const Weight& w) { return torn_[w.particle] != 0; });
    if (ends_[v] == 0) continue;
    for (const Weight& w : around)
      if (w.share > kBeneath) bare_[w.particle] = 1;
  }
  return false;
}

void Skin::spread_bareness() {
  reached_ = bare_;
  for (const Edge& e : edges_) {
    if (bare_[e.a] != 0) reached_[e.b] = 1;
    if (bare_[e.b] != 0) reached_[e.a] = 1;
  }
  bare_.swap(reached_);
}

void Skin::carry(std::span<const float> places, std::span<osg::Vec3f> vertices) const {
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    osg::Vec3f x(0, 0, 0);
    for (std::uint32_t k = first_[v]; k < first_[v + 1]; ++k) {
      const float* p = places.data() + std::size_t{3} * weights_[k].particle;
      x += osg::Vec3f(p[0], p[1], p[2]) * weights_[k].share;
    }
    vertices[v] = x;
  }
}

}  // namespace palp
