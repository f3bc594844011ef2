// Elastic bodies on, under and against rigid and fixed ones, by the distance fields of these.
#include "sim_server/solver/plan.h"
#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::elastic_contact_test {
namespace {

using Eigen::Vector3d;
constexpr double kSpacing = 0.01;

SceneConfig soft_scene(double friction, double young = 1e5) {
  SceneConfig config = contact_scene(kSpacing, friction, 0.2);
  config.materials[0].young_modulus = young;
  config.materials[0].poisson_ratio = 0.3;
  config.materials[0].damping = 10;
  return config;
}

BodyConfig plate() { return at(body("plate", BodyKind::fixed, box({1.2, 0.2, 0.02})), {0, 0, -0.01}); }

// A soft block of six by six by four particles on a plate.
Scene level(double friction) {
  SceneConfig config = soft_scene(friction);
  config.bodies = {plate(), at(body("block", BodyKind::elastic, box({0.06, 0.06, 0.04})), {-0.5, 0, 0.02})};
  return sampled(config);
}

TEST(ElasticContact, SoftBlocksStickAndSlipLikeRigidOnes) {
  for (const double mu : {0.0, 0.3}) {
    SCOPED_TRACE(mu);
    const Scene scene = level(mu);
    if (mu > 0) {
      EXPECT_LT(std::abs(slide(scene, std::atan(0.95 * mu), {0.3, 0.2, 0.4}).way), 0.1 * kSpacing);
      EXPECT_GT(slide(scene, std::atan(1.05 * mu), {0.3, 0.2, 0.4}).way, 0.2 * kSpacing);
    }
    const double slope = mu > 0 ? std::atan(1.5 * mu) : 0.3;
    const double a = kGravity * (std::sin(slope) - mu * std::cos(slope));
    const double found =
        (slide(scene, slope, {0.3, 0.2, 0.5}).speed - slide(scene, slope, {0.3, 0.2, 0.2}).speed) / 0.3;
    EXPECT_TRUE(within(found / a - 1, tol::kSoftSlide,
                       {"D14 soft block that slides with mu = " + quantity(mu, ""),
                        "g (sin - mu cos) = " + quantity(a, "m/s^2"), quantity(found, "m/s^2")}));
  }
}

// A soft block lies on a plate with its weight, flat, and no particle is in the plate.
TEST(ElasticContact, SoftBlockRestsOnAPlate) {
  Scene scene = level(0.3);
  scene.config.probes.push_back(probe_of("plate"));
  const auto simulation = simulate(scene);
  run(*simulation, 1);
  const double weight = scene.bodies[1].mass * kGravity;
  const double on_plate = -simulation->output().bodies[0].force.z();
  EXPECT_TRUE(within(
      on_plate / weight - 1, tol::kStackForce,
      {"D16 soft block at rest: force on the plate", "weight, " + quantity(weight, "N"), quantity(on_plate, "N")}));
  Snapshot snapshot;
  simulation->snapshot(snapshot);
  double low = 1;
  for (std::size_t i = scene.bodies[1].first; i < scene.position.size(); ++i)
    low = std::min(low, double(snapshot.position[3 * i + 2]));
  EXPECT_NEAR(low, 0.5 * kSpacing, 0.1 * kSpacing);
  const RigidState settled = simulation->output().bodies[1].state;
  run(*simulation, 1);
  EXPECT_LT((simulation->output().bodies[1].state.position - settled.position).norm(), 1e-3 * kSpacing);
}

// A block that begins half a spacing too deep stays there, whichever way it is solved; lifted, it has its half spacing.
TEST(ElasticContact, AStartTooNearStoresNoEnergy) {
  for (const ElasticSolver solver : {ElasticSolver::explicit_, ElasticSolver::implicit}) {
    SCOPED_TRACE(solver == ElasticSolver::implicit ? "implicit" : "explicit");
    SceneConfig config = soft_scene(0.3, 1e6);
    config.numerics.elastic_solver = solver;
    config.bodies = {plate(), at(body("block", BodyKind::elastic, box({0.06, 0.06, 0.04})), {-0.5, 0, 0.015})};
    const Scene scene = sampled(config);
    const auto simulation = simulate(scene);
    double fastest = 0;
    for (int step = 0; step < 300; ++step) fastest = std::max(fastest, simulation->step({}).health.max_speed);
    EXPECT_LT(fastest, 0.02) << "half a spacing of so stiff a spring would throw it off at 1 m/s";
    EXPECT_NEAR(simulation->output().bodies[1].state.position.z(), 0.015, 0.05 * kSpacing);
  }
}

// A rough rigid box and a soft block thrown at each other off centre.
TEST(ElasticContact, KeepsMomentum) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  SceneConfig config = soft_scene(0.5);
  config.gravity.setZero();
  BodyConfig thrown = at(body("box", BodyKind::rigid, box({0.05, 0.05, 0.05})), {-0.09, 0.01, 0}, {1, 0.1, 0});
  thrown.orientation = random_rotation(random);
  thrown.angular_velocity = random_vector(random, 5);
  config.bodies = {thrown, body("block", BodyKind::elastic, box({0.06, 0.06, 0.06}))};
  const Scene scene = sampled(config);
  const auto simulation = simulate(scene);
  Snapshot snapshot;
  const auto sum = [&] {
    simulation->snapshot(snapshot);
    Momenta s = elastic_momenta(scene, snapshot);
    Scene rigid = scene;
    rigid.bodies.resize(1);
    const Momenta m = momenta(rigid, simulation->output());
    s.linear += m.linear;
    s.angular += m.angular;
    s.linear_size += m.linear_size;
    return s;
  };
  simulation->step({});
  const Momenta before = sum();
  for (int k = 0; k < 200; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
  }
  const Momenta after = sum();
  EXPECT_GT(simulation->output().bodies[1].state.linear.x(), 0.1);
  EXPECT_TRUE(within((after.linear - before.linear).norm() / before.linear_size, tol::kSoftMomentum));
  EXPECT_TRUE(within((after.angular - before.angular).norm() / (0.1 * before.linear_size), tol::kSoftSpin));
}

