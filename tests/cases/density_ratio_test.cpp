// Fluids of very different density in contact: layers at rest, and a light blob that rises.
#include <gtest/gtest.h>

#include "sim_server/solver/plan.h"
#include "tests/support/backend.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::density_ratio_test {
namespace {

constexpr double kSpacing = 0.02;

Scene tank(double light, double heavy_depth, double depth,
           const std::function<bool(const Eigen::Vector3d&)>& in_light) {
  constexpr double side = 9 * kSpacing, wall = 3 * kSpacing;
  Scene scene = empty_scene(kSpacing, {0, 0, -wall}, {side, side, depth + 0.2});
  scene.config.periodic = {true, true, false};
  scene.config.numerics.support_over_spacing = 3;
  const auto heavy = add_material(scene, 1000, 1), other = add_material(scene, light, 1e-3 * light);
  add_body(scene, "heavy", BodyKind::fluid, heavy, {0, 0, 0}, {side, side, heavy_depth},
           [&](const Eigen::Vector3d& x) { return !in_light || !in_light(x); });
  if (in_light)
    add_body(scene, "light", BodyKind::fluid, other, {0, 0, 0}, {side, side, heavy_depth}, in_light);
  else
    add_body(scene, "light", BodyKind::fluid, other, {0, 0, heavy_depth}, {side, side, depth});
  add_body(scene, "floor", BodyKind::fixed, heavy, {0, 0, -wall}, {side, side, 0});
  return scene;
}

class DensityRatio : public ::testing::TestWithParam<double> {};

// A light layer on a heavy one: each has its own hydrostatic pressure, neither mixes with the other, nothing moves.
TEST_P(DensityRatio, LayersComeToRest) {
  constexpr double lower = 0.16, depth = 0.28;
  const double light = GetParam();
  const Scene scene = tank(light, lower, depth, nullptr);
  const auto simulation = simulate(scene);
  double speed = 0;  // of the fastest particle, mean over the last steps: at one time it is a matter of luck
  const int steps = light > 1 ? 1100 : 500;  // of ten sub-steps each
  for (int k = 0; k < steps; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    if (k >= steps - 200) speed += out.health.max_speed / 200;
  }
  Snapshot s;
  simulation->snapshot(s);
  double square = 0, square_light = 0, lowest = 1, highest = 0;
  const double bottom = 9.81 * (1000 * lower + light * (depth - lower));
  for (std::uint32_t b = 0; b < 2; ++b)
    for (std::uint32_t i = scene.bodies[b].first; i < scene.bodies[b].first + scene.bodies[b].count; ++i) {
      const double z = s.position[3 * i + 2];
      const double p = b == 0 ? bottom - 9810 * z : 9.81 * light * (depth - z);
      (b == 0 ? square : square_light) += std::pow(s.pressure[i] - p, 2) / scene.bodies[b].count;
      if (b == 0) highest = std::max(highest, z);
      if (b == 1) lowest = std::min(lowest, z);
    }
  RecordProperty("heavy_rms", std::to_string(std::sqrt(square) / bottom));
  RecordProperty("light_rms_of_its_own", std::to_string(std::sqrt(square_light) / (9.81 * light * (depth - lower))));
  RecordProperty("speed", std::to_string(speed / std::sqrt(9.81 * depth)));
  RecordProperty("gap_in_spacings", std::to_string((lowest - highest) / kSpacing));
  EXPECT_TRUE(within(std::sqrt(square) / bottom, tol::kLayerPressure));
  EXPECT_TRUE(within(speed / std::sqrt(9.81 * depth), tol::kLayerSpeed));
  EXPECT_GT(lowest, highest) << "the layers have mixed";
}

INSTANTIATE_TEST_SUITE_P(Layers, DensityRatio, ::testing::Values(500.0, 10.0, 1.0),
                         [](const auto& param) { return "over_" + std::to_string(static_cast<int>(param.param)); });

// A light blob in a heavy fluid comes up whole: none of it is thrown about faster than a free fall through the tank.
TEST(DensityRatioBlob, Rises) {
  for (const double light : {500.0, 100.0, 1.0}) {
    const Eigen::Vector3d center(0.09, 0.09, 0.08);
    const auto inside = [&](const Eigen::Vector3d& x) { return (x - center).norm() < 0.05; };
    const Scene scene = tank(light, 0.26, 0.26, inside);
    const Body& blob = scene.bodies[1];
    const auto simulation = simulate(scene);
    double speed = 0;
    while (simulation->output().time < (light > 1 ? 0.5 : 0.2)) {
      const StepOutput& out = simulation->step({});
      ASSERT_TRUE(out.health.ok) << out.health.cause;
      speed = std::max(speed, out.health.max_speed);
    }
    Snapshot s;
    simulation->snapshot(s);
    double z = 0;
    for (std::uint32_t i = blob.first; i < blob.first + blob.count; ++i) z += s.position[3 * i + 2] / blob.count;
    RecordProperty("height_of_" + std::to_string(light), std::to_string(z));
    RecordProperty("speed_of_" + std::to_string(light), std::to_string(speed));
    EXPECT_GT(z, 0.12);
    EXPECT_LT(speed, std::sqrt(2 * 9.81 * 0.26));
    EXPECT_EQ(simulation->output().health.outside, 0u);
  }
}

// A heavy drop falls through a thousand times lighter fluid as it would through nothing, and does not scatter it.
TEST(DensityRatioBlob, ADropFalls) {
  const auto inside = [](const Eigen::Vector3d& x) { return (x - Eigen::Vector3d(0.09, 0.09, 0.18)).norm() < 0.05; };
  Scene scene = tank(1000, 0.26, 0.26, inside);
  std::swap(scene.config.materials[0], scene.config.materials[1]);
  scene.config.materials[0].density = 1;
  scene.config.materials[0].viscosity = 1e-3;
  const Body& drop = scene.bodies[1];
  const auto simulation = simulate(scene);
  while (simulation->output().time < 0.1) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    ASSERT_LT(out.health.max_speed, 1.5);
  }
  Snapshot s;
  simulation->snapshot(s);
  double fallen = 0;
  for (std::uint32_t i = drop.first; i < drop.first + drop.count; ++i)
    fallen += (scene.position[i].z() - s.position[3 * i + 2]) / drop.count;
  EXPECT_TRUE(within(fallen / (0.5 * 9.81 * 0.01) - 1, tol::kDropFall));
}

