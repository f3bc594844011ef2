// Walls that grow to hold particles, where solids act by theirs.
#include "sim_server/scene/thick_walls.h"

#include <gtest/gtest.h>

#include "tests/support/scene_builder.h"

namespace palp::test::thick_walls_test {
namespace {

using Eigen::Vector3d;

void expect_between(const ShapeConfig& shape, const Vector3d& low, const Vector3d& high) {
  EXPECT_LT((shape.position - shape.size / 2 - low).norm(), 1e-12) << (shape.position - shape.size / 2).transpose();
  EXPECT_LT((shape.position + shape.size / 2 - high).norm(), 1e-12) << (shape.position + shape.size / 2).transpose();
}

TEST(ThickWalls, GrowOutwardsAndLeaveAVesselOpen) {
  // walls 5 mm thick, a floor of 10 mm, open at the top
  const auto shapes =
      with_thick_walls({box({0.61, 0.61, 0.25}, {0, 0, 0.115}), cut(box({0.6, 0.6, 0.26}, {0, 0, 0.13}))}, 0.04);
  expect_between(shapes[0], {-0.34, -0.34, -0.04}, {0.34, 0.34, 0.24});
  expect_between(shapes[1], {-0.3, -0.3, 0}, {0.3, 0.3, 0.26});
}

TEST(ThickWalls, GrowAroundTheThinnestPlace) {
  const auto shapes = with_thick_walls(
      {box({1, 1, 1}), cut(box({0.2, 0.2, 0.2}, {0.39, 0, 0})), cut(box({0.2, 0.2, 0.2}, {-0.2, 0, 0}))}, 0.1);
  expect_between(shapes[0], {-0.5, -0.5, -0.5}, {0.59, 0.5, 0.5});
}

TEST(ThickWalls, OfRoundVesselsGrowAllAround) {
  const auto shapes =
      with_thick_walls({cylinder(0.0625, 0.16, {0, 0, 0.08}), cut(cylinder(0.06, 0.15, {0, 0, 0.095}))}, 0.024);
  EXPECT_NEAR(shapes[0].radius, 0.084, 1e-12);
  EXPECT_NEAR(shapes[0].height, 0.164, 1e-12);  // the floor of 2 cm by 4 mm
  EXPECT_NEAR(shapes[0].position.z(), 0.078, 1e-12);
  EXPECT_NEAR(shapes[1].radius, 0.06, 1e-12);
}

TEST(ThickWalls, StayWhereTheyAreThickOrStandAlongOtherAxes) {
  ShapeConfig turned = cut(box({0.6, 0.6, 0.26}, {0, 0, 0.13}));
  turned.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d::UnitZ()));
  for (const ShapeConfig& hole : {turned, cut(sphere(0.2)), cut(box({0.4, 0.4, 0.26}, {0, 0, 0.13}))}) {
    const auto shapes = with_thick_walls({box({0.7, 0.7, 0.3}, {0, 0, 0.05}), hole}, 0.04);
    expect_between(shapes[0], {-0.35, -0.35, -0.1}, {0.35, 0.35, 0.2});
  }
  expect_between(with_thick_walls({box({0.01, 1, 1})}, 0.1)[0], {-0.005, -0.5, -0.5}, {0.005, 0.5, 0.5});
}

// By method "paper" a tray of any thickness has two layers of particles.
TEST(ThickWalls, HoldTwoLayersOfParticles) {
  SceneConfig config = scene(0.04);
  config.method = Method::paper;
  config.bodies.push_back(body("tray", BodyKind::fixed, box({0.81, 0.81, 0.405}, {0, 0, 0.1975})));
  config.bodies[0].shapes.push_back(cut(box({0.8, 0.8, 0.44}, {0, 0, 0.22})));
  const Scene s = sample_scene(config, 1000000);
  EXPECT_EQ(s.bodies[0].count, 24u * 24 * 12 - 20u * 20 * 10);
  config.bodies[0].type = BodyKind::rigid;
  EXPECT_ANY_THROW(sample_scene(config, 1000000)) << "its mass is not to change";
}

}  // namespace
}  // namespace palp::test::thick_walls_test