// Thrown at a plate of one spacing at the speed of a hand, a soft ball comes back.
TEST(ElasticContact, NothingPassesThroughAThinPlate) {
  for (const double speed : {0.5, 2.0}) {
    SceneConfig config = soft_scene(0.3);
    config.gravity.setZero();
    config.numerics.max_speed = 2;
    config.bodies = {at(body("plate", BodyKind::fixed, box({0.3, 0.3, kSpacing})), {0, 0, -0.5 * kSpacing}),
                     at(body("ball", BodyKind::elastic, sphere(0.04)), {0, 0, 0.045}, {0, 0, -speed})};
    const auto simulation = simulate(sampled(config));
    run(*simulation, 0.3);
    Snapshot snapshot;
    simulation->snapshot(snapshot);
    const Scene& scene = simulation->scene();
    for (std::size_t i = scene.bodies[1].first; i < scene.position.size(); ++i)
      ASSERT_GT(snapshot.position[3 * i + 2], 0) << speed;
    EXPECT_GT(simulation->output().bodies[1].state.linear.z(), 0.1 * speed);
    EXPECT_LT(simulation->output().bodies[1].state.linear.z(), speed);
  }
}

// A soft block that is bonded to a plate, beneath a ball in a hand.
SceneConfig under_a_ball(double friction) {
  SceneConfig config = soft_scene(friction, 5e4);
  config.bodies = {plate(), at(body("block", BodyKind::elastic, box({0.16, 0.08, 0.03})), {0, 0, 0.015}),
                   at(body("tool", BodyKind::rigid, sphere(0.03)), {-0.03, 0, 0.061})};
  config.bodies[1].bonded_to = {"plate"};
  ProxyConfig proxy;
  proxy.body = "tool";
  config.proxies.push_back(proxy);
  return config;
}