// Weightless, all round a periodic box, a drop that flies into a thousand times lighter fluid gives it its momentum.
TEST(DensityRatioBlob, KeepsMomentum) {
  const auto inside = [](const Eigen::Vector3d& x) { return (x - Eigen::Vector3d(0.09, 0.09, 0.09)).norm() < 0.05; };
  Scene scene = empty_scene(kSpacing, {0, 0, 0}, {0.18, 0.18, 0.18});
  scene.config.periodic = {true, true, true};
  scene.config.gravity.setZero();
  scene.config.numerics.support_over_spacing = 3;
  scene.config.numerics.max_speed = 1;
  add_body(scene, "light", BodyKind::fluid, add_material(scene, 1, 1e-3), {0, 0, 0}, {0.18, 0.18, 0.18},
           [&](const Eigen::Vector3d& x) { return !inside(x); });
  add_body(scene, "drop", BodyKind::fluid, add_material(scene, 1000, 1), {0, 0, 0}, {0.18, 0.18, 0.18}, inside);
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (scene.body[i] == 1) scene.velocity[i] = {0.3, 0.2, -0.1};
  const auto momentum = [&](const std::vector<float>& v, std::uint32_t body) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < scene.position.size(); ++i)
      if (scene.body[i] == body)
        sum += (body == 1 ? 1000 : 1) * scene.volume[i] * Eigen::Map<const Eigen::Vector3f>(&v[3 * i]).cast<double>();
    return sum;
  };
  const auto simulation = simulate(scene);
  Snapshot s;
  simulation->snapshot(s);
  const Eigen::Vector3d before = momentum(s.velocity, 1);
  for (int k = 0; k < 100; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
  }
  simulation->snapshot(s);
  const Eigen::Vector3d light = momentum(s.velocity, 0), heavy = momentum(s.velocity, 1);
  EXPECT_TRUE(within((light + heavy - before).norm() / before.norm(), tol::kMomentumOfSnapshot));
  EXPECT_GT(light.dot(before), 0);
}

}  // namespace
}  // namespace palp::test::density_ratio_test
