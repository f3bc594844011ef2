// Fluids around solids that lie off their lattice.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim_server/geometry/point_grid.h"
#include "tests/support/scene_builder.h"
#include "tests/support/seed.h"

namespace palp::test::packing_test {
namespace {

using namespace test;

constexpr double kSpacing = 0.1;

// A pool in a periodic column: floor up to z = -0.7, water to z = 0.5 with a hole for a ball.
SceneConfig pool(double radius, const Eigen::Vector3d& center) {
  SceneConfig config = scene(kSpacing);
  config.numerics.solid_particles = true;  // fluids are packed around them before they are left out
  config.periodic = {true, true, false};
  config.bodies.push_back(body("floor", BodyKind::fixed, box({2, 2, 0.3}, {0, 0, -0.85})));
  config.bodies.push_back(body("water", BodyKind::fluid, box({2, 2, 1.2}, {0, 0, -0.1})));
  config.bodies[1].shapes.push_back(sphere(radius, center));
  config.bodies[1].shapes[1].subtract = true;
  config.bodies.push_back(body("ball", BodyKind::rigid, sphere(radius, center)));
  return config;
}

// |sum V gradW| times the spacing, of Wendland's C2 with three spacings for support: 0 in a full space, about 0.5 where
// one side is empty.
double unevenness(const Scene& s, const PointGrid& grid, std::size_t i) {
  const double H = 3 * kSpacing;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const PeriodicBox box = box_of(s);
  grid.near(s.position[i], [&](std::uint32_t j) {
    const Eigen::Vector3d d = box.between(s.position[i], s.position[j]);
    const double q = d.norm() / H;
    if (q < 1) sum += s.volume[j] * 21 / (2 * M_PI * H * H * H) * 20 * std::pow(1 - q, 3) * d / (H * H);
  });
  return sum.norm() * kSpacing;
}

TEST(Packing, FillsTheSpaceAroundASolidEvenly) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int round = 0; round < 5; ++round) {
    const double radius = 0.25 + 0.2 * unit(random);
    const Eigen::Vector3d center(unit(random) - 0.5, unit(random) - 0.5, -0.15 + 0.1 * unit(random));
    const SceneConfig config = pool(radius, center);
    const Scene s = sample_scene(config, 1000000);
    const PeriodicBox box = box_of(s);
    const PointGrid grid(s.position, box, 3 * kSpacing);
    double water = 0, worst = 0, top = -1, nearest = 1;
    for (std::size_t i = 0; i < s.position.size(); ++i) {
      if (s.bodies[s.body[i]].type != BodyKind::fluid) continue;
      water += s.volume[i];
      top = std::max(top, s.position[i].z());
      grid.near(s.position[i], [&](std::uint32_t j) {
        if (j != i) nearest = std::min(nearest, box.between(s.position[i], s.position[j]).norm() / kSpacing);
      });
      if (s.position[i].z() < 0.5 - 3 * kSpacing) worst = std::max(worst, unevenness(s, grid, i));
    }
    EXPECT_LT(worst, 0.05);
    EXPECT_GT(nearest, 0.85);
    EXPECT_NEAR(top, 0.45, 0.3 * kSpacing);
    // a fiftieth of a row on the ball: particles come no nearer to their volume's mean than all the way
    EXPECT_NEAR(water, 4 * 1.2 - 4.0 / 3 * M_PI * std::pow(radius, 3), 0.02 * 4 * M_PI * radius * radius * kSpacing);
  }
}

// The worst of all places for the ball: as far off the fluid's lattice as is still left alone.
TEST(Packing, LeavesNoGapAroundWhatIsAlmostOnTheLattice) {
  for (const double off : {0.028, 0.032, 0.06}) {
    const Scene s = sample_scene(
        pool(0.44, Eigen::Vector3d(-0.35, -0.15, -0.15) + Eigen::Vector3d::Constant(off * kSpacing)), 1000000);
    const PeriodicBox box = box_of(s);
    const PointGrid grid(s.position, box, 3 * kSpacing);
    for (std::size_t i = 0; i < s.position.size(); ++i)
      if (s.bodies[s.body[i]].type == BodyKind::fluid && s.position[i].z() < 0.2) {
        EXPECT_LT(unevenness(s, grid, i), 0.05) << off;
      }
  }
}

