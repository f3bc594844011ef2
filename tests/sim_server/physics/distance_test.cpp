// Signed distances of solids against their definition: the nearest point of the surface, by every triangle or by a
// formula of its own.
#include <gtest/gtest.h>

#include "sim_server/geometry/contact_shape.h"
#include "sim_server/solver/contact_store.h"
#include "sim_server/solver/plan.h"
#include "tests/sim_server/geometry/mesh_shape.h"
#include "tests/support/random_scene.h"
#include "tests/support/scene_builder.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::distance_test {
namespace {

using Eigen::Vector3d;
// The contact kernels' view of one body, its frame off its centre of mass.
class Field {
 public:
  explicit Field(const std::vector<ShapeConfig>& shapes, double spacing = 0.02) {
    SceneConfig config = scene(spacing);
    BodyConfig subject = test::body("subject", BodyKind::rigid, shapes[0]);
    subject.shapes = shapes;
    config.bodies = {subject, test::body("other", BodyKind::fixed, box({0.05, 0.05, 0.05}, {0.9, 0.9, 0.9}))};
    scene_ = sample_scene(config, 1000000);
    store_.emplace(scene_, make_plan(scene_));
    grids_ = store_->grids_at(store_->node.data());
  }
  // x and the normal in the body frame.
  Distance at(const Vector3d& x) const {
    return solid_distance(store_->shape[0], store_->piece.data(), grids_.data(),
                          (x - scene_.bodies[0].center).cast<real>());
  }
  const Body& body() const { return scene_.bodies[0]; }
  const ContactBody& shape() const { return store_->shape[0]; }
  const std::vector<ContactPoint>& points() const { return body().contact->points; }

