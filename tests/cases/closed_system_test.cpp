// A fluid, an elastic and two rigid bodies in a periodic box that nothing acts on, for ten thousand steps.
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::closed_system_test {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing = 0.01, kSide = 10 * kSpacing;

Scene closed_system(Method method) {
  Scene scene = empty_scene(kSpacing, {0, 0, 0}, {kSide, kSide, kSide});
  scene.config.method = method;
  scene.config.periodic = {true, true, true};
  scene.config.gravity.setZero();
  scene.config.numerics.support_over_spacing = 2;
  scene.config.numerics.max_speed = 0.3;
  scene.config.numerics.sub_steps = 1;
  const auto oil = add_material(scene, 1000, 1), jelly = add_material(scene, 1000, 0),
             wood = add_material(scene, 500, 0);
  scene.config.materials[jelly].young_modulus = 3e3;
  const Vector3d soft[] = {{1 * kSpacing, 2 * kSpacing, 2 * kSpacing}, {4 * kSpacing, 6 * kSpacing, 6 * kSpacing}};
  const Vector3d hard[] = {{6 * kSpacing, 2 * kSpacing, 3 * kSpacing}, {9 * kSpacing, 5 * kSpacing, 6 * kSpacing}};
  const auto inside = [](const Vector3d& x, const Vector3d box[2]) {
    return (x.array() > box[0].array()).all() && (x.array() < box[1].array()).all();
  };
  add_body(scene, "oil", BodyKind::fluid, oil, {0, 0, 0}, {kSide, kSide, kSide},
           [&](const Vector3d& x) { return !inside(x, soft) && !inside(x, hard); });
  add_body(scene, "jelly", BodyKind::elastic, jelly, soft[0], soft[1]);
  add_body(scene, "wood", BodyKind::rigid, wood, hard[0], hard[1]);
  for (std::uint32_t i = 0; i < scene.bodies[0].count; ++i) {
    const Vector3d k = 2 * M_PI / kSide * scene.position[i];
    scene.velocity[i] = 0.1 * Vector3d(std::sin(k.y()), std::sin(k.z()), std::sin(k.x()));
  }
  for (std::size_t b : {1u, 2u}) {
    scene.bodies[b].velocity = b == 1 ? Vector3d(0.05, 0, 0.02) : Vector3d(-0.05, 0.03, 0);
    for (std::uint32_t i = 0; i < scene.bodies[b].count; ++i)
      scene.velocity[scene.bodies[b].first + i] = scene.bodies[b].velocity;
  }
  return scene;
}

struct Sums {
  Vector3d momentum = Vector3d::Zero();
  double size = 0, energy = 0;  // sum of |m v| [N s]; kinetic [J]
};

Sums sums(const Scene& scene, Simulation& simulation, Snapshot& s) {
  simulation.snapshot(s);
  Sums out;
  const auto add = [&](double mass, const Vector3d& v) {
    out.momentum += mass * v;
    out.size += mass * v.norm();
    out.energy += 0.5 * mass * v.squaredNorm();
  };
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const Body& body = scene.bodies[scene.body[i]];
    if (body.type != BodyKind::rigid)
      add(scene.volume[i] * scene.config.materials[body.material].density,
          {s.velocity[3 * i], s.velocity[3 * i + 1], s.velocity[3 * i + 2]});
  }
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    if (scene.bodies[b].type == BodyKind::rigid) add(scene.bodies[b].mass, simulation.output().bodies[b].state.linear);
  return out;
}

class ClosedSystem : public ::testing::TestWithParam<Method> {};

TEST_P(ClosedSystem, KeepsItsMomentumForTenThousandSteps) {
  const Scene scene = closed_system(GetParam());
  const auto simulation = simulate(scene);
  Snapshot s;
  simulation->step({});
  const Sums before = sums(scene, *simulation, s);
  double drift = 0, most = before.energy;
  for (int k = 1; k <= 10000; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    if (k % 100 != 0) continue;
    const Sums now = sums(scene, *simulation, s);
    drift = std::max(drift, (now.momentum - before.momentum).norm());
    most = std::max(most, now.energy);
  }
  EXPECT_TRUE(within(drift / before.size, tol::kClosedMomentum,
                     {"D18 fluid, elastic and rigid body, 10,000 steps: momentum",
                      "no change of " + quantity(before.size, "N s"), quantity(drift, "N s"), GetParam()}));
  EXPECT_TRUE(within(std::max(0.0, most / before.energy - 1), tol::kClosedEnergy,
                     {"D18 fluid, elastic and rigid body, 10,000 steps: kinetic energy never above the start",
                      "at most " + quantity(1e3 * before.energy, "mJ"), quantity(1e3 * most, "mJ"), GetParam()}));
}

INSTANTIATE_TEST_SUITE_P(Methods, ClosedSystem, ::testing::Values(Method::accurate, Method::paper),
                         [](const auto& param) { return to_string(param.param); });

}  // namespace
}  // namespace palp::test::closed_system_test
