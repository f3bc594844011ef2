// Surfaces of bodies: welding, normals, the split into solid and glass.
#include "viewer/mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/viewer/synthetic_scene.h"

namespace palp::test {
namespace {

std::size_t corners(const osg::ref_ptr<osg::Geometry>& part) { return part->getPrimitiveSet(0)->getNumIndices(); }

// A ball of latitude and longitude; loose: each quad has vertices of its own.
BodyDescription ball(int rows, bool loose) {
  BodyDescription body;
  const int columns = 2 * rows;
  const auto point = [&](int row, int column) {
    const double a = std::numbers::pi * row / rows, b = 2 * std::numbers::pi * (column % columns) / columns;
    return std::array<double, 3>{std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)};
  };
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      if (loose) {
        add_quad(body, {point(r, c), point(r + 1, c), point(r + 1, c + 1), point(r, c + 1)});
        continue;
      }
      const auto number = [&](int row, int column) {
        return static_cast<std::uint32_t>(row * columns + column % columns);
      };
      for (const std::uint32_t v :
           {number(r, c), number(r + 1, c), number(r + 1, c + 1), number(r, c), number(r + 1, c + 1), number(r, c + 1)})
        body.triangles.push_back(v);
    }
  }
  for (int i = 0; !loose && i < (rows + 1) * columns; ++i) {
    for (const double x : point(i / columns, i % columns)) body.vertices.push_back(static_cast<float>(x));
  }
  return body;
}

TEST(Mesh, AHollowFixedBodyIsSplitIntoInsideAndGlass) {
  const BodyMesh mesh = build_mesh(tray());
  ASSERT_TRUE(mesh.solid && mesh.glass && mesh.edges);
  EXPECT_EQ(corners(mesh.solid), 5u * 6);  // floor and four inner walls
  EXPECT_EQ(corners(mesh.glass), 9u * 6);  // five outer sides, four of the rim
}

TEST(Mesh, RigidAndFullBodiesAreSolid) {
  EXPECT_FALSE(build_mesh(paddle()).glass);
  BodyDescription block;
  block.kind = BodyKind::fixed;
  add_box(block, {0, 0, 0}, {1, 1, 1}, true, true);
  const BodyMesh mesh = build_mesh(block);
  EXPECT_TRUE(mesh.solid && !mesh.glass && !mesh.edges);
}

TEST(Mesh, NormalsAreSmoothOnCurvesAndFlatAtCreases) {
  const BodyMesh mesh = build_mesh(ball(16, true));
  const auto& vertices = static_cast<const osg::Vec3Array&>(*mesh.solid->getVertexArray());
  const auto& normals = static_cast<const osg::Vec3Array&>(*mesh.solid->getNormalArray());
  for (std::size_t i = 0; i < vertices.size(); ++i) EXPECT_GT(vertices[i] * normals[i], 0.99f);

  BodyDescription block;
  add_box(block, {-1, -1, -1}, {1, 1, 1}, true, true);
  const BodyMesh cube = build_mesh(block);
  for (const osg::Vec3f& n : static_cast<const osg::Vec3Array&>(*cube.solid->getNormalArray())) {
    EXPECT_NEAR(std::max({std::abs(n.x()), std::abs(n.y()), std::abs(n.z())}), 1, 1e-5);
  }
}

// A smooth surface is drawn with one vertex for each place, however it was written.
TEST(Mesh, VerticesAtOnePlaceAreDrawnOnce) {
  const BodyMesh loose = build_mesh(ball(24, true));
  const BodyMesh shared = build_mesh(ball(24, false));
  EXPECT_EQ(corners(loose.solid), corners(shared.solid));
  EXPECT_EQ(corners(loose.solid), 3u * 2 * 48 * 23);  // at the poles half of the triangles have no area
  EXPECT_EQ(shared.solid->getVertexArray()->getNumElements(), 2 + 48u * 23);
  EXPECT_EQ(loose.solid->getVertexArray()->getNumElements(), 2 + 48u * 23);
}

// A vertex with very many normals, as at the tip of a fan with a crease at each blade, costs no more than others.
TEST(Mesh, AVertexOfManyNormalsIsKept) {
  BodyDescription fan;
  constexpr int kBlades = 3000;
  std::mt19937 random(3);
  std::normal_distribution<double> coordinate;
  for (int i = 0; i < kBlades; ++i) {
    const std::array<double, 3> a{coordinate(random), coordinate(random), coordinate(random)};
    const std::array<double, 3> b{coordinate(random), coordinate(random), coordinate(random)};
    add_quad(fan, {{{0, 0, 0}, a, b, b}});
  }
  const BodyMesh mesh = build_mesh(fan);
  EXPECT_GT(corners(mesh.solid), 3u * (kBlades - 10));
  EXPECT_LE(mesh.solid->getVertexArray()->getNumElements(), corners(mesh.solid));
}

TEST(Mesh, ProgressCountsAllOfTheWorkAndACancelledBuildEndsEarly) {
  const BodyDescription body = ball(60, false);
  BuildProgress whole;
  EXPECT_TRUE(build_mesh(body, &whole).solid);
  EXPECT_GT(whole.done, build_work(body) * 9 / 10);  // triangles without an area are passed over
  EXPECT_LE(whole.done, build_work(body));
  BuildProgress cancelled;
  cancelled.cancelled = true;
  EXPECT_FALSE(build_mesh(body, &cancelled).solid);
  EXPECT_LT(cancelled.done, build_work(body) / 4);
}

}  // namespace
}  // namespace palp::test