// A ball on a soft hand, pressed into a soft block that is bonded to a plate and drawn across it without friction, is
// pushed up, and hardly to the side.
TEST(ElasticContact, AHandPressesAndDrawsATool) {
  const auto simulation = simulate(sampled(under_a_ball(0)));
  StepInput input;
  input[0].engaged = true;
  input[0].gains = {1000, 20, 10, 0.2};
  double up = 0, across = 0;
  for (int k = 0; k < 700; ++k) {
    const double t = std::max(0, k - 200) * 1e-3;
    input[0].state.position = {-0.03 + 0.1 * t, 0, 0.057};
    input[0].state.linear = {k < 200 ? 0 : 0.1, 0, 0};
    const StepOutput& out = simulation->step(input);
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    if (k < 200) continue;
    up += out.proxies[0].contact_force.z() / 500;
    across += out.proxies[0].contact_force.x() / 500;
    ASSERT_GT(out.proxies[0].contact_force.z(), 0);
  }
  EXPECT_GT(up, 0.5);
  EXPECT_LT(std::abs(across), 0.1 * up);
}

// A tool that leaves a rough block feels nothing of it any more, and when it comes back elsewhere nothing of where it
// stuck before.
TEST(ElasticContact, AToolThatLeavesIsForgotten) {
  for (const ElasticSolver solver : {ElasticSolver::explicit_, ElasticSolver::implicit}) {
    SCOPED_TRACE(solver == ElasticSolver::implicit ? "implicit" : "explicit");
    SceneConfig config = under_a_ball(0.5);
    config.numerics.elastic_solver = solver;
    const auto simulation = simulate(sampled(config));
    StepInput input;
    input[0].engaged = true;
    input[0].gains = {1000, 20, 10, 0.2};
    const auto felt_at = [&](const Vector3d& place) {
      for (int k = 0; k < 300; ++k) {
        input[0].state.position = place;
        const StepOutput& out = simulation->step(input);
        EXPECT_TRUE(out.health.ok) << out.health.cause;
      }
      return simulation->output().proxies[0].contact_force;
    };
    EXPECT_GT(felt_at({-0.03, 0, 0.057}).z(), 0.5);
    EXPECT_EQ(felt_at({-0.03, 0, 0.4}).norm(), 0);
    EXPECT_EQ(felt_at({0.03, 0, 0.4}).norm(), 0);
    EXPECT_EQ(felt_at({0.03, 0, 0.065}).norm(), 0);
    const Vector3d again = felt_at({0.03, 0, 0.057});
    EXPECT_GT(again.z(), 0.5);
    EXPECT_LT(std::hypot(again.x(), again.y()), 0.05 * again.z());
  }
}

// A hand feels the same of a soft block through a tool of 1 g as through one of 100 g, and at rest nothing that moves:
// a light tool's coupling, not its mass, resists contact.
TEST(ElasticContact, ToolsOfAnyMassPressAlike) {
  double forces[2] = {};
  for (const double mass : {1e-3, 0.1}) {
    SceneConfig config = soft_scene(0.3, 5e4);
    config.gravity.setZero();
    config.materials[0].damping = 100;
    MaterialConfig of_tool = config.materials[0];
    of_tool.name = "tool";
    of_tool.density = mass / std::pow(0.036, 3);
    config.materials.push_back(of_tool);
    config.bodies = {plate(), at(body("block", BodyKind::elastic, box({0.06, 0.06, 0.03})), {0, 0, 0.015}),
                     at(body("tool", BodyKind::rigid, box({0.036, 0.036, 0.036})), {0, 0, 0.05})};
    config.bodies[1].bonded_to = {"plate"};
    config.bodies[2].material = "tool";
    ProxyConfig proxy;
    proxy.body = "tool";
    config.proxies.push_back(proxy);
    const auto simulation = simulate(sampled(config));
    StepInput input;
    input[0].engaged = true;
    input[0].gains = {1000, 20, 1, 0.02};
    double mean = 0, before = 0, jump = 0;
    for (int k = 0; k < 500; ++k) {
      input[0].state.position = {0, 0, 0.05 - 0.008 * std::min(1.0, k / 200.0)};
      const StepOutput& out = simulation->step(input);
      ASSERT_TRUE(out.health.ok) << out.health.cause;
      const double force = out.proxies[0].force.z();
      if (k >= 400) {
        mean += force / 100;
        jump = std::max(jump, std::abs(force - before));
      }
      before = force;
    }
    EXPECT_GT(mean, 1);
    EXPECT_TRUE(within(jump / mean, tol::kSteadyPull)) << mass;
    forces[mass > 0.01 ? 1 : 0] = mean;
  }
  EXPECT_TRUE(within(forces[0] / forces[1] - 1, tol::kSwitchedPress));
}

