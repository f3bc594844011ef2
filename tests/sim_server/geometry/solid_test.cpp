// Solids: mass properties, lattices and surfaces against closed forms and against one another, at random sizes and
// poses.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim_server/geometry/mesh.h"
#include "sim_server/geometry/solid.h"
#include "sim_server/geometry/surface.h"
#include "sim_server/scene/sampling.h"
#include "tests/support/seed.h"

namespace palp::test::solid_test {
namespace {

class SolidTest : public ::testing::Test {
 protected:
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Eigen::Vector3d vector(double size) { return {between(-size, size), between(-size, size), between(-size, size)}; }
  Eigen::Quaterniond rotation() {
    return Eigen::Quaterniond(
        Eigen::AngleAxisd(between(-3, 3), (vector(1) + Eigen::Vector3d(1e-3, 0, 0)).normalized()));
  }
  ShapeConfig box() {
    ShapeConfig shape;
    shape.size = {between(0.1, 1), between(0.1, 1), between(0.1, 1)};
    return shape;
  }
  ShapeConfig sphere() {
    ShapeConfig shape;
    shape.type = ShapeType::sphere;
    shape.radius = between(0.1, 1);
    return shape;
  }
  ShapeConfig cylinder() {
    ShapeConfig shape;
    shape.type = ShapeType::cylinder;
    shape.radius = between(0.1, 1);
    shape.height = between(0.1, 1);
    return shape;
  }
  ShapeConfig posed(ShapeConfig shape) {
    shape.position = vector(0.3);
    shape.orientation = rotation();
    return shape;
  }

