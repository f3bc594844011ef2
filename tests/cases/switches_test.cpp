// Both sides of what a simulation chooses by itself, and what a hand or a scale reads on each: sub-steps, stages of
// viscosity, the elastic solver, threads. Cases and tolerances were set before their results were seen.
#include <cstdlib>
#include <functional>

#include <gtest/gtest.h>

#include "sim_server/solver/plan.h"
#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/backend.h"
#include "tests/support/random_scene.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"
#include "tests/support/towed_tool.h"

namespace palp::test::switches_test {
namespace {

using Choose = std::function<void(SceneConfig&)>;

Scene towed(double viscosity) {
  Scene scene = towed_tool(0.2, viscosity);
  scene.config.numerics.max_speed = 1;
  return scene;
}

// Returns the mean force on the hand against the motion, at 0.2 m/s and over the third tenth of a second [N].
double drag(Scene scene, const Choose& choose) {
  choose(scene.config);
  const auto simulation = simulate(scene);
  StepInput input = towing_hand(scene, 0.2);
  double mean = 0;
  for (int k = 0; k < 300; ++k) {
    const StepOutput& out = simulation->step(input);
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) return 0;
    input[0].state.position.x() += 0.2 / scene.config.rate_hz;
    if (k >= 200) mean -= out.proxies[0].force.x() / 100;
  }
  return mean;
}

Choose with_sub_steps(int count) {
  return [count](SceneConfig& config) { config.numerics.sub_steps = count; };
}

TEST(Switches, SubStepsDoNotChangeTheDrag) {
  const Scene scene = towed(1);
  const int own = make_plan(scene).sub_steps;
  const double chosen = drag(scene, [](SceneConfig&) {});
  ASSERT_GT(chosen, 0);
  for (const int factor : {2, 4}) {
    const double finer = drag(scene, with_sub_steps(factor * own));
    RecordProperty("drag_with_" + std::to_string(factor), std::to_string(finer / chosen));
    EXPECT_TRUE(within(finer / chosen - 1, tol::kSwitchedDrag)) << factor << " times " << own << " sub-steps";
  }
}

// A ball that a hand tows through oil between walls, by solids' geometry: whether the oil moves with each haptic step
// or takes several at once.
TEST(Switches, HapticStepsAtOnceDoNotChangeTheDrag) {
  const auto by = [](std::optional<int> interval) {
    SceneConfig config = contact_scene(0.02, 0, 0.2);
    config.gravity.setZero();
    config.materials[0].viscosity = 1;
    config.numerics.max_speed = 1;
    config.numerics.fluid_interval = interval;
    ShapeConfig room = box({0.6, 0.24, 0.24});
    room.subtract = true;
    BodyConfig tank = body("tank", BodyKind::fixed, box({0.7, 0.34, 0.34}));
    tank.shapes.push_back(room);
    BodyConfig oil = body("oil", BodyKind::fluid, box({0.6, 0.24, 0.24}));
    oil.shapes.push_back(cut(sphere(0.05, {-0.15, 0, 0})));
    config.bodies = {oil, tank, at(body("ball", BodyKind::rigid, sphere(0.05)), {-0.15, 0, 0})};
    ProxyConfig proxy;
    proxy.body = "ball";
    config.proxies.push_back(proxy);
    const Scene scene = sampled(config);
    EXPECT_EQ(make_plan(scene).fluid_interval, interval.value_or(2));
    return drag(scene, [](SceneConfig&) {});
  };
  const double chosen = by({});
  ASSERT_GT(chosen, 0);
  for (const int interval : {1, 3}) {
    const double other = by(interval);
    RecordProperty("drag_with_" + std::to_string(interval), std::to_string(other / chosen));
    EXPECT_TRUE(within(other / chosen - 1, tol::kSwitchedDrag)) << interval;
  }
}

// From a fluid whose viscosity needs no stages to one that is computed in many: either way it drags alike.
TEST(Switches, StagesOfViscosityDoNotChangeTheDrag) {
  for (const double viscosity : {3.0, 30.0, 300.0}) {
    SCOPED_TRACE(viscosity);
    const Scene scene = towed(viscosity);
    const auto by = [&](ViscosityScheme scheme) {
      return drag(scene, [scheme](SceneConfig& config) { config.numerics.viscosity = scheme; });
    };
    const double step_by_step = by(ViscosityScheme::explicit_), staged = by(ViscosityScheme::staged);
    ASSERT_GT(step_by_step, 0);
    RecordProperty("staged_over_explicit_at_" + std::to_string(viscosity), std::to_string(staged / step_by_step));
    EXPECT_TRUE(within(staged / step_by_step - 1, tol::kSwitchedDrag));
  }
}

// A ball that a hand presses 8 mm into a layer that is bonded to a plate.
double pressed(const Choose& choose) {
  SceneConfig config = contact_scene(0.02, 0.3, 0.2);
  add_soft(config, 30);
  BodyConfig layer = at(body("layer", BodyKind::elastic, box({0.24, 0.24, 0.1})), {0, 0, 0.05});
  layer.material = "soft";
  layer.bonded_to = {"plate"};
  config.bodies = {at(body("plate", BodyKind::fixed, box({0.3, 0.3, 0.04})), {0, 0, -0.02}), layer,
                   at(body("tool", BodyKind::rigid, sphere(0.05)), {0, 0, 0.152})};
  ProxyConfig proxy;
  proxy.body = "tool";
  config.proxies.push_back(proxy);
  choose(config);
  const auto simulation = simulate(sampled(config));
  StepInput input;
  input[0].engaged = true;
  input[0].gains = {20000, 200, 10, 0.2};
  double mean = 0;
  for (int k = 0; k < 1000; ++k) {
    input[0].state.position = {0, 0, 0.152 - 0.012 * std::min(1.0, k / 400.0)};
    const StepOutput& out = simulation->step(input);
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) return 0;
    if (k >= 800) mean += out.proxies[0].force.z() / 200;
  }
  return mean;
}

