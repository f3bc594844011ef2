// Frozen matter meets rigid and fixed bodies as an elastic body does.
#include <random>

#include <gtest/gtest.h>

#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/change_scenes.h"
#include "tests/support/random.h"
#include "tests/support/tolerance.h"

namespace palp::test::frozen_contact_test {
namespace {

using Eigen::Vector3d;
BodyConfig floor(double temperature) {
  return at_temperature(at(body("floor", BodyKind::fixed, box({1.2, 0.2, 0.02})), {0, 0, -0.01}), temperature);
}

Scene level(double friction) {
  SceneConfig config = frozen_scene(friction);
  config.bodies = {floor(280),
                   of_ice(at(body("ice", BodyKind::elastic, box({0.06, 0.06, 0.04})), {-0.5, 0, 0.02}), 280)};
  return sampled(config);
}

double place_of(const Scene& scene, Simulation& simulation, int axis) {
  const Snapshot s = snapshot_of(simulation);
  const Body& ice = scene.bodies[1];
  double sum = 0;
  for (std::size_t i = ice.first; i < ice.first + ice.count; ++i) sum += s.position[3 * i + axis] / ice.count;
  return sum;
}

// How far a lump has slid when its floor has been tilted for a while.
double way_on(double friction, double slope) {
  const Scene scene = level(friction);
  const auto simulation = simulate(scene);
  run(*simulation, 0.3);
  const double start = place_of(scene, *simulation, 0);
  for (int k = 1; k <= 20; ++k) {
    const double angle = slope * k / 20;
    simulation->set_parameter(
        "gravity", std::to_string(kGravity * std::sin(angle)) + " 0 " + std::to_string(-kGravity * std::cos(angle)));
    run(*simulation, k < 20 ? 0.01 : 0.4);
  }
  return place_of(scene, *simulation, 0) - start;
}

TEST(FrozenContact, IceSticksAndSlipsLikeOtherSolids) {
  const double mu = 0.3;
  EXPECT_LT(std::abs(way_on(mu, std::atan(0.95 * mu))), 0.1 * kSpacing);
  EXPECT_GT(way_on(mu, std::atan(1.05 * mu)), 0.2 * kSpacing);
  const double slope = 0.3, t = 0.4 + 0.1;
  EXPECT_NEAR(way_on(0, slope) / (0.5 * kGravity * std::sin(slope) * t * t), 1, 0.1);
}

// Wherever the particles of a splash are when it freezes, and however near to the floor: nothing is pushed away.
TEST(FrozenContact, FreezingAtAWallStoresNoEnergy) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const double squeezed : {0.0, 0.3}) {
    SceneConfig config = frozen_scene(0.3);
    config.gravity.setZero();
    config.bodies = {floor(280),
                     of_ice(at(body("water", BodyKind::fluid, box({0.06, 0.06, 0.04})), {0, 0, 0.02}), 280)};
    Scene scene = sampled(config);
    const Body& water = scene.bodies[1];
    for (std::size_t i = water.first; i < water.first + water.count; ++i) {
      scene.position[i] += random_vector(random, 0.1 * kSpacing);
      scene.position[i].z() -= squeezed * kSpacing;
    }
    const auto simulation = simulate(scene);
    run(*simulation, 0.2);
    EXPECT_LT(simulation->output().health.kinetic_energy, 1e-9) << squeezed;
  }
}

// Free ice, a free tool that is thrown at it, and no floor: both momenta are kept.
TEST(FrozenContact, KeepsMomentum) {
  SceneConfig config = frozen_scene(0.5);
  config.gravity.setZero();
  config.numerics.max_speed = 1;
  config.bodies = {
      of_ice(at(body("ice", BodyKind::elastic, box({0.06, 0.06, 0.04})), {0, 0, 0}), 280),
      at_temperature(at(body("box", BodyKind::rigid, box({0.04, 0.04, 0.04})), {0.01, 0.015, 0.05}, {0.1, 0.05, -0.5}),
                     280)};
  const Scene scene = sampled(config);
  const auto simulation = simulate(scene);
  const auto sums = [&] {
    const Snapshot s = snapshot_of(*simulation);
    Vector3d p = Vector3d::Zero(), l = p;
    const Body& ice = scene.bodies[0];
    for (std::size_t i = ice.first; i < ice.first + ice.count; ++i) {
      const double m = ice.mass / ice.count;
      const Vector3d x(s.position[3 * i], s.position[3 * i + 1], s.position[3 * i + 2]);
      const Vector3d v(s.velocity[3 * i], s.velocity[3 * i + 1], s.velocity[3 * i + 2]);
      p += m * v;
      l += m * x.cross(v);
    }
    const Body& tool = scene.bodies[1];
    const RigidState& t = simulation->output().bodies[1].state;
    const Vector3d q = tool.mass * t.linear;
    const Vector3d spin = t.orientation * (tool.inertia * (t.orientation.conjugate() * t.angular));
    return std::pair<Vector3d, Vector3d>(p + q, l + t.position.cross(q) + spin);
  };
  const auto start = sums();
  const double size = scene.bodies[1].mass * 0.5;
  run(*simulation, 0.3);
  EXPECT_GT(simulation->output().bodies[1].state.linear.z(), -0.2) << "nothing was hit";
  const auto end = sums();
  EXPECT_TRUE(within((end.first - start.first).norm() / size, tol::kSoftMomentum));
  EXPECT_TRUE(within((end.second - start.second).norm() / (size * 0.06), tol::kSoftMomentum));
}

}  // namespace
}  // namespace palp::test::frozen_contact_test
