// Viscosity in stages: against the explicit form and analytic flows, what is kept, what is never created, drag, rest,
// and what it costs.

#include <gtest/gtest.h>

#include "config/error.h"
#include "sim_server/physics/viscosity.h"
#include "sim_server/solver/plan.h"
#include "tests/support/backend.h"
#include "tests/support/contents.h"
#include "tests/support/random_scene.h"
#include "tests/support/tolerance.h"

namespace palp::test::viscosity_test {
namespace {

Eigen::Vector3d vector_at(const std::vector<float>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

// A periodic box of two fluids in disorder, or with solids among them, and no outer forces.
Scene stirred(Random& random, bool solids, double viscosity) {
  RandomSceneOptions options;
  options.periodic = {true, true, true};
  options.solids = solids;
  Scene scene = random_scene(random, options);
  scene.config.gravity.setZero();
  scene.config.body_force.setZero();
  scene.config.materials[0].viscosity = viscosity;
  scene.config.materials[1].viscosity = 0.5 * viscosity;
  scene.config.numerics.viscosity = ViscosityScheme::staged;
  return scene;
}

TEST(ViscousStages, HaveSharesThatAddToOne) {
  for (int s : {1, 2, 3, 10, 57, 400}) {
    double sum = 0;
    for (int j = 1; j <= s; ++j) {
      const StageNumbers n = stage_numbers(j, s, 1);
      EXPECT_GT(n.share, 0) << j << " of " << s;
      sum += n.share;
    }
    EXPECT_NEAR(sum, 1, 1e-5) << s;
  }
}

// For one decay rate the stages are a polynomial: 1 - z + ... at small z, within 1 all the way to its bound.
TEST(ViscousStages, DecayAtEveryRateThatTheyReach) {
  for (int s : {1, 2, 5, 17, 100}) {
    const auto decayed = [&](double z) {
      double before = 1, now = 1;
      for (int j = 1; j <= s; ++j) {
        const StageNumbers n = stage_numbers(j, s, 1);
        const double next = now + n.carry * (now - before) - n.rate * z * now;
        before = now;
        now = next;
      }
      return now;
    };
    EXPECT_NEAR((1 - decayed(1e-4)) / 1e-4, 1, 2e-3) << s;
    for (int k = 1; k <= 1000; ++k)
      EXPECT_LT(std::abs(decayed(2 * stage_reach(s) * k / 1000.0)), 1) << s << " stages, " << k;
  }
}

TEST(Viscosity, IsStagedWhereThatCostsLess) {
  Scene scene = empty_scene(0.01, {-0.1, -0.1, -0.1}, {0.2, 0.2, 0.2});
  add_material(scene, 1000, 1e-3);
  add_body(scene, "fluid", BodyKind::fluid, 0, {0, 0, 0}, {0.1, 0.1, 0.1});
  const Plan water = make_plan(scene);
  EXPECT_EQ(water.viscous_stages, 0);
  EXPECT_NE(describe(water, scene).find("viscosity explicit"), std::string::npos);
  scene.config.materials[0].viscosity = 1e3;
  const Plan batter = make_plan(scene);
  EXPECT_GE(batter.sub_steps, water.sub_steps);
  EXPECT_LE(batter.sub_steps, std::ceil(water.sub_steps / 0.8));  // sound has that share beside stages
  EXPECT_NE(describe(batter, scene).find("viscosity in " + std::to_string(batter.viscous_stages) + " stages"),
            std::string::npos);
  EXPECT_LT(batter.sub_steps * (4 + batter.viscous_stages), 3 * batter.explicit_sub_steps);
  scene.config.numerics.viscosity = ViscosityScheme::explicit_;
  const Plan slow = make_plan(scene);
  EXPECT_EQ(slow.viscous_stages, 0);
  EXPECT_EQ(slow.sub_steps, static_cast<int>(batter.explicit_sub_steps));
  scene.config.numerics.viscosity.reset();
  scene.config.materials[0].viscosity = 1e9;
  EXPECT_THROW(make_plan(scene), ConfigError);
}

// With a step that both take, the stages are as far from many small explicit sub-steps as one explicit step is.
TEST(Viscosity, AgreesWithTheExplicitForm) {
  Random random(5);
  Scene scene = stirred(random, false, 100);
  scene.config.numerics.sub_steps.reset();
  scene.config.rate_hz = 1000;
  const auto run = [&](ViscosityScheme scheme, int sub_steps) {
    scene.config.numerics.viscosity = scheme;
    scene.config.numerics.sub_steps = sub_steps;
    const auto simulation = simulate(scene);
    for (int k = 0; k < 5; ++k) EXPECT_TRUE(simulation->step({}).health.ok);
    Snapshot s;
    simulation->snapshot(s);
    return s;
  };
  const Snapshot fine = run(ViscosityScheme::explicit_, 40), staged = run(ViscosityScheme::staged, 40),
                 coarse = run(ViscosityScheme::staged, 1);
  double scale = 0, same = 0, far = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    scale = std::max(scale, scene.velocity[i].norm());
    same = std::max(same, (vector_at(staged.velocity, i) - vector_at(fine.velocity, i)).norm());
    far = std::max(far, (vector_at(coarse.velocity, i) - vector_at(fine.velocity, i)).norm());
  }
  RecordProperty("at_40_sub_steps", std::to_string(same / scale));
  RecordProperty("at_1_sub_step", std::to_string(far / scale));
  EXPECT_TRUE(within(same / scale, tol::kStagedFine));
  EXPECT_TRUE(within(far / scale, tol::kStagedCoarse));
}

class ViscousMomentum : public ::testing::TestWithParam<bool> {};

// Fluids, a free body and one that a hand would hold, with drag that would throw them about if it were explicit.
TEST_P(ViscousMomentum, IsKept) {
  Random random(7);
  Scene scene = stirred(random, GetParam(), 3e3);
  scene.proxies.clear();
  if (GetParam()) {  // without the floor nothing holds the rest
    scene.bodies[4].type = BodyKind::rigid;
    scene.config.probes.clear();
  }
  const auto simulation = simulate(scene);
  Snapshot s;
  simulation->snapshot(s);
  const auto momentum = [&](double& size) {
    simulation->snapshot(s);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    size = 0;
    for (std::size_t i = 0; i < scene.position.size(); ++i) {
      const Body& body = scene.bodies[scene.body[i]];
      const Eigen::Vector3d p =
          scene.volume[i] * scene.config.materials[body.material].density * vector_at(s.velocity, i);
      sum += p;
      size += p.norm();
    }
    return sum;
  };
  double size = 0, now = 0;
  const Eigen::Vector3d before = momentum(size);
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(simulation->step({}).health.ok) << simulation->output().health.cause;
  const Eigen::Vector3d after = momentum(now);
  EXPECT_LT(now, 0.5 * size) << "viscosity has not acted";
  RecordProperty("change", std::to_string((after - before).norm() / size));
  EXPECT_TRUE(within((after - before).norm() / size, tol::kStagedMomentum));
}

INSTANTIATE_TEST_SUITE_P(Scenes, ViscousMomentum, ::testing::Bool(),
                         [](const auto& param) { return param.param ? "with_bodies" : "fluids"; });

// Particles thrown at random into a box, in heaps and holes, so that what the plan foresees does not hold: the
// limit l must keep it stable. Kinetic energy falls, whatever the viscosity.
TEST(Viscosity, NeverCreatesEnergy) {
  for (const double viscosity : {10.0, 1e3, 1e5}) {
    Random random(13);
    Scene scene = stirred(random, true, viscosity);
    scene.proxies.clear();
    scene.config.probes.clear();
    for (const std::size_t b : {3u, 4u}) {  // one body among four fluids: contact gives back what it took
      scene.bodies[b].type = BodyKind::fluid;
      scene.config.materials[scene.bodies[b].material].viscosity = viscosity;
    }
    for (std::size_t i = 0; i < scene.position.size(); ++i)
      if (scene.body[i] != 2 && random() % 3 == 0) scene.position[i] += random_vector(random, 0.08);
    scene.config.numerics.sound_speed = 0.01;  // next to no pressure
    scene.config.numerics.max_speed = 0.005;
    scene.config.numerics.artificial_viscosity = 0;
    const auto simulation = simulate(scene);
    double last = 1e30;
    for (int k = 0; k < 100; ++k) {
      const StepOutput& out = simulation->step({});
      ASSERT_EQ(out.health.non_finite, 0u);
      EXPECT_LT(out.health.kinetic_energy, last * (1 + 1e-5)) << viscosity << " Pa s, step " << k;
      last = out.health.kinetic_energy;
    }
    RecordProperty("energy_at_" + std::to_string(viscosity), std::to_string(last));
  }
}

TEST(Lightness, ViscousStagesArePaidForWhereTheyRun) {
  const auto contents = [](ViscosityScheme scheme, bool body) {
    Scene scene = empty_scene(0.05, {-0.5, -0.5, -0.2}, {0.5, 0.5, 0.8});
    add_material(scene, 1000, 1000);
    scene.config.rate_hz = 2000;
    add_body(scene, "fluid", BodyKind::fluid, 0, {-0.2, -0.2, 0}, {0.2, 0.2, 0.3});
    if (body) add_body(scene, "box", BodyKind::rigid, 0, {-0.1, -0.1, 0.3}, {0.1, 0.1, 0.4});
    scene.config.numerics.viscosity = scheme;
    return contents_of(scene);
  };
  const Contents none = contents(ViscosityScheme::explicit_, false), fluid = contents(ViscosityScheme::staged, false),
                 without = contents(ViscosityScheme::explicit_, true), bodies = contents(ViscosityScheme::staged, true);
  EXPECT_EQ(added(none.arrays, fluid.arrays), (Names{"viscous velocity"}));
  EXPECT_EQ(added(none.launches, fluid.launches), (Names{"viscosity begins", "viscosity"}));
  EXPECT_EQ(added(without.arrays, bodies.arrays), (Names{"viscous velocity", "viscous solid force", "viscous bodies"}));
  EXPECT_EQ(added(without.launches, bodies.launches),
            (Names{"viscosity begins", "viscosity", "viscous bodies begin", "viscous bodies", "viscous bodies move"}));
}

// Turned up while it runs, viscosity becomes staged, and the scene goes on.
TEST(Viscosity, CanBeTurnedUpAtRunTime) {
  Scene scene = empty_scene(0.05, {-0.5, -0.5, -0.2}, {0.5, 0.5, 0.8});
  add_material(scene, 1000, 1e-3);
  add_body(scene, "fluid", BodyKind::fluid, 0, {-0.2, -0.2, 0}, {0.2, 0.2, 0.3});
  scene.config.rate_hz = 200;
  const auto simulation = simulate(scene);
  simulation->step({});
  EXPECT_NE(simulation->numerics().find("viscosity explicit"), std::string::npos);
  simulation->set_parameter("material.0.viscosity", "5000");
  EXPECT_NE(simulation->numerics().find("stages a sub-step"), std::string::npos) << simulation->numerics();
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(simulation->step({}).health.ok);
}

}  // namespace
}  // namespace palp::test::viscosity_test