TEST(Switches, TheElasticSolverAndItsSubStepsDoNotChangeThePress) {
  const auto by = [](ElasticSolver solver, double safety) {
    return pressed([=](SceneConfig& config) {
      config.numerics.elastic_solver = solver;
      config.numerics.safety = safety;
    });
  };
  const double chosen = by(ElasticSolver::explicit_, 0.5);
  ASSERT_GT(chosen, 1);
  const double fine = by(ElasticSolver::explicit_, 0.15);
  const double implicit = by(ElasticSolver::implicit, 0.5), implicit_fine = by(ElasticSolver::implicit, 0.15);
  RecordProperty("explicit_fine", std::to_string(fine / chosen));
  RecordProperty("implicit", std::to_string(implicit / chosen));
  RecordProperty("implicit_fine", std::to_string(implicit_fine / implicit));
  EXPECT_TRUE(within(fine / chosen - 1, tol::kSwitchedPress));
  EXPECT_TRUE(within(implicit_fine / implicit - 1, tol::kSwitchedPress));
  EXPECT_TRUE(within(implicit / chosen - 1, tol::kSwitchedSolver));
}

// The momenta of a scene's elastic body, and where its weight acts.
struct Swing {
  Momenta of;              // about the origin
  Eigen::Vector3d weighs;  // sum of mass times place [kg m]
};

Swing swing_of(const Scene& scene, std::uint32_t body, Simulation& simulation) {
  Snapshot s;
  simulation.snapshot(s);
  Swing out{elastic_momenta(scene, s), Eigen::Vector3d::Zero()};
  const Body& b = scene.bodies[body];
  for (std::uint32_t i = b.first; i < b.first + b.count; ++i)
    out.weighs += scene.volume[i] * scene.config.materials[b.material].density *
                  Eigen::Vector3d(s.position[3 * i], s.position[3 * i + 1], s.position[3 * i + 2]);
  return out;
}