// A hand that jumps drags its tool into a block no faster than a spacing a sub-step, so that it meets each particle and
// the block takes up no more energy than the tool could bring.
TEST(ElasticContact, AToolLeapsOverNoParticles) {
  for (const ElasticSolver solver : {ElasticSolver::explicit_, ElasticSolver::implicit}) {
    SceneConfig config = soft_scene(0.3, 1e5);
    config.gravity.setZero();
    config.numerics.elastic_solver = solver;
    config.bodies = {plate(), at(body("block", BodyKind::elastic, box({0.06, 0.06, 0.03})), {0, 0, 0.015}),
                     at(body("tool", BodyKind::rigid, box({0.036, 0.036, 0.036})), {0, 0, 0.06})};
    config.bodies[1].bonded_to = {"plate"};
    ProxyConfig proxy;
    proxy.body = "tool";
    config.proxies.push_back(proxy);
    const auto simulation = simulate(sampled(config));
    const double fastest = kSpacing * config.rate_hz * simulation->sub_steps();
    double most = 0;
    StepInput input;
    input[0].engaged = true;
    input[0].gains = {1000, 20, 1, 0.02};
    for (int k = 0; k < 200; ++k) {
      input[0].state.position = {0, 0, k % 20 < 10 ? -0.02 : 0.06};
      input[0].state.linear = {0, 0, k % 20 < 10 ? -100.0 : 100.0};
      const StepOutput& out = simulation->step(input);
      ASSERT_TRUE(out.health.ok) << out.health.cause;
      most = std::max(most, out.proxies[0].state.linear.norm());
      EXPECT_LT(out.health.max_speed, 2 * fastest);  // an elastic bounce from the tool
    }
    EXPECT_GT(most, 0.5 * fastest);  // the hand would have it faster
    EXPECT_LT(most, 1.0001 * fastest);
  }
}

// A heavy plate on a layer that is bonded to a floor and cannot give way sideways.
constexpr double kLayer = 0.08, kPlateDensity = 4000, kLayerDensity = 1000, kPlateHeight = 0.1;

SceneConfig plate_on_layer(int layers, ElasticSolver solver, double young) {
  constexpr double width = 0.12;
  const double dx = kLayer / layers;
  SceneConfig config = contact_scene(dx, 0.3, 0.2);
  config.domain_min = {-width / 2, -width / 2, -0.1};
  config.domain_max = {width / 2, width / 2, 0.3};
  config.periodic = {true, true, false};
  config.numerics.elastic_solver = solver;
  config.numerics.support_over_spacing = 2;
  MaterialConfig soft = config.materials[0];
  soft.name = "soft";
  soft.young_modulus = young;
  soft.poisson_ratio = 0.3;
  soft.damping = 30;
  soft.density = kLayerDensity;
  config.materials[0].density = kPlateDensity;
  config.materials.push_back(soft);
  BodyConfig layer = at(body("layer", BodyKind::elastic, box({width, width, kLayer})), {0, 0, kLayer / 2});
  layer.material = "soft";
  layer.bonded_to = {"floor"};
  config.bodies = {
      at(body("floor", BodyKind::fixed, box({width, width, 2 * dx})), {0, 0, -dx}), layer,
      at(body("plate", BodyKind::rigid, box({width, width, kPlateHeight})), {0, 0, kLayer + kPlateHeight / 2})};
  return config;
}

