// Rigid pieces under weight: on a floor, in a liquid, in their own melt.
#include <gtest/gtest.h>

#include "tests/support/change_scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::rigid_pieces_motion_test {
namespace {

struct Piece {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double fastest = 0;
  bool rigid = true;
};

Piece piece_of(const Scene& scene, Simulation& simulation, std::uint32_t body) {
  const Snapshot s = snapshot_of(simulation);
  const Body& b = scene.bodies[body];
  Piece piece;
  for (std::size_t i = b.first; i < b.first + b.count; ++i) {
    piece.center += Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>() / b.count;
    piece.fastest = std::max(piece.fastest, double(Eigen::Map<const Eigen::Vector3f>(&s.velocity[3 * i]).norm()));
    piece.rigid = piece.rigid && s.rigid[i] != 0;
  }
  return piece;
}

// A block that stands under its weight is still in balance when it becomes rigid, and when it is soft again.
TEST(RigidPiece, RestsOnAFloor) {
  Scene scene = on_a_floor(BodyKind::elastic, kMelting - 1);
  scene.config.materials[0].rigid_below = kMelting - 5;
  scene.config.materials[0].damping = 30;
  const double kelvin = mass_of(scene) * kCapacity / kLatent;
  add_heat(scene, -10 * kelvin, 0.5, 0.55);
  add_heat(scene, 10 * kelvin, 0.8, 0.85);
  const auto simulation = simulate(scene);
  run_until(*simulation, 0.5);
  const Piece soft = piece_of(scene, *simulation, 1);
  EXPECT_FALSE(soft.rigid);
  EXPECT_NEAR(soft.center.z(), 0.03, 0.3 * kSpacing);
  bool rigid = false;
  double fastest = 0;
  for (double time = 0.51; time < 1; time += 0.01) {
    run_until(*simulation, time);
    const Piece now = piece_of(scene, *simulation, 1);
    rigid = rigid || now.rigid;
    fastest = std::max(fastest, now.fastest);
    EXPECT_EQ(now.rigid, time > 0.56 && time < 0.8 ? true : time > 0.86 ? false : now.rigid) << time;
    EXPECT_LT((now.center - soft.center).norm(), 0.05 * kSpacing) << time;
  }
  RecordProperty("fastest", std::to_string(fastest));
  RecordProperty("soft", std::to_string(soft.fastest));
  EXPECT_TRUE(rigid);
  EXPECT_TRUE(within(fastest / std::sqrt(9.81 * 0.06), tol::kRestingSpeed));
}

// A block of ice in a pool of 12 x 12 x 6 cm, periodic along x and y.
Scene pool(double density, double low, std::uint32_t liquid) {
  Scene scene = melting_scene();
  scene.config.numerics.support_over_spacing = 2;
  scene.config.gravity = {0, 0, -9.81};
  scene.config.numerics.max_speed.reset();
  scene.config.bodies.clear();
  scene.config.periodic = {true, true, false};
  scene.config.domain_min = scene.bounds_min = {0, 0, -0.03};
  scene.config.domain_max = scene.bounds_max = {0.12, 0.12, 0.15};
  scene.config.materials[0].density = density;
  scene.config.materials[0].rigid_below = kMelting - 5;
  add_material(scene, 1000, 0.1);
  scene.config.materials[1].heat_capacity = kCapacity;
  const auto in_block = [=](const Eigen::Vector3d& x) {
    return std::abs(x.x() - 0.06) < 0.03 && std::abs(x.y() - 0.06) < 0.03 && x.z() > low && x.z() < low + 0.02;
  };
  add_body(scene, "floor", BodyKind::fixed, 1, {0, 0, -0.03}, {0.12, 0.12, 0});
  add_body(scene, "liquid", BodyKind::fluid, liquid, {0, 0, 0}, {0.12, 0.12, 0.06},
           [=](const Eigen::Vector3d& x) { return !in_block(x); });
  add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, {0.12, 0.12, 0.12}, in_block);
  for (const std::uint32_t b : scene.body) scene.temperature.push_back(kMelting + (b == 2 ? -6 : 5));
  return scene;
}

// A piece of half the liquid's density floats half submerged; one of twice that sinks and lies on the ground.
TEST(RigidPiece, FloatsOrSinksByItsDensity) {
  for (const double density : {500.0, 2000.0}) {
    SCOPED_TRACE(density);
    const Scene scene = pool(density, 0.05, 1);
    const auto simulation = simulate(scene);
    const double end = density < 1000 ? 0.8 : 1.8;
    run_until(*simulation, end - 0.1);
    ASSERT_TRUE(simulation->output().health.ok);
    const Piece early = piece_of(scene, *simulation, 2);
    run_until(*simulation, end);
    const Piece late = piece_of(scene, *simulation, 2);
    EXPECT_TRUE(early.rigid && late.rigid);
    RecordProperty("height_of_" + std::to_string(density), std::to_string(late.center.z()));
    RecordProperty("speed_of_" + std::to_string(density), std::to_string(late.fastest));
    // under a plate the last layer of liquid leaves slowly
    EXPECT_NEAR(late.center.z(), density < 1000 ? 0.06 : 0.015, 0.6 * kSpacing);
    EXPECT_LT((late.center - early.center).norm(), 0.2 * kSpacing);
  }
}

// As heavy as its melt it stays where it is.
TEST(RigidPiece, HoversInItsOwnMelt) {
  const Scene scene = pool(1000, 0.02, 0);
  const auto simulation = simulate(scene);
  run_until(*simulation, 0.4);
  ASSERT_TRUE(simulation->output().health.ok);
  const Piece piece = piece_of(scene, *simulation, 2);
  EXPECT_TRUE(piece.rigid);
  RecordProperty("height", std::to_string(piece.center.z()));
  EXPECT_NEAR(piece.center.z(), 0.03, 0.4 * kSpacing);
}

}  // namespace
}  // namespace palp::test::rigid_pieces_motion_test