// Forces are to be the same whether solids keep particles that nothing needs, or not.
TEST(Packing, IsTheSameWhereSolidsKeepTheirParticles) {
  for (const Eigen::Vector3d& center : {Eigen::Vector3d(0.2, -0.1, -0.1), Eigen::Vector3d(0.66, -0.64, -0.1)}) {
    SceneConfig config = pool(0.33, center);
    const Scene with = sample_scene(config, 1000000);
    config.numerics.solid_particles = false;
    const Scene without = sample_scene(config, 1000000);
    ASSERT_EQ(with.bodies[1].count, without.bodies[1].count);
    for (std::size_t i = 0; i < with.bodies[1].count; ++i)
      ASSERT_EQ(with.position[with.bodies[1].first + i], without.position[without.bodies[1].first + i])
          << center.transpose();
  }
}

// Walls of 0.15 to 0.4 spacings hold few particles, or none, that could hold others back.
TEST(Packing, KeepsWhatAThinGlassHoldsOffItsWalls) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int round = 0; round < 5; ++round) {
    const double radius = 0.45 + 0.2 * unit(random), wall = kSpacing * (0.15 + 0.25 * unit(random));
    const double floor = round % 2 == 0 ? wall : 0.05 + 0.2 * unit(random);
    SceneConfig config = scene(kSpacing);
    config.bodies.push_back(body("glass", BodyKind::fixed, cylinder_between(radius + wall, -0.5 - floor, 0.8)));
    config.bodies[0].shapes.push_back(cut(cylinder_between(radius, -0.5, 0.9)));
    config.bodies.push_back(body("water", BodyKind::fluid, cylinder_between(radius, -0.5, 0.5)));
    const Scene s = sample_scene(config, 1000000);
    const PointGrid grid(s.position, box_of(s), 3 * kSpacing);
    double nearest = 1, off = 1, water = 0;
    for (std::size_t i = 0; i < s.position.size(); ++i) {
      if (s.bodies[s.body[i]].type != BodyKind::fluid) continue;
      water += s.volume[i];
      off = std::min({off, radius - s.position[i].head<2>().norm(), s.position[i].z() + 0.5});
      grid.near(s.position[i], [&](std::uint32_t j) {
        if (j != i) nearest = std::min(nearest, (s.position[i] - s.position[j]).norm() / kSpacing);
      });
    }
    EXPECT_GT(off, 0.19 * kSpacing) << "radius " << radius << ", wall " << wall << ", floor " << floor;
    EXPECT_GT(nearest, 0.7) << "radius " << radius << ", wall " << wall << ", floor " << floor;
    EXPECT_NEAR(water, M_PI * radius * radius, 1e-3);
  }
}

TEST(Packing, LeavesWhatIsOnOneLatticeAlone) {
  SceneConfig config = scene(kSpacing);
  config.bodies.push_back(body("floor", BodyKind::fixed, box({2, 2, 0.3}, {0, 0, -0.85})));
  config.bodies.push_back(body("water", BodyKind::fluid, box({2, 2, 1.2}, {0, 0, -0.1})));
  config.bodies[1].shapes.push_back(box({0.4, 0.4, 0.4}));
  config.bodies[1].shapes[1].subtract = true;
  config.bodies.push_back(body("block", BodyKind::rigid, box({0.4, 0.4, 0.4}, {0, 0, -0.0})));
  const Scene s = sample_scene(config, 1000000);
  for (std::size_t i = 0; i < s.position.size(); ++i) {
    const Eigen::Vector3d cells = s.position[i] / kSpacing + Eigen::Vector3d::Constant(0.5);
    EXPECT_NEAR((cells - cells.array().round().matrix()).norm(), 0, 1e-9);
    EXPECT_NEAR(s.volume[i] / std::pow(kSpacing, 3), 1, 1e-9);
  }
}

}  // namespace
}  // namespace palp::test::packing_test
