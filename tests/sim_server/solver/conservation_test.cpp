// Invariants: momentum of closed systems, the result under translation, quarter turns and reordering, and the
// bits of a repeated run.
#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/random_scene.h"
#include "tests/support/tolerance.h"

namespace palp::test::conservation_test {
namespace {

Eigen::Vector3d vector_at(const std::vector<float>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

struct Momentum {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double size = 0;  // sum of |m v|
};

// Without gravity a particle's mass is rest volume times rest density.
Momentum fluid_momentum(const Scene& scene, const Snapshot& s) {
  Momentum m;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const Body& body = scene.bodies[scene.body[i]];
    if (body.type != BodyKind::fluid) continue;
    const Eigen::Vector3d p =
        scene.volume[i] * scene.config.materials[body.material].density * vector_at(s.velocity, i);
    m.sum += p;
    m.size += p.norm();
  }
  return m;
}

Scene without_forces(Scene scene) {
  scene.config.gravity.setZero();
  scene.config.body_force.setZero();
  return scene;
}

class Conservation : public ::testing::TestWithParam<Method> {};

TEST_P(Conservation, FluidsInAPeriodicBoxKeepTheirMomentum) {
  Random random(11);
  RandomSceneOptions options;
  options.method = GetParam();
  options.periodic = {true, true, true};
  options.solids = false;
  const Scene scene = without_forces(random_scene(random, options));
  const auto simulation = simulate(scene);
  Snapshot s;
  simulation->snapshot(s);
  const Momentum before = fluid_momentum(scene, s);
  for (int k = 0; k < 200; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
  }
  simulation->snapshot(s);
  const Momentum after = fluid_momentum(scene, s);
  const double change = (after.sum - before.sum).norm();
  EXPECT_TRUE(within(change / before.size, tol::kMomentumOfSnapshot,
                     {"D18 momentum of two fluids in a periodic box, 200 steps",
                      "no change of " + quantity(before.size, "N s"), quantity(change, "N s"), GetParam()}));
}

TEST_P(Conservation, FluidAndRigidBodyExchangeMomentum) {
  Random random(12);
  RandomSceneOptions options;
  options.method = GetParam();
  options.periodic = {true, true, true};
  Scene scene = without_forces(random_scene(random, options));
  scene.proxies.clear();  // the tool is free, the floor becomes a third free body
  scene.bodies[4].type = BodyKind::rigid;
  scene.config.probes.clear();
  const auto simulation = simulate(scene);
  const auto momentum = [&](const StepOutput& out) {
    Snapshot s;
    simulation->snapshot(s);
    Momentum m = fluid_momentum(scene, s);
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      const Body& body = scene.bodies[b];
      if (body.type != BodyKind::rigid) continue;
      const RigidState& state = out.bodies[b].state;
      const Eigen::Vector3d p = body.mass * (state.linear + state.angular.cross(state.orientation * body.center));
      m.sum += p;
      m.size += p.norm();
    }
    return m;
  };
  const Momentum before = momentum(simulation->step({}));
  for (int k = 0; k < 100; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
  }
  const Momentum after = momentum(simulation->step({}));
  const double change = (after.sum - before.sum).norm();
  EXPECT_TRUE(within(change / before.size, tol::kMomentumOfSnapshot,
                     {"D18 momentum of two fluids and free bodies, 100 steps",
                      "no change of " + quantity(before.size, "N s"), quantity(change, "N s"), GetParam()}));
}

TEST_P(Conservation, ViscosityOnlyTakesEnergy) {
  Random random(13);
  RandomSceneOptions options;
  options.method = GetParam();
  options.periodic = {true, true, true};
  options.solids = false;
  options.jitter = 0.02;
  const Scene scene = without_forces(random_scene(random, options));
  const auto simulation = simulate(scene);
  double before = 1e30;
  for (int k = 0; k < 100; ++k) {
    const double energy = simulation->step({}).health.kinetic_energy;
    // sound stores a little of it for a while
    ASSERT_LT(energy, 1.02 * before);
    before = std::min(before, energy);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, Conservation, ::testing::Values(Method::accurate, Method::paper),
                         [](const auto& param) { return to_string(param.param); });

// Runs both scenes and compares the second's state, mapped back, with the first's.
template <class Map>
void expect_equivalent(const Scene& a, const Scene& b, const StepInput& input_a, const StepInput& input_b, int steps,
                       const Tolerance& tolerance, Map&& map) {
  const auto first = simulate(a), second = simulate(b);
  for (int k = 0; k < steps; ++k) {
    first->step(input_a);
    second->step(input_b);
  }
  Snapshot s, t;
  first->snapshot(s);
  second->snapshot(t);
  double worst = 0, scale = 0;
  for (std::size_t i = 0; i < a.position.size(); ++i) {
    const auto [v, j] = map(t, i);
    scale = std::max(scale, (vector_at(s.velocity, i) - a.velocity[i]).norm());
    worst = std::max(worst, (vector_at(s.velocity, i) - v).norm());
    EXPECT_NEAR(s.pressure[i], t.pressure[j], 1e-3 * 15 * 15 * 1000);
  }
  EXPECT_TRUE(within(worst / scale, tolerance));
}

void move_scene(Scene& scene, const Eigen::Vector3d& by) {
  scene.bounds_min += by;
  scene.bounds_max += by;
  for (Eigen::Vector3d& x : scene.position) x += by;
  for (Body& body : scene.bodies) body.position += by;
}

TEST(Invariance, UnderTranslation) {
  Random random(21);
  const Scene scene = random_scene(random, {});
  Scene moved = scene;
  const Eigen::Vector3d by(0.7, -0.4, 0.3);
  move_scene(moved, by);
  StepInput input = random_input(random, scene), moved_input = input;
  moved_input[0].state.position += by;
  expect_equivalent(scene, moved, input, moved_input, 3, tol::kTranslation, [](const Snapshot& s, std::size_t i) {
    return std::pair{vector_at(s.velocity, i), i};
  });
}

TEST(Invariance, UnderAQuarterTurn) {
  Random random(22);
  Scene scene = random_scene(random, {});
  scene.proxies.clear();
  Eigen::Matrix3d Q;
  Q << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  Scene turned = scene;
  const Eigen::Vector3d low = Q * scene.bounds_min, high = Q * scene.bounds_max;
  turned.bounds_min = low.cwiseMin(high);
  turned.bounds_max = low.cwiseMax(high);
  turned.config.gravity = Q * scene.config.gravity;
  turned.config.body_force = Q * scene.config.body_force;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    turned.position[i] = Q * scene.position[i];
    turned.velocity[i] = Q * scene.velocity[i];
  }
  for (Body& body : turned.bodies) {
    body.position = Q * body.position;
    body.orientation = Eigen::Quaterniond(Q) * body.orientation;
    body.velocity = Q * body.velocity;
    body.angular_velocity = Q * body.angular_velocity;
  }
  expect_equivalent(scene, turned, {}, {}, 3, tol::kSymmetry, [&](const Snapshot& s, std::size_t i) {
    return std::pair{Eigen::Vector3d(Q.transpose() * vector_at(s.velocity, i)), i};
  });
}

TEST(Invariance, UnderPermutationWithinABody) {
  Random random(23);
  const Scene scene = random_scene(random, {});
  Scene shuffled = scene;
  std::vector<std::uint32_t> from(scene.position.size()), to(from.size());
  std::iota(from.begin(), from.end(), 0u);
  for (const Body& body : scene.bodies)
    std::shuffle(from.begin() + body.first, from.begin() + body.first + body.count, random);
  for (std::size_t i = 0; i < from.size(); ++i) {
    shuffled.position[i] = scene.position[from[i]];
    shuffled.velocity[i] = scene.velocity[from[i]];
    to[from[i]] = static_cast<std::uint32_t>(i);
  }
  const StepInput input = random_input(random, scene);
  expect_equivalent(scene, shuffled, input, input, 3, tol::kSymmetry, [&](const Snapshot& s, std::size_t i) {
    return std::pair{vector_at(s.velocity, to[i]), std::size_t(to[i])};
  });
}

// Two runs, and a run after reset(), give the same bits.
TEST(Determinism, RunsRepeatBitForBit) {
  for (Method method : {Method::accurate, Method::paper}) {
    Random random(31);
    RandomSceneOptions options;
    options.method = method;
    options.periodic = {true, false, false};
    const Scene scene = random_scene(random, options);
    const StepInput input = random_input(random, scene);
    const auto run = [&](Simulation& simulation, Snapshot& s) {
      Eigen::Vector3d force = Eigen::Vector3d::Zero();
      for (int k = 0; k < 20; ++k) force += simulation.step(input).proxies[0].force;
      simulation.snapshot(s);
      return force;
    };
    const auto first = simulate(scene), second = simulate(scene);
    Snapshot a, b, c;
    const Eigen::Vector3d force_a = run(*first, a), force_b = run(*second, b);
    first->reset();
    EXPECT_EQ(first->step(input).step, 1u);
    first->reset();
    const Eigen::Vector3d force_c = run(*first, c);
    EXPECT_EQ(force_a, force_b);
    EXPECT_EQ(force_a, force_c);
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.position, c.position);
    EXPECT_EQ(a.velocity, c.velocity);
    EXPECT_EQ(a.pressure, c.pressure);
    EXPECT_EQ(a.time, c.time);
  }
}

}  // namespace
}  // namespace palp::test::conservation_test
