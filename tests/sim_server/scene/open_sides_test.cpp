// Fluids that nothing holds, and what holds them.
#include <gtest/gtest.h>

#include <random>

#include "tests/support/scene_builder.h"
#include "tests/support/seed.h"

namespace palp::test::open_sides_test {
namespace {

using namespace test;

constexpr double kSpacing = 0.05, kSide = 0.5, kDeep = 0.4;

// Water on a floor, held by walls of this thickness at those of its four sides whose bit is set.
SceneConfig pool(unsigned walls, double thickness) {
  SceneConfig config = scene(kSpacing);
  config.bodies.push_back(body("floor", BodyKind::fixed, box({1.9, 1.9, 0.1}, {0, 0, -0.05})));
  config.bodies.push_back(body("water", BodyKind::fluid, box({kSide, kSide, kDeep}, {0, 0, kDeep / 2})));
  for (int side = 0; side < 4; ++side) {
    if ((walls >> side & 1u) == 0) continue;
    const int axis = side / 2;
    Eigen::Vector3d size(kSide, kSide, kDeep + 0.1), at(0, 0, (kDeep + 0.1) / 2);
    size[axis] = thickness;
    at[axis] = (side % 2 == 0 ? -1 : 1) * (kSide + thickness) / 2;
    config.bodies.push_back(body("wall" + std::to_string(side), BodyKind::fixed, box(size, at)));
  }
  return config;
}

bool will_run_off(const SceneConfig& config) { return sample_scene(config, 100000).runs_off; }

TEST(OpenSides, AreThoseWithoutWallsOfAnyThickness) {
  for (const double thickness : {0.1, 0.02, 0.0005})
    for (unsigned walls = 0; walls < 16; ++walls)
      EXPECT_EQ(will_run_off(pool(walls, thickness)), walls != 15) << walls << ", " << thickness << " m thick";
}

TEST(OpenSides, AreHeldByPeriodicNeighborsAndOtherMatter) {
  SceneConfig config = pool(0, 0.1);
  config.domain_min.head<2>().setConstant(-kSide / 2);
  config.domain_max.head<2>().setConstant(kSide / 2);
  config.bodies[0].shapes[0].size.head<2>().setConstant(kSide);
  config.periodic = {true, false, false};
  EXPECT_TRUE(will_run_off(config));
  config.periodic = {true, true, false};
  EXPECT_FALSE(will_run_off(config));

  SceneConfig beside = pool(7, 0.1);
  beside.materials.push_back(beside.materials[0]);
  beside.bodies.push_back(
      body("jelly", BodyKind::elastic, box({kSide, 0.2, kDeep}, {0, (kSide + 0.2) / 2, kDeep / 2})));
  beside.materials[1].name = "jelly";
  beside.materials[1].young_modulus = 1e4;
  beside.bodies.back().material = "jelly";
  EXPECT_FALSE(will_run_off(beside));
}

TEST(OpenSides, AreNoneOfAFilmOrWithoutGravity) {
  SceneConfig film = pool(0, 0.1);
  film.bodies[1].shapes[0].size.z() = 2 * kSpacing;
  film.bodies[1].shapes[0].position.z() = kSpacing;
  EXPECT_FALSE(will_run_off(film));
  SceneConfig weightless = pool(0, 0.1);
  weightless.gravity.setZero();
  EXPECT_FALSE(will_run_off(weightless));
}

// Packed particles leave gaps beside a solid off their lattice that are not open sides.
TEST(OpenSides, AreNotMadeByPacking) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> off(-0.06, 0.06), radius(0.06, 0.12), turn(0, 3);
  for (int round = 0; round < 12; ++round) {
    SceneConfig config = pool(15, 0.03);
    const Eigen::Vector3d at(off(random), off(random), kDeep - 0.05 + off(random));
    ShapeConfig shape = sphere(radius(random));
    if (round % 2 == 1) shape = box({0.2, 0.15, 0.12});
    ShapeConfig hole = shape;
    hole.position = at - config.bodies[1].position;
    hole.orientation = Eigen::Quaterniond(Eigen::AngleAxisd(turn(random), Eigen::Vector3d(1, 1, 2).normalized()));
    hole.subtract = true;
    config.bodies[1].shapes.push_back(hole);
    config.bodies.push_back(body("tool", BodyKind::rigid, shape));
    config.bodies.back().position = at;
    config.bodies.back().orientation = hole.orientation;
    EXPECT_FALSE(will_run_off(config)) << "round " << round;
  }
}

}  // namespace
}  // namespace palp::test::open_sides_test