// A bar that swings from a clamp: in each step the clamp bears what the bar's momentum and angular momentum lose beside
// gravity, by either solver, damped or not.
TEST(Switches, TheElasticSolverAndDampingDoNotChangeTheReactionOnAClamp) {
  for (const ElasticSolver solver : {ElasticSolver::explicit_, ElasticSolver::implicit})
    for (const double damping : {0.0, 5.0, 50.0}) {
      SCOPED_TRACE(::testing::Message() << (solver == ElasticSolver::implicit ? "implicit" : "explicit") << ", damping "
                                        << damping << " Pa s");
      Scene scene = empty_scene(0.01, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
      add_material(scene, 1000, 0);
      scene.config.materials[0].young_modulus = 2e5;
      scene.config.materials[0].poisson_ratio = 0.3;
      scene.config.materials[0].damping = damping;
      scene.config.numerics.elastic_solver = solver;
      scene.config.gravity = {0, 0, -9.81};
      const auto clamp = add_body(scene, "clamp", BodyKind::fixed, 0, {-0.03, 0, 0}, {0, 0.05, 0.05});
      const auto bar = add_body(scene, "bar", BodyKind::elastic, 0, {0, 0, 0}, {0.16, 0.05, 0.05});
      scene.bodies[bar].bonded_to = {clamp};
      scene.config.probes.push_back(probe_of("clamp"));
      for (std::size_t i = 0; i < scene.position.size(); ++i)
        if (scene.body[i] == bar) scene.velocity[i] = scene.position[i].x() * Eigen::Vector3d(1, 4, 6);
      const Eigen::Vector3d about = scene.bodies[clamp].position, gravity = scene.config.gravity;
      const double mass = scene.bodies[bar].mass, dt = 1 / scene.config.rate_hz;
      const auto simulation = simulate(scene);
      Swing before = swing_of(scene, bar, *simulation);
      double off = 0, force = 0, off_torque = 0, torque = 0;
      for (int k = 0; k < 300; ++k) {
        const StepOutput& out = simulation->step({});
        ASSERT_TRUE(out.health.ok) << out.health.cause;
        const Swing now = swing_of(scene, bar, *simulation);
        const Eigen::Vector3d lost = mass * gravity - (now.of.linear - before.of.linear) / dt;
        const Eigen::Vector3d turned = (0.5 * (now.weighs + before.weighs)).cross(gravity) -
                                       (now.of.angular - before.of.angular) / dt - about.cross(lost);
        off += (out.bodies[clamp].force - lost).squaredNorm();
        off_torque += (out.bodies[clamp].torque - turned).squaredNorm();
        force += lost.squaredNorm();
        torque += turned.squaredNorm();
        before = now;
      }
      const bool solved = solver == ElasticSolver::implicit;
      EXPECT_TRUE(within(std::sqrt(off / force), solved ? tol::kSwitchedSolver : tol::kReaction));
      EXPECT_TRUE(within(std::sqrt(off_torque / torque), solved ? tol::kSwitchedSolver : tol::kReaction));
    }
}

// A block pressed on a plate by a hand, and drawn across it: what it feels is the press and the friction, whatever the
// sub-steps.
TEST(Switches, SubStepsDoNotChangeRigidFriction) {
  for (const int sub_steps : {1, 2, 5}) {
    SCOPED_TRACE(sub_steps);
    SceneConfig config = contact_scene(0.02, 0.3, 0.2);
    config.bodies = {at(body("plate", BodyKind::fixed, box({1.2, 0.4, 0.04})), {0, 0, -0.02}),
                     at(body("tool", BodyKind::rigid, box({0.1, 0.1, 0.06})), {0, 0, 0.03})};
    config.numerics.sub_steps = sub_steps;
    ProxyConfig proxy;
    proxy.body = "tool";
    config.proxies.push_back(proxy);
    const Scene scene = sampled(config);
    const auto simulation = simulate(scene);
    StepInput input;
    input[0].engaged = true;
    input[0].gains = {1000, 20, 20, 0.4};
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (int k = 0; k < 1500; ++k) {
      const double t = std::max(0.0, k * 1e-3 - 0.5);
      input[0].state.position = {0.1 * t, 0, 0.03 - 0.005 * std::min(1.0, k / 300.0)};
      input[0].state.linear = {t > 0 ? 0.1 : 0, 0, 0};
      const StepOutput& out = simulation->step(input);
      ASSERT_TRUE(out.health.ok) << out.health.cause;
      if (k >= 1000) mean += out.proxies[0].contact_force / 500;
    }
    const double load = scene.bodies[1].mass * kGravity + 1000 * 0.005;
    EXPECT_TRUE(within(mean.z() / load - 1, tol::kSwitchedPress));
    EXPECT_TRUE(within(-mean.x() / (0.3 * load) - 1, tol::kSwitchedPress));
  }
}

TEST(Switches, AnyNumberOfThreadsGivesTheSameBits) {
  if (tested_backend() == Backend::cuda) GTEST_SKIP() << "the CPU's threads";
  const char* before = std::getenv("OMP_NUM_THREADS");
  const std::string kept = before != nullptr ? before : "";
  Random random(11);
  const Scene scene = random_scene(random, {});
  const StepInput input = random_input(random, scene);
  Snapshot first;
  for (const char* threads : {"1", "2", "5"}) {
    setenv("OMP_NUM_THREADS", threads, 1);
    const auto simulation = simulate(scene);
    for (int k = 0; k < 50; ++k) ASSERT_TRUE(simulation->step(input).health.ok);
    Snapshot s;
    simulation->snapshot(s);
    if (first.position.empty()) first = s;
    EXPECT_TRUE(s.position == first.position && s.velocity == first.velocity) << threads;
  }
  if (before != nullptr)
    setenv("OMP_NUM_THREADS", kept.c_str(), 1);
  else
    unsetenv("OMP_NUM_THREADS");
}

}  // namespace
}  // namespace palp::test::switches_test