  unsigned seed_ = drawn_seed();
  std::mt19937 random_{seed_};
  ::testing::ScopedTrace trace_{__FILE__, __LINE__, "seed " + std::to_string(seed_)};
};

// Integrals over the columns of a solid, in its frame, by many lines: nothing in common with the closed forms.
Moments by_lines(const Solid& solid, int lines) {
  Moments sum;
  const Eigen::Vector3d low = solid.bounds.min(), size = solid.bounds.sizes();
  const double area = size.x() * size.y() / (lines * lines);
  std::vector<Interval> inside;
  for (int i = 0; i < lines; ++i) {
    for (int j = 0; j < lines; ++j) {
      const double x = low.x() + size.x() * (i + 0.5) / lines, y = low.y() + size.y() * (j + 0.5) / lines;
      solid.column(x, y, inside);
      for (const Interval& z : inside) {
        const double d = area * (z.high - z.low), m = (z.low + z.high) / 2;
        const double zz = area * (std::pow(z.high, 3) - std::pow(z.low, 3)) / 3;
        sum.volume += d;
        sum.first += d * Eigen::Vector3d(x, y, m);
        Eigen::Matrix3d second = d * Eigen::Vector3d(x, y, m) * Eigen::Vector3d(x, y, m).transpose();
        second(2, 2) = zz;
        sum.second += second;
      }
    }
  }
  return sum;
}

void expect_near(const Moments& a, const Moments& b, double tolerance) {
  EXPECT_NEAR(a.volume, b.volume, tolerance * b.volume);
  EXPECT_LT((a.center() - b.center()).norm(), tolerance * std::cbrt(b.volume));
  EXPECT_LT((a.inertia() - b.inertia()).norm(), tolerance * b.inertia().norm());
}

TEST_F(SolidTest, MomentsOfPrimitivesAgreeWithIntegrationByLines) {
  for (int round = 0; round < 3; ++round) {
    for (const ShapeConfig& shape : {box(), sphere(), cylinder()}) {
      // the second part's pose turns the shape against the lines; the first is cut away again
      Solid solid = make_solid({shape});
      expect_near(solid_moments(solid), by_lines(solid, 250), 5e-3);
      ShapeConfig carrier;
      carrier.size = Eigen::Vector3d::Constant(1e-3);
      carrier.position = Eigen::Vector3d(5, 0, 0);
      solid = make_solid({carrier, posed(shape)});
      solid.bounds = solid.parts[1].bounds;
      const Moments lines = by_lines(solid, 250);
      expect_near(solid.parts[1].moments, lines, 5e-3);
    }
  }
}

TEST_F(SolidTest, InertiaOfPrimitivesIsTheTextbookOne) {
  const double m = 1, a = 2, b = 3, c = 5, r = 0.7, h = 1.9;
  const Moments box = box_moments({a, b, c});
  EXPECT_TRUE((box.inertia() / box.volume * m)
                  .isApprox(Eigen::Matrix3d(Eigen::Vector3d(b * b + c * c, a * a + c * c, a * a + b * b).asDiagonal()) *
                            m / 12));
  const Moments ball = sphere_moments(r);
  EXPECT_TRUE((ball.inertia() / ball.volume).isApprox(0.4 * r * r * Eigen::Matrix3d::Identity()));
  const Moments rod = cylinder_moments(r, h);
  const double across = (3 * r * r + h * h) / 12;
  EXPECT_TRUE(
      (rod.inertia() / rod.volume).isApprox(Eigen::Matrix3d(Eigen::Vector3d(across, across, r * r / 2).asDiagonal())));
}

TEST_F(SolidTest, MovingMovesTheCentreAndTurnsTheInertia) {
  for (int round = 0; round < 100; ++round) {
    const Moments still = box_moments({between(0.1, 1), between(0.1, 1), between(0.1, 1)});
    const Eigen::Isometry3d pose = Eigen::Translation3d(vector(3)) * rotation();
    const Moments moved = still.moved(pose);
    EXPECT_NEAR(moved.volume, still.volume, 1e-12);
    EXPECT_LT((moved.center() - pose.translation()).norm(), 1e-12);
    const Eigen::Matrix3d turned = pose.linear() * still.inertia() * pose.linear().transpose();
    EXPECT_LT((moved.inertia() - turned).norm(), 1e-10);
  }
}

// A polyhedron's integrals are exact: those of a box's triangles are those of the box, wherever it is.
TEST_F(SolidTest, MeshMomentsAreExact) {
  for (int round = 0; round < 50; ++round) {
    const ShapeConfig shape = posed(box());
    const Solid solid = make_solid({shape});
    const SurfaceMesh mesh = solid_surface(solid, 0.1);
    EXPECT_EQ(mesh.triangles.size(), 12u);
    expect_near(mesh_moments(mesh), solid_moments(solid).moved(solid.frame), 1e-11);
  }
}

// Volume of the union of two balls, and of a drilled ball (napkin ring), in closed form.
TEST_F(SolidTest, CombinedSolidsAreWithinTheStatedError) {
  for (int round = 0; round < 2; ++round) {
    ShapeConfig a = sphere(), b = sphere();
    b.radius = a.radius;
    const double r = a.radius, d = between(0.3, 1.7) * r;
    b.position = d * vector(1).normalized();
    const double lens = M_PI * (4 * r + d) * (2 * r - d) * (2 * r - d) / 12;
    const double whole = 2 * sphere_moments(r).volume - lens;
    const Moments joined = solid_moments(make_solid({a, b}));
    EXPECT_NEAR(joined.volume, whole, 1e-3 * whole);
    EXPECT_LT((joined.center() - b.position / 2).norm(), 1e-3 * r);

    ShapeConfig drill = cylinder();
    drill.radius = between(0.2, 0.8) * r;
    drill.height = 3 * r;
    drill.subtract = true;
    drill.orientation = rotation();
    const double ring = 4.0 / 3 * M_PI * std::pow(r * r - drill.radius * drill.radius, 1.5);
    EXPECT_NEAR(solid_moments(make_solid({a, drill})).volume, ring, 1e-3 * ring);
  }
}

// Three rods that cross, as thin as lines in the box around them.
TEST_F(SolidTest, ThinRodsThatCrossAreWithinTheStatedError) {
  const double radius = 1e-3, length = 1.5;
  std::vector<ShapeConfig> rods;
  const Eigen::Vector3d turned_about[] = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}};  // to lie along x, y, z
  for (const Eigen::Vector3d& axis : turned_about) {
    ShapeConfig rod = sphere();
    rod.type = ShapeType::cylinder;
    rod.radius = radius;
    rod.height = length;
    rod.position.setZero();
    rod.orientation = Eigen::AngleAxisd(M_PI / 2, axis);
    rods.push_back(rod);
  }
  // two and three cylinders in one place (Steinmetz): 16/3 and 8 (2 - sqrt 2) r^3
  const double r3 = std::pow(radius, 3), one = M_PI * radius * radius * length;
  const double jack = 3 * one - 3 * 16.0 / 3 * r3 + 8 * (2 - std::sqrt(2)) * r3;
  EXPECT_NEAR(solid_moments(make_solid(rods)).volume, jack, 1e-3 * jack);
  rods.pop_back();
  const double cross = 2 * one - 16.0 / 3 * r3;
  EXPECT_NEAR(solid_moments(make_solid(rods)).volume, cross, 1e-3 * cross);
}

