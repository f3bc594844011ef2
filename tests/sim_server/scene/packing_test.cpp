// Fluids around solids that lie off their lattice.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim_server/geometry/solid.h"
#include "tests/support/scene_builder.h"
#include "tests/support/seed.h"

namespace palp::test::packing_test {
namespace {

using namespace test;

constexpr double kSpacing = 0.1;

// A pool in a periodic column: floor up to z = -0.7, water to z = 0.5 with a hole for a ball.
SceneConfig pool(double radius, const Eigen::Vector3d& center) {
  SceneConfig config = scene(kSpacing);
  config.periodic = {true, true, false};
  config.bodies.push_back(body("floor", BodyKind::fixed, box({2, 2, 0.3}, {0, 0, -0.85})));
  config.bodies.push_back(body("water", BodyKind::fluid, box({2, 2, 1.2}, {0, 0, -0.1})));
  config.bodies[1].shapes.push_back(sphere(radius, center));
  config.bodies[1].shapes[1].subtract = true;
  config.bodies.push_back(body("ball", BodyKind::rigid, sphere(radius, center)));
  return config;
}

// The space that solids fill, as points a fifth of a spacing apart.
std::vector<Eigen::Vector3d> filled(const SceneConfig& config) {
  const double step = kSpacing / 5;
  std::vector<Eigen::Vector3d> out;
  for (const BodyConfig& of : config.bodies) {
    if (of.type == BodyKind::fluid) continue;
    const Solid solid = make_solid(of.shapes);
    const Eigen::Isometry3d to_world = Eigen::Translation3d(of.position) * of.orientation * solid.frame;
    const Eigen::Array3d first = solid.bounds.min().array() + step / 2;
    const Eigen::Array3i count = (solid.bounds.sizes().array() / step).round().cast<int>();
    for (int z = 0; z < count.z(); ++z)
      for (int y = 0; y < count.y(); ++y)
        for (int x = 0; x < count.x(); ++x) {
          const Eigen::Vector3d place = first + step * Eigen::Array3d(x, y, z);
          if (solid.contains(place)) out.emplace_back(to_world * place);
        }
  }
  return out;
}

// |sum V gradW| times the spacing, of Wendland's C2 with three spacings for support, with its integral over the solids:
// 0 in a full space, about 0.5 where one side is empty.
class Unevenness {
 public:
  Unevenness(const Scene& scene, const SceneConfig& config)
      : scene_(scene),
        solid_(filled(config)),
        box_(box_of(scene)),
        fluids_(scene.position, box_, kSupport),
        solids_(solid_, box_, kSupport) {}

  double at(std::size_t i) const {
    const Eigen::Vector3d& x = scene_.position[i];
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const auto add = [&](const Eigen::Vector3d& place, double volume) {
      const Eigen::Vector3d d = box_.between(x, place);
      const double H = kSupport, q = std::min(1.0, d.norm() / H);
      sum += volume * 21 / (2 * M_PI * H * H * H) * 20 * std::pow(1 - q, 3) * d / (H * H);
    };
    fluids_.near(x, [&](std::uint32_t j) { add(scene_.position[j], scene_.volume[j]); });
    solids_.near(x, [&](std::uint32_t j) { add(solid_[j], std::pow(kSpacing / 5, 3)); });
    return sum.norm() * scene_.spacing;
  }

 private:
  static constexpr double kSupport = 3 * kSpacing;
  const Scene& scene_;
  std::vector<Eigen::Vector3d> solid_;
  PeriodicBox box_;
  PointGrid fluids_, solids_;
};

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
    const PointGrid grid(s.position, box, kSpacing);
    const Unevenness unevenness(s, config);
    double water = 0, worst = 0, top = -1, nearest = 1, nearest_above = 1;
    const double below = 0.5 - 3 * kSpacing;
    for (std::size_t i = 0; i < s.position.size(); ++i) {
      if (s.bodies[s.body[i]].type != BodyKind::fluid) continue;
      water += s.volume[i];
      top = std::max(top, s.position[i].z());
      grid.near(s.position[i], [&](std::uint32_t j) {
        double& least = s.position[i].z() < below ? nearest : nearest_above;
        if (j != i) least = std::min(least, box.between(s.position[i], s.position[j]).norm() / kSpacing);
      });
      if (s.position[i].z() < below) worst = std::max(worst, unevenness.at(i));
    }
    EXPECT_LT(worst, 0.05);
    EXPECT_GT(nearest, 0.85);
    EXPECT_GT(nearest_above, 0.75);           // the surface's layer does not make way for what rises over the ball
    EXPECT_NEAR(top, 0.45, 0.01 * kSpacing);  // free surfaces stay
    // the ball's surface cuts through a shell of cells
    const double hole = 4.0 / 3 * M_PI * std::pow(radius, 3), shell = 4 * M_PI * radius * radius * kSpacing;
    EXPECT_NEAR(water, 4 * 1.2 - hole, 0.15 * shell);
  }
}

// The worst of all places for the ball: as far off the fluid's lattice as is still left alone.
TEST(Packing, LeavesNoGapAroundWhatIsAlmostOnTheLattice) {
  for (const double off : {0.028, 0.032, 0.06}) {
    const SceneConfig config =
        pool(0.44, Eigen::Vector3d(-0.35, -0.15, -0.15) + Eigen::Vector3d::Constant(off * kSpacing));
    const Scene s = sample_scene(config, 1000000);
    const Unevenness unevenness(s, config);
    for (std::size_t i = 0; i < s.position.size(); ++i)
      if (s.bodies[s.body[i]].type == BodyKind::fluid && s.position[i].z() < 0.2) {
        EXPECT_LT(unevenness.at(i), 0.05) << off;
      }
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

// A cup whose wall and bottom are a third of a spacing thick: what is in it sees its outside, and nothing past it.
TEST(Packing, KeepsAFluidWithinAThinCup) {
  for (const double radius : {0.35, 0.42, 0.5}) {
    const auto cylinder = [](double r, double height, const Eigen::Vector3d& position) {
      ShapeConfig shape = box(Eigen::Vector3d::Zero(), position);
      shape.type = ShapeType::cylinder;
      shape.radius = r;
      shape.height = height;
      return shape;
    };
    const double wall = kSpacing / 3, height = 0.9;
    SceneConfig config = scene(kSpacing);
    config.bodies.push_back(body("cup", BodyKind::fixed, cylinder(radius + wall, height, {0, 0, 0})));
    config.bodies[0].shapes.push_back(cylinder(radius, height, {0, 0, wall}));
    config.bodies[0].shapes[1].subtract = true;
    const double bottom = -height / 2 + wall, level = bottom + 0.6;
    config.bodies.push_back(body("water", BodyKind::fluid, cylinder(radius, 0.6, {0, 0, bottom + 0.3})));
    const Scene s = sample_scene(config, 1000000);
    double water = 0;
    for (std::size_t i = 0; i < s.position.size(); ++i) {
      if (s.bodies[s.body[i]].type != BodyKind::fluid) continue;
      const Eigen::Vector3d& x = s.position[i];
      water += s.volume[i];
      EXPECT_LT(x.head<2>().norm(), radius - 0.3 * kSpacing) << radius;
      EXPECT_GT(x.z(), bottom + 0.3 * kSpacing) << radius;
      EXPECT_LT(x.z(), level) << radius;
    }
    EXPECT_NEAR(water / (EIGEN_PI * radius * radius * 0.6), 1, 0.04) << radius;
  }
}

}  // namespace
}  // namespace palp::test::packing_test
