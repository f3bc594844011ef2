// Archimedes: the force on a fixed, submerged sphere and the draft of a floating box.
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scene_files.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::buoyancy_test {
namespace {

constexpr const char* kPapersGap =
    "fluid and solid meet by the pressure of their particles: the gap, and so the volume displaced, is not the shape's";
constexpr double kSpacing = 0.02, kFloor = 3 * kSpacing;

// A pool, periodic along x and y, over a floor.
Scene pool(double side, double depth, double headroom, const std::function<bool(const Eigen::Vector3d&)>& is_water) {
  Scene scene = empty_scene(kSpacing, {0, 0, -kFloor}, {side, side, depth + headroom});
  scene.config.periodic = {true, true, false};
  const auto water = add_material(scene, 1000, 1e-3);
  const ByGeometry walls;
  add_body(scene, "water", BodyKind::fluid, water, {0, 0, 0}, {side, side, depth}, is_water);
  add_body(scene, "floor", BodyKind::fixed, water, {0, 0, -kFloor}, {side, side, 0});
  return scene;
}

// The sphere's volume is that of its particles: a fluid meets a solid half a spacing outside its outer particles. They
// lie on the fluid's lattice, so that the pool is at rest from the start.
class Archimedes : public ::testing::TestWithParam<Method> {};

TEST_P(Archimedes, SubmergedSphereIsPushedUpByTheFluidsWeight) {
  constexpr double radius = 5 * kSpacing, side = 15 * kSpacing, depth = 16 * kSpacing;
  const Eigen::Vector3d center(side / 2, side / 2, 8 * kSpacing);
  const auto in_sphere = [&](const Eigen::Vector3d& x) { return (x - center).norm() < radius; };
  Scene scene = pool(side, depth, 0.2, [&](const Eigen::Vector3d& x) { return !in_sphere(x); });
  const auto sphere = add_body(scene, "sphere", BodyKind::fixed, 0, {0, 0, 0}, {side, side, depth}, in_sphere);
  scene.config.method = GetParam();
  scene.config.probes.push_back(probe_of("sphere"));
  const auto simulation = simulate(scene);
  scene.config.rate_hz = 1400;
  constexpr int settle = 60, average = 60;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (int k = 0; k < settle + average; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    if (k >= settle) force += out.bodies[sphere].force / average;
  }
  const double volume = scene.bodies[sphere].volume, weight = 1000 * 9.81 * volume;
  RecordProperty("lift_over_weight", std::to_string(force.z() / weight));
  RecordProperty("particle_volume_over_sphere", std::to_string(volume / (4. / 3 * M_PI * std::pow(radius, 3))));
  EXPECT_TRUE(within(force.z() / weight - 1, tol::kBuoyancy,
                     {"D7 Archimedes: submerged sphere on the fluid's lattice, D = 10 dx",
                      "rho g V = " + quantity(weight, "N"), quantity(force.z(), "N"), GetParam(), kPapersGap}));
  EXPECT_TRUE(within(force.head<2>().norm() / weight, tol::kBuoyancy));
}

// As a user's scene has it: a sphere anywhere in the water, off its lattice, and its volume that of its shape.
TEST_P(Archimedes, SubmergedSphereAnywhereIsPushedUpByItsVolume) {
  constexpr double radius = 5 * kSpacing, weight = 1000 * 9.81 * 4 / 3 * M_PI * radius * radius * radius;
  SceneConfig config = load_scene(source_file("config/scenes/submerged_sphere.toml"));
  config.numerics.spacing = kSpacing;
  config.method = GetParam();
  const Eigen::Vector3d aside(0.005, 0.003, 0.007);
  for (BodyConfig& body : config.bodies)
    for (ShapeConfig& shape : body.shapes)
      if (shape.type == ShapeType::sphere) shape.position += aside;
  const Scene scene = sample_scene(config, 100000);
  const auto simulation = simulate(scene);
  const auto step_until = [&](double end, Eigen::Vector3d& mean) {
    int count = 0;
    for (mean.setZero(); simulation->output().time < end; ++count) mean += simulation->step({}).bodies[2].force;
    mean /= count;
    ASSERT_TRUE(simulation->output().health.ok) << simulation->output().health.cause;
  };
  Eigen::Vector3d force;
  step_until(config.gravity_ramp, force);
  step_until(config.gravity_ramp + 0.2, force);
  RecordProperty("lift_over_weight", std::to_string(force.z() / weight));
  EXPECT_TRUE(within(force.z() / weight - 1, tol::kBuoyancy,
                     {"D7 Archimedes: submerged sphere anywhere, D = 10 dx", "rho g V = " + quantity(weight, "N"),
                      quantity(force.z(), "N"), GetParam(), kPapersGap}));
  EXPECT_TRUE(within(force.head<2>().norm() / weight, tol::kBuoyancy));
}

// Released one layer too high, a flat box of half the water's density comes to float with half its height under water.
TEST_P(Archimedes, FlatBoxFloatsAtItsDraft) {
  constexpr double side = 14 * kSpacing, depth = 8 * kSpacing, across = 8 * kSpacing, high = 4 * kSpacing, share = 0.5;
  constexpr double sunk = 1 * kSpacing;  // at the start; share * high is two layers
  const Eigen::Vector3d low((side - across) / 2, (side - across) / 2, depth - sunk);
  const Eigen::Vector3d top = low + Eigen::Vector3d(across, across, high);
  const auto in_box = [&](const Eigen::Vector3d& x) {
    return (x.array() > low.array()).all() && (x.array() < top.array()).all();
  };
  Scene scene = pool(side, depth, 0.2, [&](const Eigen::Vector3d& x) { return !in_box(x); });
  const auto wood = add_material(scene, 1000 * share, 1e-3);
  const ByGeometry solid;
  const auto box = add_body(scene, "box", BodyKind::rigid, wood, low, top);
  scene.config.accuracy = Accuracy::fast;
  scene.config.method = GetParam();
  const auto simulation = simulate(scene);
  constexpr int settle = 800, average = 500;
  double height = 0, tilt = 0;
  for (int k = 0; k < settle + average; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    if (k < settle) continue;
    height += out.bodies[box].state.position.z() / average;
    tilt = std::max(tilt, out.bodies[box].state.orientation.angularDistance(Eigen::Quaterniond::Identity()));
  }
  // the water that the box displaces lifts the level: level = level0 + (draft - sunk) across^2 / side^2
  const double bottom = height - high / 2, ratio = across * across / (side * side);
  const double draft = (depth - bottom - ratio * sunk) / (1 - ratio);
  RecordProperty("draft_over_height", std::to_string(draft / high));
  EXPECT_TRUE(
      within((draft - share * high) / kSpacing, tol::kDraft,
             {"D7 Archimedes: draft of a flat floating box, s = 0.5", "s h = " + quantity(1e3 * share * high, "mm"),
              quantity(1e3 * draft, "mm"), GetParam(), kPapersGap}));
  EXPECT_TRUE(within(tilt, tol::kTilt,
                     {"D7 Archimedes: largest tilt of the flat floating box", "0", quantity(tilt, "rad"), GetParam(),
                      "neither density diffusion nor artificial viscosity: the water goes on sloshing"}));
}

INSTANTIATE_TEST_SUITE_P(Methods, Archimedes, ::testing::ValuesIn(methods()),
                         [](const auto& param) { return to_string(param.param); });

}  // namespace
}  // namespace palp::test::buoyancy_test