TEST_F(SolidTest, BoxesAreFilledExactly) {
  for (int round = 0; round < 20; ++round) {
    ShapeConfig outer = posed(box());
    outer.size = outer.size.cwiseMax(0.4);
    ShapeConfig hole;
    hole.subtract = true;
    hole.orientation = outer.orientation;
    hole.size = 0.6 * outer.size + Eigen::Vector3d(0, 0, 0.5 * outer.size.z());
    hole.position = outer.position + outer.orientation * Eigen::Vector3d(0, 0, 0.4 * outer.size.z());
    const double dx = between(0.02, 0.05);
    for (const Solid& solid : {make_solid({outer}), make_solid({outer, hole})}) {
      const Particles filled = fill_solid(solid, solid_moments(solid).volume, dx, 10000000);
      double sum = 0;
      for (const double v : filled.volume) {
        sum += v;
        EXPECT_GT(v, 0.29 * dx * dx * dx);
        EXPECT_LT(v, 3.4 * dx * dx * dx);
      }
      EXPECT_TRUE(filled.exact);
      EXPECT_NEAR(sum, solid_moments(solid).volume, 1e-9);
      for (const Eigen::Vector3d& p : filled.position) EXPECT_TRUE(solid.contains(p));
    }
    const Particles plain = fill_solid(make_solid({outer}), outer.size.prod(), dx, 10000000);
    double expected = 1;
    for (int a = 0; a < 3; ++a) expected *= std::max(1.0, std::round(outer.size[a] / dx));
    EXPECT_EQ(static_cast<double>(plain.position.size()), expected);
  }
}

TEST_F(SolidTest, LatticeHoldsEveryCellCentreInsideAndNoOther) {
  for (int round = 0, drawn = 0; round < 10; ++drawn) {
    ASSERT_LT(drawn, 100);
    const ShapeConfig first = sphere();
    ShapeConfig second = posed(cylinder()), cut = posed(box());
    cut.subtract = true;
    const Solid solid = make_solid({first, second, cut});
    const double dx = between(0.06, 0.1);
    const Particles filled = fill_solid(solid, solid_moments(solid).volume, dx, 10000000);
    if (filled.position.empty()) continue;  // the cut took it all
    ++round;
    const double step = std::cbrt(filled.volume.front());
    // a whole number of cells fits across the first part, so a small one sets the step within half a cell of its own
    EXPECT_NEAR(step / dx, 1, std::max(0.1, 0.5 / std::floor(2 * first.radius / dx))) << first.radius / dx;
    std::size_t inside = 0;
    for (int k = -60; k < 60; ++k) {
      for (int j = -60; j < 60; ++j) {
        for (int i = -60; i < 60; ++i) {
          const Eigen::Vector3d p = filled.position.front() + Eigen::Vector3d(i, j, k) * step;
          inside += solid.contains(p) ? 1 : 0;
        }
      }
    }
    // a centre on the surface itself may fall either way
    EXPECT_NEAR(static_cast<double>(filled.position.size()), static_cast<double>(inside), 2);
    for (const Eigen::Vector3d& p : filled.position) {
      EXPECT_TRUE(solid.contains(p) || solid.contains(p + Eigen::Vector3d(0, 0, 1e-9)));
    }
  }
}

