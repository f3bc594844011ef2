// Edges that a lattice cut off: surfaces as the server makes them of solids that are known exactly.
#include "viewer/sharpen.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "sim_server/geometry/surface.h"

namespace palp::test {
namespace {

using std::numbers::pi;

ShapeConfig cylinder(double radius, double height, double z, bool subtract) {
  ShapeConfig shape;
  shape.type = ShapeType::cylinder;
  shape.radius = radius;
  shape.height = height;
  shape.position = {0, 0, z};
  shape.subtract = subtract;
  return shape;
}

// 10 cm high, 6.9 cm in radius, its floor 2.4 cm thick and its wall, too, but a micrometre off the axis: what is turned
// about one axis needs no lattice.
std::vector<ShapeConfig> cup() {
  std::vector<ShapeConfig> out{cylinder(0.069, 0.1, 0, false), cylinder(0.045, 0.1, 0.024, true)};
  out[1].position.x() = 1e-6;
  return out;
}

Surface lattice_surface(const std::vector<ShapeConfig>& shapes, double cell) {
  const SurfaceMesh mesh = solid_surface(make_solid(shapes), cell);
  Surface surface;
  for (const Eigen::Vector3d& v : mesh.vertices) {
    surface.vertices.emplace_back(osg::Vec3d(v.x(), v.y(), v.z()));
    surface.box.expandBy(surface.vertices.back());
  }
  for (const auto& t : mesh.triangles) {
    Triangle triangle{{t[0], t[1], t[2]}, {}, 0};
    if (measure(surface, triangle)) surface.triangles.push_back(triangle);
  }
  return surface;
}

double area(const Surface& surface, const std::function<bool(const Triangle&)>& which) {
  double sum = 0;
  for (const Triangle& t : surface.triangles)
    if (which(t)) sum += t.area;
  return sum;
}

double volume(const Surface& surface) {
  double sum = 0;
  for (const Triangle& t : surface.triangles) {
    const osg::Vec3d a = surface.vertices[t.corner[0]], b = surface.vertices[t.corner[1]],
                     c = surface.vertices[t.corner[2]];
    sum += a * (b ^ c) / 6;
  }
  return sum;
}

bool all(const Triangle& /*unused*/) { return true; }
bool on_nothing(const Triangle& t) { return t.primitive < 0; }

TEST(Sharpen, ACupGetsItsRimsBack) {
  Surface surface = lattice_surface(cup(), 0.006);
  const double before = area(surface, all);
  sharpen(surface);
  const double r = 0.069, s = 0.045, h = 0.1, depth = 0.076;
  const double exact = 2 * pi * r * h + 2 * pi * r * r + 2 * pi * s * depth;
  EXPECT_LT(before, 0.99 * exact) << "the lattice cuts edges off";
  // what is left are chords of circles
  EXPECT_NEAR(area(surface, all), exact, 0.004 * exact);
  EXPECT_NEAR(volume(surface), pi * (r * r * h - s * s * depth), 0.006 * pi * r * r * h);
  EXPECT_LT(area(surface, on_nothing), 0.001 * exact);
  EXPECT_EQ(surface.primitives.size(), 5u) << "two cylinders, bottom, floor and rim";
}

TEST(Sharpen, AnExactSurfaceOfRevolutionStaysAsItIs) {
  Surface surface = lattice_surface({cylinder(0.069, 0.1, 0, false), cylinder(0.068, 0.1, 0.001, true)}, 0.006);
  const std::vector<osg::Vec3f> vertices = surface.vertices;
  const std::size_t triangles = surface.triangles.size();
  sharpen(surface);
  EXPECT_EQ(surface.vertices, vertices);
  EXPECT_EQ(surface.triangles.size(), triangles);
  EXPECT_TRUE(surface.primitives.empty()) << "two circles about one axis lie on a sphere";
}

TEST(Sharpen, ABallOnAHandleCutByABoxToo) {
  ShapeConfig ball, box;
  ball.type = ShapeType::sphere;
  ball.radius = 0.04;
  box.type = ShapeType::box;
  box.size = {0.05, 0.03, 0.1};
  box.position = {0.03, 0, 0.03};
  box.subtract = true;
  Surface surface = lattice_surface({ball, cylinder(0.012, 0.1, -0.06, false), box}, 0.003);
  sharpen(surface);
  EXPECT_GE(surface.primitives.size(), 6u);
  EXPECT_LT(area(surface, on_nothing), 0.002 * area(surface, all));
  for (const Triangle& t : surface.triangles) {
    if (t.primitive < 0) continue;
    for (const unsigned v : t.corner)
      EXPECT_LT(std::abs(surface.primitives[static_cast<std::size_t>(t.primitive)].distance(surface.vertices[v])),
                2e-5);
  }
}

TEST(Sharpen, ASurfaceOfAnotherKindStaysAsItIs) {
  Surface surface = lattice_surface(cup(), 0.006);
  for (osg::Vec3f& v : surface.vertices) v *= 1 + 0.05f * std::sin(90 * v.x()) * std::cos(70 * v.y() + 50 * v.z());
  for (Triangle& t : surface.triangles) measure(surface, t);
  const std::size_t vertices = surface.vertices.size(), triangles = surface.triangles.size();
  sharpen(surface);
  EXPECT_EQ(surface.vertices.size(), vertices);
  EXPECT_EQ(surface.triangles.size(), triangles);
  EXPECT_TRUE(surface.primitives.empty());
}

}  // namespace
}  // namespace palp::test
