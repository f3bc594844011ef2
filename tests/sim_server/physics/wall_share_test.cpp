// Shares of the kernel in solids against quadrature over the solid, in double precision; layers so thin that their sum
// is the integral.
#include <gtest/gtest.h>

#include "sim_server/geometry/solid.h"
#include "sim_server/physics/smoothing.h"
#include "sim_server/physics/wall_share.h"
#include "sim_server/solver/contact_store.h"
#include "sim_server/solver/plan.h"
#include "tests/support/random_scene.h"
#include "tests/support/scene_builder.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::wall_share_test {
namespace {

using Eigen::Vector3d;
constexpr double kSpacing = 0.02;
constexpr double kSupports[] = {2.7 * kSpacing, 3 * kSpacing};  // of the quartic and the quintic spline
const Vector3d kPull(1.5, -2, -9.81);

struct Sums {
  double share = 0;
  Vector3d slope = Vector3d::Zero(), pull = Vector3d::Zero();
};

class Walls {
 public:
  Walls(const std::vector<ShapeConfig>& shapes, double support) : support_(support) {
    SceneConfig config = scene(kSpacing);
    config.numerics.support_over_spacing = support / kSpacing;
    BodyConfig subject = test::body("subject", BodyKind::rigid, shapes[0]);
    subject.shapes = shapes;
    config.bodies = {subject, test::body("fluid", BodyKind::fluid, box({0.06, 0.06, 0.06}, {0.9, 0.9, 0.9}))};
    solid_ = make_solid(shapes);
    scene_ = sample_scene(config, 1000000);
    store_.emplace(scene_, make_plan(scene_));
    grids_ = store_->grids_at(store_->node.data());
  }
  // x in the body frame.
  WallShare at(const Vector3d& x) const {
    const WallKernel kernel{FluidKernel::with_support(real(support_), real(kSpacing)), real(kSpacing / 16),
                            real(kSpacing / 4), real(0.01 * kSpacing), kPull.cast<real>()};
    return wall_share(store_->shape[0], store_->piece.data(), grids_.data(), kernel,
                      (x - scene_.bodies[0].center).cast<real>());
  }
  double distance(const Vector3d& x) const {
    return solid_distance(store_->shape[0], store_->piece.data(), grids_.data(),
                          (x - scene_.bodies[0].center).cast<real>())
        .d;
  }
  // By cells, those that the surface cuts by smaller ones.
  Sums quadrature(const Vector3d& x) const {
    constexpr int kCells = 12;
    const double cell = support_ / kCells;
    Sums sums;
    for (int i = -kCells; i < kCells; ++i)
      for (int j = -kCells; j < kCells; ++j)
        for (int k = -kCells; k < kCells; ++k) add(x, cell * Vector3d(i + 0.5, j + 0.5, k + 0.5), cell, 2, sums);
    return sums;
  }

 private:
  bool contains(const Vector3d& x) const { return solid_.contains(solid_.frame.inverse() * x); }
  void add(const Vector3d& x, const Vector3d& s, double cell, int halvings, Sums& sums) const {
    const auto W = FluidKernelOf<double>::with_support(support_, kSpacing);
    const double r = s.norm();
    if (r - cell > support_) return;
    if (halvings > 0 && std::abs(distance(x + s)) < cell) {
      for (int c = 0; c < 8; ++c)
        add(x, s + 0.25 * cell * Vector3d(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1), 0.5 * cell, halvings - 1,
            sums);
      return;
    }
    if (r >= support_ || !contains(x + s)) return;
    const double dV = cell * cell * cell;
    sums.share += W.W(r) * dV;
    sums.slope -= W.F(r) * dV * s;
    sums.pull += W.F(r) * dV * s.dot(kPull) * s;
  }