TEST_F(SolidTest, CurvedSolidsAreFilledToTheirVolume) {
  for (int round = 0; round < 20; ++round) {
    for (const ShapeConfig& shape : {sphere(), cylinder()}) {
      const Solid solid = make_solid({shape});
      const double dx = shape.radius / between(3.5, 9), volume = solid_moments(solid).volume;
      const Particles filled = fill_solid(solid, volume, dx, 10000000);
      double sum = 0;
      for (const double v : filled.volume) sum += v;
      // the best of 20 lattices whose volumes differ by some percent
      EXPECT_NEAR(sum / volume, 1, 0.02) << shape.radius / dx;
    }
  }
}

TEST_F(SolidTest, FillStopsPastTheLimit) {
  EXPECT_EQ(fill_solid(make_solid({box()}), 1, 0.001, 100).position.size(), 101u);
  EXPECT_EQ(fill_solid(make_solid({sphere()}), 1, 0.001, 100).position.size(), 101u);
}

TEST_F(SolidTest, SurfacesAreClosedAndEncloseTheSolid) {
  for (int round = 0; round < 4; ++round) {
    ShapeConfig tray = box(), cut = box();
    tray.size = {0.8, 0.6, 0.3};
    cut.size = {0.7, 0.5, 0.4};
    cut.position = {0, 0, 0.1};
    cut.subtract = true;
    ShapeConfig drill = posed(cylinder());
    drill.subtract = true;
    ShapeConfig ball = sphere();
    ball.radius = between(0.5, 1);
    drill.radius = between(0.2, 0.3);
    struct Row {
      std::vector<ShapeConfig> shapes;
      double tolerance;
    };
    for (const Row& row : {Row{{posed(box())}, 1e-9}, Row{{tray, cut}, 1e-9}, Row{{posed(sphere())}, 0.03},
                           Row{{posed(cylinder())}, 0.01}, Row{{ball, drill}, 0.03}}) {
      const Solid solid = make_solid(row.shapes);
      SurfaceMesh mesh;
      ASSERT_NO_THROW(mesh = checked_mesh(solid_surface(solid, 0.05), "surface"));
      const double volume = solid_moments(solid).volume;
      EXPECT_NEAR(mesh_moments(mesh).volume, volume, row.tolerance * volume);
    }
  }
}

// A solid of revolution has its exact outline, with walls of a hundredth of its size.
TEST_F(SolidTest, SurfacesOfRevolutionAreClosedAndExact) {
  for (int round = 0; round < 20; ++round) {
    ShapeConfig outer = posed(cylinder()), inner = outer;
    outer.radius = between(0.3, 0.5);
    outer.height = between(0.5, 1);
    inner.radius = outer.radius - between(0.01, 0.2);
    inner.height = outer.height;
    const double floor = between(0.01, 0.1);
    inner.position += floor * (outer.orientation.normalized() * Eigen::Vector3d::UnitZ());
    inner.subtract = true;
    SurfaceMesh mesh;
    ASSERT_NO_THROW(mesh = checked_mesh(solid_surface(make_solid({outer, inner}), 0.05), "surface"));
    const double R = outer.radius, r = inner.radius, h = outer.height;
    const double volume = M_PI * (R * R * h - r * r * (h - floor));
    EXPECT_NEAR(mesh_moments(mesh).volume, volume, 0.015 * volume) << "chords of 32 to 96 to a circle";
    // half of a ball: a bowl with a ball's hollow
    ShapeConfig ball = sphere(), hollow = ball, lid = outer;
    hollow.radius = ball.radius * between(0.5, 0.95);
    hollow.subtract = lid.subtract = true;
    lid.orientation = Eigen::Quaterniond::Identity();
    lid.radius = 2 * ball.radius;
    lid.height = ball.radius;
    lid.position = ball.position + Eigen::Vector3d(0, 0, ball.radius / 2);
    ASSERT_NO_THROW(mesh = checked_mesh(solid_surface(make_solid({ball, hollow, lid}), 0.05), "surface"));
    const double bowl = 2 * M_PI / 3 * (std::pow(ball.radius, 3) - std::pow(hollow.radius, 3));
    EXPECT_NEAR(mesh_moments(mesh).volume, bowl, 0.03 * bowl);
  }
}

