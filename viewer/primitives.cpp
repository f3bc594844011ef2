#include "viewer/primitives.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>

#include <osg/BoundingBox>

namespace palp {
namespace {

using Vec = osg::Vec3d;
using Index = unsigned;

constexpr std::size_t kMostTested = 1500;  // vertices that a guess is judged by
constexpr int kGuesses = 150;              // of each kind and round
constexpr std::size_t kFewest = 8;         // vertices that make a primitive
constexpr std::size_t kMostPrimitives = 30;
constexpr std::size_t kMostNear = 120;  // vertices that a guess is made from
constexpr std::size_t kMostAxes = 8;
constexpr double kWidest = 3;  // radius over the size of the surface
constexpr double kLoose = 8;   // tolerances: guesses from few vertices are less exact than fits to all

Eigen::Vector3d to_eigen(const Vec& v) { return {v.x(), v.y(), v.z()}; }
Vec from_eigen(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

// Two directions across the axis.
std::pair<Vec, Vec> across(const Vec& axis) {
  Vec u = std::abs(axis.x()) < 0.6 ? axis ^ Vec(1, 0, 0) : axis ^ Vec(0, 1, 0);
  u.normalize();
  return {u, axis ^ u};
}

std::optional<Primitive> fit_plane(const std::vector<Vec>& points) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Vec& p : points) middle += to_eigen(p) / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec& p : points) spread += (to_eigen(p) - middle) * (to_eigen(p) - middle).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  // points on a line say nothing of the plane
  if (solver.eigenvalues()[1] < 1e-6 * solver.eigenvalues()[2]) return std::nullopt;
  return Primitive{Primitive::Kind::plane, from_eigen(middle), from_eigen(solver.eigenvectors().col(0)), 0};
}

// |p|^2 = 2 c p + k is linear in the centre c and k = r^2 - |c|^2.
template <int N>
std::optional<std::pair<Eigen::Matrix<double, N, 1>, double>> fit_ball(
    const std::vector<Eigen::Matrix<double, N, 1>>& points) {
  using Row = Eigen::Matrix<double, N + 1, 1>;
  Eigen::Matrix<double, N, 1> middle = Eigen::Matrix<double, N, 1>::Zero();
  for (const auto& p : points) middle += p / static_cast<double>(points.size());
  Eigen::Matrix<double, N + 1, N + 1> a = Eigen::Matrix<double, N + 1, N + 1>::Zero();
  Row b = Row::Zero();
  for (const auto& p : points) {
    Row row;
    row << 2 * (p - middle), 1;
    a += row * row.transpose();
    b += row * (p - middle).squaredNorm();
  }
  const Row x = a.ldlt().solve(b);
  const double radius2 = x[N] + x.template head<N>().squaredNorm();
  if (!x.allFinite() || !(radius2 > 0)) return std::nullopt;
  return std::pair{Eigen::Matrix<double, N, 1>(x.template head<N>() + middle), std::sqrt(radius2)};
}

std::optional<Primitive> fit_sphere(const std::vector<Vec>& points) {
  std::vector<Eigen::Vector3d> p(points.size());
  std::ranges::transform(points, p.begin(), to_eigen);
  const auto ball = fit_ball<3>(p);
  if (!ball) return std::nullopt;
  return Primitive{Primitive::Kind::sphere, from_eigen(ball->first), {}, ball->second};
}

std::optional<Primitive> fit_cylinder(const std::vector<Vec>& points, const Vec& axis) {
  const auto [u, v] = across(axis);
  std::vector<Eigen::Vector2d> p;
  for (const Vec& x : points) p.emplace_back(x * u, x * v);
  const auto circle = fit_ball<2>(p);
  if (!circle) return std::nullopt;
  return Primitive{Primitive::Kind::cylinder, u * circle->first.x() + v * circle->first.y(), axis, circle->second};
}

std::optional<Primitive> fit_again(const Primitive& primitive, const std::vector<Vec>& points) {
  switch (primitive.kind) {
    case Primitive::Kind::plane:
      return fit_plane(points);
    case Primitive::Kind::sphere:
      return fit_sphere(points);
    default:
      return fit_cylinder(points, primitive.axis);
  }
}