  double support_;  // [m]
  Solid solid_;
  Scene scene_;
  std::optional<ContactStore> store_;
  std::vector<NodeGrid> grids_;
};

// A solid, and the box (body frame) in which places beside it are drawn.
struct Case {
  const char* name;
  std::vector<ShapeConfig> shapes;
  Vector3d low, high;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

std::vector<Case> cases() {
  const double R = 3 * kSpacing;
  const ShapeConfig tray = box({0.8, 0.8, 0.5}, {0.2, 0.2, 0.05}), room = cut(box({0.6, 0.6, 0.5}, {0.3, 0.3, 0.25}));
  const ShapeConfig block = box({0.4, 0.4, 0.4}), bore = cut(cylinder(5 * kSpacing, 0.5));
  return {
      {"plane", {box({0.6, 0.6, 0.3}, {0, 0, -0.15})}, {-0.1, -0.1, 0}, {0.1, 0.1, 0.06}},
      {"edge", {box({0.6, 0.6, 0.3}, {0.3, 0, -0.15})}, {-0.06, -0.1, -0.06}, {0.06, 0.1, 0.06}},
      {"corner", {box({0.6, 0.6, 0.6}, {0.3, 0.3, -0.3})}, {-0.06, -0.06, -0.06}, {0.06, 0.06, 0.06}},
      {"tray's inner corner", {tray, room}, {0, 0, 0}, {0.08, 0.08, 0.08}},
      {"tray's rim", {box({0.8, 0.8, 0.3}, {0.2, 0.2, 0.05}), room}, {-0.06, 0.1, 0.14}, {0.06, 0.3, 0.26}},
      {"two boxes' seam",
       {box({0.3, 0.6, 0.3}, {-0.15, 0, -0.15}), box({0.3, 0.6, 0.3}, {0.15, 0, -0.15})},
       {-0.06, -0.1, 0},
       {0.06, 0.1, 0.06}},
      {"ball of 3 dx", {sphere(R)}, {-0.12, -0.12, -0.12}, {0.12, 0.12, 0.12}},
      {"ball of 1 dx", {sphere(kSpacing)}, {-0.08, -0.08, -0.08}, {0.08, 0.08, 0.08}},
      {"cylinder of 3 dx", {cylinder(R, 0.4)}, {-0.12, -0.12, -0.26}, {0.12, 0.12, 0.26}},
      {"cylinder of 1 dx", {cylinder(kSpacing, 0.4)}, {-0.08, -0.08, -0.26}, {0.08, 0.08, 0.26}},
      {"bore", {block, bore}, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}},
      {"bore's rim", {block, bore}, {-0.1, -0.1, 0.15}, {0.1, 0.1, 0.26}},
      {"cup's inside",
       {cylinder(0.2, 0.3), cut(cylinder(0.12, 0.3, {0, 0, 0.07}))},
       {-0.1, -0.1, -0.08},
       {0.1, 0.1, 0.0}},
      {"ball on a stick",
       {sphere(R), cylinder(0.6 * kSpacing, 0.3, {0, 0, 0.15})},
       {-0.12, -0.12, -0.1},
       {0.12, 0.12, 0.2}},
      {"cylinder on a plate",
       {box({0.6, 0.6, 0.3}, {0, 0, -0.15}), cylinder(R, 0.3, {0, 0, 0.15})},
       {-0.12, -0.12, 0},
       {0.12, 0.12, 0.08}},
  };
}

class WallShareOf : public RandomCase, public ::testing::WithParamInterface<Case> {};

TEST_P(WallShareOf, AgreesWithQuadrature) {
  const Case& of = GetParam();
  for (const double support : kSupports) {
    SCOPED_TRACE(support / kSpacing);
    const Walls walls(of.shapes, support);
    for (int n = 0; n < 30;) {
      Vector3d x;
      for (int a = 0; a < 3; ++a) x[a] = between(of.low[a], of.high[a]);
      const double d = walls.distance(x);
      if (d < 0.1 * kSpacing || d > support) continue;
      ++n;
      const WallShare found = walls.at(x);
      const Sums exact = walls.quadrature(x);
      EXPECT_TRUE(within(found.share - exact.share, tol::kWallShare)) << x.transpose();
      EXPECT_TRUE(within((found.slope.cast<double>() - exact.slope).norm() * support, tol::kWallSlope))
          << x.transpose();
      EXPECT_TRUE(within((found.pull.cast<double>() - exact.pull).norm() / kPull.norm(), tol::kWallPull))
          << x.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Solids, WallShareOf, ::testing::ValuesIn(cases()), [](const auto& one) {
  std::string name = one.param.name;
  for (char& letter : name)
    if (std::isalnum(static_cast<unsigned char>(letter)) == 0) letter = '_';
  return name;
});

// The shear is the slope over the distance, on either side of what is round.
TEST(WallShare, ShearsByTheSlopeOverTheDistance) {
  const double R = 5 * kSpacing;
  struct Face {
    const char* name;
    std::vector<ShapeConfig> shapes;
    Vector3d at, n;
  };
  const Face faces[] = {{"plane", {box({0.6, 0.6, 0.3}, {0, 0, -0.15})}, {0.01, 0.02, 0}, {0, 0, 1}},
                        {"cylinder", {cylinder(R, 0.4)}, {R, 0, 0.01}, {1, 0, 0}},
                        {"bore", {box({0.4, 0.4, 0.4}), cut(cylinder(R, 0.5))}, {R, 0, 0.01}, {-1, 0, 0}},
                        {"ball", {sphere(R)}, {R, 0, 0}, {1, 0, 0}},
                        {"hollow", {box({0.4, 0.4, 0.4}), cut(sphere(R))}, {R, 0, 0}, {-1, 0, 0}}};
  for (const Face& face : faces) {
    for (const double support : kSupports) {
      const Walls walls(face.shapes, support);
      for (double d = 0.3; d < support / kSpacing - 0.1; d += 0.3) {
        const WallShare found = walls.at(face.at + d * kSpacing * face.n);
        EXPECT_TRUE(within(found.shear * d * kSpacing / found.slope.norm() - 1, tol::kWallShear))
            << face.name << ", " << d << ", H = " << support / kSpacing << " dx";
      }
    }
  }
}

// Behind a wall all is wall, however thin it is.
TEST(WallShare, OfAThinWallIsThatOfAThickOne) {
  const double support = kSupports[0];
  const Walls thick({box({0.6, 0.6, 0.3}, {0, 0, -0.15})}, support),
      thin({box({0.6, 0.6, 0.0004}, {0, 0, -0.0002})}, support);
  for (double d = 0.05; d < 3; d += 0.1) {
    const Vector3d x(0.01, 0.02, d * kSpacing);
    EXPECT_TRUE(within(thin.at(x).share - thick.at(x).share, tol::kSameWall)) << d;
    EXPECT_TRUE(within((thin.at(x).slope - thick.at(x).slope).norm() * support, tol::kSameWall)) << d;
  }
}

}  // namespace
}  // namespace palp::test::wall_share_test