// It sinks by p h / (lambda + 2 mu), its own and half of the layer's weight, whichever solver computes the layer, with
// four layers and with eight.
TEST(ElasticContact, APlateSinksIntoALayerAsDeepByEitherSolver) {
  constexpr double young = 2.5e5;
  for (const int layers : {4, 8}) {
    double sinks[2] = {};
    for (const auto solver : {ElasticSolver::explicit_, ElasticSolver::implicit}) {
      const auto simulation = simulate(sampled(plate_on_layer(layers, solver, young)));
      run(*simulation, 1.5);
      double mean = 0, lowest = 1, highest = 0;
      for (int k = 0; k < 200; ++k) {
        const double sink = kLayer + kPlateHeight / 2 - simulation->step({}).bodies[2].state.position.z();
        mean += sink / 200;
        lowest = std::min(lowest, sink);
        highest = std::max(highest, sink);
      }
      const double modulus = young * 0.7 / (1.3 * 0.4);
      const double weight = kGravity * (kPlateDensity * kPlateHeight + 0.5 * kLayerDensity * kLayer);
      const double exact = weight * kLayer / modulus;
      const bool implicit = solver == ElasticSolver::implicit;
      EXPECT_TRUE(within(mean / exact - 1, tol::kPlateOnLayer,
                         {"plate on an elastic layer of " + std::to_string(layers) + " spacings, " +
                              (implicit ? "implicit" : "explicit"),
                          "p h / (lambda + 2 mu) = " + quantity(1e3 * exact, "mm"), quantity(1e3 * mean, "mm")}));
      // the explicit solver damps its swings by the material's damping alone
      if (implicit) {
        EXPECT_TRUE(within((highest - lowest) / exact, tol::kPlateRests)) << layers;
      }
      sinks[implicit ? 1 : 0] = mean;
    }
    EXPECT_TRUE(within(sinks[1] / sinks[0] - 1, tol::kSwitchedSolver)) << layers;
  }
}

// The test above holds at every accuracy level, which differ in spacing alone where all that moves is
// elastic.
TEST(ElasticContact, LevelsComputeALayerAlike) {
  for (const auto solver : {ElasticSolver::explicit_, ElasticSolver::implicit}) {
    SceneConfig config = plate_on_layer(4, solver, 2.5e5);
    config.periodic = {false, false, false};  // three support radii of a fluid do not fit
    config.numerics.support_over_spacing.reset();
    Scene scene = sampled(config);
    const Plan balanced = make_plan(scene);
    for (const Accuracy level : {Accuracy::fast, Accuracy::accurate}) {
      scene.config.accuracy = level;
      const Plan plan = make_plan(scene);
      EXPECT_EQ(plan.sub_steps, balanced.sub_steps);
      EXPECT_EQ(plan.elastic_rounds, balanced.elastic_rounds);
      EXPECT_EQ(plan.elastic_support, 2 * scene.spacing);
    }
  }
}

TEST(ElasticContact, NeedsNoNeighboursOfOtherBodies) {
  const Scene scene = level(0.3);
  const Plan plan = make_plan(scene);
  EXPECT_TRUE(plan.fields);
  EXPECT_FALSE(plan.contact);
  const auto simulation = simulate(scene);
  simulation->step({});
  for (const std::string& launch : simulation->footprint().launches)
    for (const char* other : {"sort", "solid force", "contact", "contact depth"}) EXPECT_NE(launch, other);
}

}  // namespace
}  // namespace palp::test::elastic_contact_test