class Search {
 public:
  Search(std::span<const osg::Vec3f> vertices, std::span<const std::array<Index, 3>> triangles, double tolerance)
      : triangles_(triangles), tolerance_(tolerance), first_(vertices.size() + 1), free_(vertices.size(), true) {
    osg::BoundingBoxd box;
    for (const osg::Vec3f& v : vertices) {
      points_.emplace_back(v);
      box.expandBy(points_.back());
    }
    size_ = box.radius();
    for (const auto& t : triangles)
      for (const Index v : t) first_[v + 1] += 2;
    for (std::size_t v = 0; v + 1 < first_.size(); ++v) first_[v + 1] += first_[v];
    around_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (const auto& t : triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        around_[next[t[k]]++] = t[(k + 1) % 3];
        around_[next[t[k]]++] = t[(k + 2) % 3];
      }
    }
  }

  std::vector<Primitive> run() {
    std::vector<Primitive> found;
    while (found.size() < kMostPrimitives) {
      const std::vector<Index> tested = choose_tested();
      if (tested.size() < kFewest) break;
      const std::optional<Primitive> best = best_guess(tested);
      if (!best) break;
      for (std::size_t i = 0; i < points_.size(); ++i)
        if (std::abs(best->distance(points_[i])) < tolerance_) free_[i] = false;
      found.push_back(*best);
    }
    return found;
  }

 private:
  std::vector<Index> choose_tested() const {
    std::vector<Index> all;
    for (Index i = 0; i < points_.size(); ++i)
      if (free_[i]) all.push_back(i);
    const std::size_t stride = all.size() / kMostTested + 1;
    std::vector<Index> tested;
    for (std::size_t i = 0; i < all.size(); i += stride) tested.push_back(all[i]);
    return tested;
  }

  std::size_t support(const Primitive& p, const std::vector<Index>& of, double tolerance) const {
    return static_cast<std::size_t>(
        std::ranges::count_if(of, [&](Index i) { return std::abs(p.distance(points_[i])) < tolerance; }));
  }

  // Free vertices about this one, along the surface.
  std::vector<Vec> near(Index from) {
    std::vector<Index> reached{from};
    mark_.resize(points_.size());
    ++marked_;
    mark_[from] = marked_;
    for (std::size_t at = 0; at < reached.size() && reached.size() < kMostNear; ++at) {
      for (std::size_t k = first_[reached[at]]; k < first_[reached[at] + 1]; ++k) {
        const Index next = around_[k];
        if (mark_[next] == marked_ || !free_[next]) continue;
        mark_[next] = marked_;
        reached.push_back(next);
      }
    }
    std::vector<Vec> out;
    for (const Index i : reached) out.push_back(points_[i]);
    return out;
  }

  std::vector<Vec> draw(const std::vector<Vec>& from, std::size_t count) {
    std::vector<Vec> out;
    for (std::size_t i = 0; i < count; ++i) out.push_back(from[random_() % from.size()]);
    return out;
  }

  std::vector<Primitive> guess_planes() {
    std::vector<Primitive> guesses;
    for (int i = 0; i < kGuesses; ++i) {
      const auto& t = triangles_[random_() % triangles_.size()];
      if (!free_[t[0]] && !free_[t[1]] && !free_[t[2]]) continue;
      Vec normal = (points_[t[1]] - points_[t[0]]) ^ (points_[t[2]] - points_[t[0]]);
      const double length = (points_[t[1]] - points_[t[0]]).length() * (points_[t[2]] - points_[t[0]]).length();
      // the normal of a sliver is not exact
      if (normal.normalize() < 0.2 * length) continue;
      guesses.push_back({Primitive::Kind::plane, points_[t[0]], normal, 0});
    }
    return guesses;
  }

  std::optional<Primitive> best_guess(const std::vector<Index>& tested) {
    std::vector<Primitive> guesses = guess_planes();
    std::vector<std::pair<std::size_t, std::size_t>> best_planes;
    for (std::size_t i = 0; i < guesses.size(); ++i)
      best_planes.emplace_back(support(guesses[i], tested, kLoose * tolerance_), i);
    std::ranges::sort(best_planes, std::greater());
    for (const auto& [count, i] : best_planes) add_axis(guesses[i].axis);
    for (int i = 0; i < kGuesses; ++i) {
      const std::vector<Vec> about = near(tested[random_() % tested.size()]);
      if (about.size() < kFewest) continue;
      if (const auto sphere = fit_sphere(draw(about, 4))) guesses.push_back(*sphere);
      for (const Vec& axis : axes_)
        if (const auto cylinder = fit_cylinder(draw(about, 3), axis)) guesses.push_back(*cylinder);
    }
    std::optional<Primitive> best;
    std::size_t best_support = kFewest - 1;
    for (const Primitive& guess : guesses) {
      if (guess.radius > kWidest * size_) continue;  // nearly a plane
      if (support(guess, tested, kLoose * tolerance_) <= best_support) continue;
      const std::optional<Primitive> fitted = refine(guess, tested);
      if (!fitted) continue;
      const std::size_t count = support(*fitted, tested, tolerance_);
      if (count <= best_support) continue;
      best = fitted;
      best_support = count;
    }
    return best;
  }

  std::optional<Primitive> refine(Primitive guess, const std::vector<Index>& tested) const {
    for (const double loose : {kLoose, 2.0}) {
      std::vector<Vec> on;
      for (const Index i : tested)
        if (std::abs(guess.distance(points_[i])) < loose * tolerance_) on.push_back(points_[i]);
      if (on.size() < kFewest) return std::nullopt;
      const auto fitted = fit_again(guess, on);
      if (!fitted) return std::nullopt;
      guess = *fitted;
    }
    return guess;
  }

  // Cylinders end in planes across their axes, or lie along the frame's.
  void add_axis(const Vec& axis) {
    if (axes_.size() >= kMostAxes) return;
    for (const Vec& other : axes_)
      if (std::abs(axis * other) > 1 - 1e-8) return;
    axes_.push_back(axis);
  }

  std::span<const std::array<Index, 3>> triangles_;
  double tolerance_;
  double size_ = 0;
  std::vector<Vec> points_;
  std::vector<std::size_t> first_;  // by vertex, of around_
  std::vector<Index> around_;
  std::vector<bool> free_;  // on no primitive yet
  std::vector<Index> mark_;
  Index marked_ = 0;
  std::vector<Vec> axes_{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::mt19937 random_;  // of its default seed
};

}  // namespace

double Primitive::distance(const osg::Vec3d& p) const {
  const osg::Vec3d from = p - origin;
  if (kind == Kind::plane) return from * axis;
  if (kind == Kind::sphere) return from.length() - radius;
  return (from - axis * (from * axis)).length() - radius;
}

osg::Vec3d Primitive::normal(const osg::Vec3d& p) const {
  if (kind == Kind::plane) return axis;
  osg::Vec3d out = p - origin;
  if (kind == Kind::cylinder) out -= axis * (out * axis);
  out.normalize();
  return out;
}

std::vector<Primitive> find_primitives(std::span<const osg::Vec3f> vertices,
                                       std::span<const std::array<unsigned, 3>> triangles, double tolerance) {
  if (vertices.size() < kFewest || triangles.empty()) return {};
  return Search(vertices, triangles, tolerance).run();
}

}  // namespace palp