 private:
  Scene scene_;
  std::optional<ContactStore> store_;
  std::vector<NodeGrid> grids_;
};

double to_segment(const Vector3d& x, const Vector3d& a, const Vector3d& b) {
  const double t = std::clamp((x - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (a + t * (b - a) - x).norm();
}

double to_surface(const Vector3d& x, const SurfaceMesh& mesh) {
  double best = 1e30;
  for (const auto& t : mesh.triangles) {
    const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vector3d n = (b - a).cross(c - a).normalized(), foot = x - n.dot(x - a) * n;
    const bool over = n.dot((b - a).cross(foot - a)) >= 0 && n.dot((c - b).cross(foot - b)) >= 0 &&
                      n.dot((a - c).cross(foot - c)) >= 0;
    if (over) best = std::min(best, (foot - x).norm());
    best = std::min({best, to_segment(x, a, b), to_segment(x, b, c), to_segment(x, c, a)});
  }
  return best;
}

class DistanceTest : public RandomCase {
 protected:
  // The distance against the surface's triangles; a step along the normal by the distance ends on the surface.
  void expect_exact(const Field& field, const Solid& solid, double reach) {
    for (int round = 0; round < 2000; ++round) {
      const Vector3d x = random_vector(random_, reach);
      const bool inside = solid.contains(solid.frame.inverse() * x);
      const double expected = (inside ? -1 : 1) * to_surface(x, field.body().surface);
      const Distance found = field.at(x);
      ASSERT_TRUE(within(found.d - expected, tol::kDistance)) << x.transpose();
      EXPECT_TRUE(within(found.n.norm() - 1, tol::kRotation));
      const Vector3d foot = x - found.d * found.n.cast<double>();
      EXPECT_TRUE(within(to_surface(foot, field.body().surface), tol::kDistance)) << x.transpose();
    }
  }
};

TEST_F(DistanceTest, OfABox) {
  ShapeConfig turned = box({0.3, 0.2, 0.5}, {0.1, -0.2, 0.05});
  turned.orientation = random_rotation(random_);
  const Field field({turned});
  expect_exact(field, make_solid({turned}), 0.5);
}

// Floor and walls, inside and outside, and right across the seams between them.
TEST_F(DistanceTest, OfATray) {
  ShapeConfig hollow = box({0.5, 0.4, 0.3}, {0, 0, 0.05});
  hollow.subtract = true;
  const std::vector<ShapeConfig> tray{box({0.6, 0.5, 0.3}), hollow};
  expect_exact(Field(tray), make_solid(tray), 0.5);
  const std::vector<ShapeConfig> abutting{box({0.2, 0.4, 0.1}, {-0.1, 0, 0}), box({0.2, 0.4, 0.1}, {0.1, 0, 0})};
  const Field field(abutting);
  expect_exact(field, make_solid(abutting), 0.3);
  for (const double x : {-1e-3, -1e-5, 0.0, 1e-6, 1e-3}) {
    const Distance under = field.at({x, 0.1, 0.049});
    EXPECT_TRUE(within(under.d + 0.001, tol::kDistance));
    EXPECT_EQ(under.n, Vec3(0, 0, 1));
  }
}

// The balls at edges and corners, which touch other solids, are within the walls, however thin these are.
TEST_F(DistanceTest, OfContactPointsOfThinWalls) {
  for (const double wall : {0.001, 0.003, 0.01, 0.05}) {
    ShapeConfig hollow = box({0.5, 0.4, 0.3}, {0, 0, wall});
    hollow.subtract = true;
    const Field field({box({0.5 + 2 * wall, 0.4 + 2 * wall, 0.3}), hollow});
    ASSERT_FALSE(field.points().empty());
    for (const ContactPoint& p : field.points())
      EXPECT_LT(field.at(p.position).d, -p.radius + 1e-6) << p.position.transpose() << ", wall " << wall;
  }
}

TEST_F(DistanceTest, OfRoundSolids) {
  ShapeConfig cylinder = box(Vector3d::Zero(), {0.05, 0, -0.1});
  cylinder.type = ShapeType::cylinder;
  cylinder.radius = 0.2;
  cylinder.height = 0.3;
  cylinder.orientation = random_rotation(random_);
  const Field round({sphere(0.25, {0.1, 0.05, 0})}), can({cylinder});
  for (int k = 0; k < 2000; ++k) {
    const Vector3d x = random_vector(random_, 0.5);
    const Vector3d from = x - Vector3d(0.1, 0.05, 0);
    EXPECT_TRUE(within(round.at(x).d - (from.norm() - 0.25), tol::kDistance));
    EXPECT_TRUE(within((round.at(x).n.cast<double>() - from.normalized()).norm(), tol::kRotation));
    // a cylinder, looked at in the half plane of its axis and the point, is a rectangle
    const Vector3d y = cylinder.orientation.conjugate() * (x - cylinder.position);
    const Eigen::Vector2d q(std::hypot(y.x(), y.y()) - 0.2, std::abs(y.z()) - 0.15);
    const double expected = q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
    EXPECT_TRUE(within(can.at(x).d - expected, tol::kDistance));
    const double h = 1e-5;
    Vector3d slope;
    const auto signed_distance = [&](const Vector3d& p) {
      const Vector3d r = cylinder.orientation.conjugate() * (p - cylinder.position);
      const Eigen::Vector2d s(std::hypot(r.x(), r.y()) - 0.2, std::abs(r.z()) - 0.15);
      return s.cwiseMax(0).norm() + std::min(0.0, s.maxCoeff());
    };
    for (int a = 0; a < 3; ++a)
      slope[a] = (signed_distance(x + h * Vector3d::Unit(a)) - signed_distance(x - h * Vector3d::Unit(a))) / (2 * h);
    if (std::abs(slope.norm() - 1) < 1e-6) {
      EXPECT_LT((can.at(x).n.cast<double>() - slope).norm(), 1e-3) << x.transpose();
    }
  }
}

// A ball with a hole and a flat side: exact where one surface is nearest.
TEST_F(DistanceTest, OfACutBall) {
  ShapeConfig hole = box(Vector3d::Zero());
  hole.type = ShapeType::cylinder;
  hole.radius = 0.05;
  hole.height = 0.7;
  hole.subtract = true;
  ShapeConfig side = box({0.6, 0.6, 0.3}, {0, 0, 0.3});
  side.subtract = true;
  const Field field({sphere(0.25), hole, side});
  EXPECT_TRUE(within(field.at({0.26, 0, 0}).d - 0.01, tol::kDistance));
  EXPECT_TRUE(within(field.at({0.07, 0, 0}).d + 0.02, tol::kDistance));
  EXPECT_TRUE(within(field.at({0.02, 0, 0}).d - 0.03, tol::kDistance));
  EXPECT_TRUE(within(field.at({0.15, 0, 0.14}).d + 0.01, tol::kDistance));
  EXPECT_EQ(field.at({0.15, 0, 0.16}).n, Vec3(0, 0, 1));
  // points of its rims are on it
  EXPECT_GT(field.points().size(), 50u);
  for (const ContactPoint& p : field.points()) EXPECT_LT(std::abs(field.at(p.position).d), 1e-4);
}

// The lid of what was cut out of a cup does not close it, however little it stands above the rim.
TEST_F(DistanceTest, OfACup) {
  ShapeConfig cup = box(Vector3d::Zero());
  cup.type = ShapeType::cylinder;
  cup.radius = 0.12;
  cup.height = 0.4;
  ShapeConfig cut = cup;
  cut.subtract = true;
  cut.radius = 0.1;
  cut.position = {0, 0, 0.021};  // its floor at -0.179, its lid 21 mm above the rim
  cup.orientation = cut.orientation = random_rotation(random_);
  cut.position = cup.orientation * cut.position;
  const Field field({cup, cut});
  for (double z = -0.05; z < 0.19; z += 0.01) {
    const Vector3d x(0.03, 0, z);
    const Distance found = field.at(cup.orientation * x);
    EXPECT_TRUE(within(found.d - 0.07, tol::kDistance)) << z;
    EXPECT_LT((cup.orientation.conjugate() * found.n.cast<double>() + Vector3d::UnitX()).norm(), 1e-4) << z;
  }
  EXPECT_TRUE(within(field.at(cup.orientation * Vector3d(0.03, 0, -0.15)).d - 0.029, tol::kDistance)) << "the floor";
}

// A mesh's stored distances and normals: errors that a smooth surface may have by the nodes' distance.
TEST_F(DistanceTest, OfAMesh) {
  constexpr double R = 0.25;
  const Field field({as_mesh({sphere(R)}, "contact_ball.obj", 0.01)}, 0.02);
  double worst = 0, worst_normal = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vector3d x = R * uniform(random_, 0.9, 1.1) * random_vector(random_, 1).normalized();
    const double expected = (x.norm() < R ? -1 : 1) * to_surface(x, field.body().surface);
    const Distance found = field.at(x);
    worst = std::max(worst, std::abs(std::abs(found.d) - std::abs(expected)));
    worst_normal = std::max(worst_normal, std::acos(std::min(1.0, found.n.cast<double>().dot(x.normalized()))));
  }
  // facets are 0.05 wide: in a corner, 0.029 from the middle, they lean by 0.029 / R = 0.115; nodes are 0.01 apart, so
  // that one up to 0.0087 away may have a say: another 0.035
  EXPECT_LT(worst, 1e-3);
  EXPECT_LT(worst_normal, 0.15);
  for (const ContactPoint& p : field.points()) EXPECT_LT(std::abs(field.at(p.position).d + p.radius), 1e-3);
}

TEST_F(DistanceTest, PointsStickOutOfABox) {
  const Field field({box({0.1, 0.06, 0.04})}, 0.02);
  int corners = 0;
  for (const ContactPoint& p : field.points()) {
    EXPECT_TRUE(within(field.at(p.position).d + p.radius, tol::kDistance));
    EXPECT_NEAR(p.radius, 0.005, 1e-9);
    int faces = 0;  // that its ball touches
    for (int a = 0; a < 3; ++a)
      faces += std::abs(std::abs(p.position[a]) + p.radius - 0.5 * Vector3d(0.1, 0.06, 0.04)[a]) < 1e-9;
    EXPECT_GE(faces, 2) << p.position.transpose();
    corners += faces == 3;
  }
  EXPECT_EQ(corners, 8);
  EXPECT_EQ(field.points().size(), 8u + 4 * (4 + 2 + 1));
}

// Where the bounds of two solids are apart no point of the second is within the margin of the first one's.
TEST(Bounds, AreApartWhereNoPointIsNear) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const Field one({box({0.3, 0.1, 0.2}, {0.05, 0.02, 0})}), other({box({0.1, 0.4, 0.1}), sphere(0.1, {0, 0.2, 0})});
  int apart = 0;
  for (int n = 0; n < 2000; ++n) {
    const Vec3 x = random_vector(random, 0.6).cast<real>();
    const Mat3 R = random_rotation(random).toRotationMatrix().cast<real>();
    const Mat3 R_other = random_rotation(random).toRotationMatrix().cast<real>();
    const real margin = real(0.05);
    if (!bounds_apart(one.shape(), R, other.shape(), R_other, x, margin)) continue;
    ++apart;
    for (const ContactPoint& point : other.points()) {
      const Vec3 arm = (point.position - other.body().center).cast<real>();
      ASSERT_TRUE(outside_bounds(one.shape(), R.transpose() * (x + R_other * arm), margin - real(1e-5)));
    }
  }
  EXPECT_GT(apart, 200);
}

}  // namespace
}  // namespace palp::test::distance_test