// A pan with a handle: what is added at the end stands beside the rest, whose thin walls stay as they are.
TEST_F(SolidTest, HandlesStandBesideWhatIsTurned) {
  ShapeConfig outer = cylinder(), inner = outer, handle = box();
  outer.position.setZero();
  outer.orientation = inner.orientation = handle.orientation = Eigen::Quaterniond::Identity();
  outer.radius = 0.5;
  outer.height = 0.3;
  inner.radius = 0.485;
  inner.height = 0.3;
  inner.position = {0, 0, 0.015};
  inner.subtract = true;
  handle.size = {0.1, 0.4, 0.05};
  handle.position = {0, 0.7, 0.05};
  const auto volume = [](const std::vector<ShapeConfig>& shapes) {
    const SurfaceMesh mesh = solid_surface(make_solid(shapes), 0.05);
    return mesh_moments(checked_mesh(mesh, "surface")).volume;
  };
  const double pan = volume({outer, inner});
  EXPECT_NEAR(pan, M_PI * (0.25 * 0.3 - 0.485 * 0.485 * 0.285), 0.015 * pan);
  EXPECT_NEAR(volume({outer, inner, handle}), pan + handle.size.prod(), 1e-9);
}

// Lines through a mesh agree with the shape that it was made from, also along the edges and vertices of its triangles.
TEST_F(SolidTest, LinesThroughMeshesAreWatertight) {
  ShapeConfig cube;
  cube.size = {1, 1, 1};
  const ColumnMesh mesh(solid_surface(make_solid({cube}), 0.1));
  std::vector<Interval> inside;
  for (int i = 0; i <= 64; ++i) {
    for (int j = 0; j <= 64; ++j) {
      inside.clear();
      const double x = -0.5 + i / 64.0, y = -0.5 + j / 64.0;
      mesh.column(x, y, inside);
      const bool rim = i == 0 || j == 0 || i == 64 || j == 64;
      if (rim) continue;
      ASSERT_EQ(inside.size(), 1u) << x << " " << y;
      EXPECT_NEAR(inside[0].low, -0.5, 1e-12);
      EXPECT_NEAR(inside[0].high, 0.5, 1e-12);
    }
  }
  const ShapeConfig shape = posed(sphere());
  const Solid ball = make_solid({shape});
  const ColumnMesh round(solid_surface(ball, 0.1));
  for (int n = 0; n < 20000; ++n) {
    const double angle = between(0, 2 * M_PI), part = 0.97 * std::sqrt(between(0, 1));
    inside.clear();
    const Eigen::Vector2d at =
        shape.position.head<2>() + part * shape.radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    round.column(at.x(), at.y(), inside);
    ASSERT_EQ(inside.size(), 1u);
    EXPECT_NEAR(inside[0].high - inside[0].low, 2 * shape.radius * std::sqrt(1 - part * part), 0.12 * shape.radius);
  }
}

}  // namespace
}  // namespace palp::test::solid_test
