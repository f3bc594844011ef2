// Contact of rigid bodies by distance fields: friction, bounce, stacks, ripple, speed, conservation.
#include <gtest/gtest.h>

#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::rigid_contact_test {
namespace {

using Eigen::Vector3d;
// A block on a level plate.
Scene level(double friction, Method method = Method::accurate) {
  SceneConfig config = contact_scene(0.02, friction, 0.2);
  config.method = method;
  config.bodies.push_back(at(body("plate", BodyKind::fixed, box({1.9, 0.4, 0.04})), {0, 0, -0.02}));
  config.bodies.push_back(at(body("block", BodyKind::rigid, box({0.1, 0.1, 0.06})), {-0.85, 0, 0.03}));
  return sampled(config);
}

double place_of_block(const Simulation& simulation) { return simulation.output().bodies[1].state.position.x(); }

class ContactIn : public ::testing::TestWithParam<Method> {};

TEST_P(ContactIn, FrictionlessBlockSlidesFreely) {
  const double slope = 30 * M_PI / 180, t = 0.75;
  const double expected = 0.5 * kGravity * std::sin(slope) * t * t;
  const double way = slide(level(0, GetParam()), slope, {0.2, 0, t}).way;
  EXPECT_TRUE(within(way / expected - 1, tol::kFrictionlessSlide,
                     {"D14 block on a frictionless slope of 30 deg, 0.75 s",
                      "g sin(theta) t^2 / 2 = " + quantity(expected, "m"), quantity(way, "m"), GetParam()}));
}

// From the speeds at two times after it began to slide.
double sliding_acceleration(const Scene& scene, double slope) {
  return (slide(scene, slope, {0.2, 0.1, 0.7}).speed - slide(scene, slope, {0.2, 0.1, 0.2}).speed) / 0.5;
}

// A ball thrown along a table slides, and rolls from 2 v / (7 mu g) on, with 5/7 of its speed (Coriolis 1835).
TEST(Contact, ASlidingBallBeginsToRoll) {
  constexpr double mu = 0.3, radius = 0.05, speed = 1, rolling = 5. / 7 * speed;
  SceneConfig config = contact_scene(0.02, mu, 0);
  config.bodies = {at(body("table", BodyKind::fixed, box({1.3, 0.3, 0.06})), {0, 0, -0.03}),
                   at(body("ball", BodyKind::rigid, sphere(radius)), {-0.5, 0, radius}, {speed, 0, 0})};
  const auto simulation = simulate(sampled(config));
  const RigidState& ball = simulation->output().bodies[1].state;
  run(*simulation, 0.05);
  const double slowed = (speed - ball.linear.x()) / 0.05;
  EXPECT_TRUE(within(slowed / (mu * kGravity) - 1, tol::kFrictionSlide,
                     {"Ball thrown along a table: acceleration while it slides",
                      "mu g = " + quantity(mu * kGravity, "m/s^2"), quantity(slowed, "m/s^2")}));
  run(*simulation, 0.25);
  EXPECT_TRUE(within(ball.linear.x() / rolling - 1, tol::kRolling,
                     {"Ball thrown along a table: speed when it rolls", "5/7 v = " + quantity(rolling, "m/s"),
                      quantity(ball.linear.x(), "m/s")}));
  EXPECT_TRUE(within(ball.angular.y() * radius / rolling - 1, tol::kRolling,
                     {"Ball thrown along a table: its rim's speed when it rolls", quantity(rolling, "m/s"),
                      quantity(ball.angular.y() * radius, "m/s")}));
}

TEST(Contact, FrictionHoldsBelowItsAngleAndDragsAboveIt) {
  for (const double mu : {0.2, 0.5}) {
    SCOPED_TRACE(mu);
    // it gives by the contact's elasticity, but does not slip
    const double below = slide(level(mu), std::atan(0.98 * mu), {0.2, 0.3, 0.5}).way;
    const double above = slide(level(mu), std::atan(1.02 * mu), {0.2, 0.3, 0.5}).way;
    const bool bracketed = std::abs(below) < 5e-4 && above > 2e-3;
    EXPECT_TRUE(within(bracketed ? 0.02 : 1, tol::kFrictionAngle,
                       {"D16 slope at which friction lets go, mu = " + quantity(mu, ""), "tan(theta) = mu",
                        quantity(1e3 * std::abs(below), "mm at 0.98 mu, ") + quantity(1e3 * above, "mm at 1.02 mu")}));
    const double slope = std::atan(1.5 * mu), a = kGravity * (std::sin(slope) - mu * std::cos(slope));
    const double found = sliding_acceleration(level(mu), slope);
    EXPECT_TRUE(within(found / a - 1, tol::kFrictionSlide,
                       {"D14 block that slides with mu = " + quantity(mu, ""),
                        "g (sin - mu cos) = " + quantity(a, "m/s^2"), quantity(found, "m/s^2")}));
  }
}

// Static friction holds what kinetic friction alone would not, and lets go once it has slipped.
TEST(Contact, StaticFrictionIsMoreThanKinetic) {
  Scene scene = level(0.5);
  scene.config.materials[0].kinetic_friction = 0.2;
  EXPECT_LT(std::abs(slide(scene, std::atan(0.4), {0.2, 0.3, 0.3}).way), 5e-4);
  const double steep = std::atan(0.6), a = kGravity * (std::sin(steep) - 0.2 * std::cos(steep));
  EXPECT_TRUE(within(sliding_acceleration(scene, steep) / a - 1, tol::kFrictionSlide));
}

// Restitution of a ball thrown at a plate, or at another ball, from many distances and at many speeds.
TEST(Contact, BallsBounceByTheirRestitution) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const double e : {0.2, 0.5, 0.8, 1.0})
    for (int round = 0; round < 4; ++round) {
      SceneConfig config = contact_scene(0.02, 0.3, e);
      config.gravity.setZero();
      const double v = uniform(random, 0.2, 2);
      config.bodies.push_back(at(body("plate", BodyKind::fixed, box({0.4, 0.4, 0.04})), {0, 0, -0.02}));
      config.bodies.push_back(
          at(body("ball", BodyKind::rigid, sphere(0.05)), {0, 0, 0.05 + uniform(random, 0.001, 0.01)}, {0, 0, -v}));
      const auto simulation = simulate(sampled(config));
      for (int k = 0; k < 150; ++k) simulation->step({});
      const double after = simulation->output().bodies[1].state.linear.z();
      EXPECT_TRUE(within(after / v - e, tol::kRestitution,
                         {"D16 ball that bounces off a plate, e = 0.2 to 1, the worst",
                          "e v = " + quantity(e * v, "m/s at e = ") + quantity(e, ""), quantity(after, "m/s")}))
          << "e " << e;
    }
}

// Two balls, then two turned boxes, thrown at each other off centre, with friction.
TEST(Contact, BodiesExchangeMomentum) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (int round = 0; round < 6; ++round) {
    SceneConfig config = contact_scene(0.02, 0.4, 0.5);
    config.gravity.setZero();
    const ShapeConfig shape = round < 3 ? sphere(0.05) : box({0.1, 0.08, 0.06});
    for (int k = 0; k < 2; ++k) {
      BodyConfig one =
          at(body(k ? "b" : "a", BodyKind::rigid, shape), {k ? 0.09 : -0.09, 0, 0}, {k ? -0.5 : 0.7, 0.1, 0});
      one.position += random_vector(random, 0.01);
      if (round >= 3) one.orientation = random_rotation(random);
      if (round >= 3) one.angular_velocity = random_vector(random, 3);
      config.bodies.push_back(one);
    }
    const Scene scene = sampled(config);
    const auto simulation = simulate(scene);
    const Momenta before = momenta(scene, simulation->step({}));
    bool touched = false;
    for (int k = 0; k < 300; ++k) {
      const StepOutput& out = simulation->step({});
      ASSERT_TRUE(out.health.ok) << out.health.cause;
      const Vector3d sum = out.bodies[0].force + out.bodies[1].force;
      touched = touched || out.bodies[0].force.norm() > 0;
      EXPECT_LE(sum.norm(), 1e-6 * out.bodies[0].force.norm());
    }
    const Momenta after = momenta(scene, simulation->output());
    EXPECT_TRUE(touched);
    const double change = (after.linear - before.linear).norm();
    EXPECT_TRUE(within(change / before.linear_size, tol::kContactMomentum,
                       {"D16 momentum of two bodies that collide",
                        "no change of " + quantity(before.linear_size, "N s"), quantity(change, "N s")}));
    // angular velocities are read at mid-step, which for a turning box is not quite that of its orientation
    if (round < 3) {
      EXPECT_TRUE(within((after.angular - before.angular).norm() / before.angular_size, tol::kContactSpin));
    }
  }
}

TEST(Contact, StacksRest) {
  constexpr int kBoxes = 5;
  constexpr double dx = 0.02, edge = 0.08;
  SceneConfig config = contact_scene(dx, 0.3, 0.2);
  config.bodies.push_back(at(body("floor", BodyKind::fixed, box({0.6, 0.6, 0.04})), {0, 0, -0.02}));
  for (int k = 0; k < kBoxes; ++k)
    config.bodies.push_back(
        at(body("box " + std::to_string(k), BodyKind::rigid, box({edge, edge, edge})), {0, 0, (k + 0.5) * edge}));
  config.probes.push_back(probe_of("floor"));
  const Scene scene = sampled(config);
  const auto simulation = simulate(scene);
  for (int k = 0; k < 1000; ++k) simulation->step({});
  const std::vector<BodyOutput> settled = simulation->output().bodies;
  double moving = 0, drift = 0, on_floor = 0;
  std::vector<double> force(kBoxes + 1, 0.0);
  for (int k = 0; k < 4000; ++k) {
    const StepOutput& out = simulation->step({});
    on_floor += out.bodies[0].force.z() / 4000;
    moving = std::max(moving, out.health.kinetic_energy);
  }
  const double weight = scene.bodies[1].mass * kGravity;
  // of the whole stack on the floor; in between, what each box gets is the difference of two contacts
  EXPECT_TRUE(within(-on_floor / (kBoxes * weight) - 1, tol::kStackForce,
                     {"D16 stack of five boxes: force on the floor", "weight, " + quantity(kBoxes * weight, "N"),
                      quantity(-on_floor, "N")}));
  for (int k = 1; k <= kBoxes; ++k) {
    const BodyOutput& out = simulation->output().bodies[static_cast<std::size_t>(k)];
    EXPECT_TRUE(within(out.force.z() / weight - 1, tol::kStackForce,
                       {"D16 stack of five boxes: what carries each, the worst",
                        "weight of one, " + quantity(weight, "N"), quantity(out.force.z(), "N")}))
        << "box " << k;
    drift = std::max(drift, (out.state.position - settled[static_cast<std::size_t>(k)].state.position).norm());
  }
  RecordProperty("drift_in_spacings", std::to_string(drift / dx));
  EXPECT_TRUE(
      within(drift / dx, tol::kStackDrift, {"D16 stack of five boxes: drift", "0", quantity(1e6 * drift, "um")}));
  EXPECT_LT((simulation->output().bodies[kBoxes].state.position - Vector3d(0, 0, (kBoxes - 0.5) * edge)).norm(),
            0.15 * dx);  // by their weight they sink into each other
  EXPECT_LT(moving, 1e-6 * weight * dx);
}

// A tool with a flat face, pressed on a plate by a soft hand and drawn across it: what the hand feels is as flat as
// the plate (physics reference D19).
TEST_P(ContactIn, FlatToolSlidesWithoutRipple) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const double yaw : {0.0, uniform(random, 0.05, 1.5)}) {
    SceneConfig config = contact_scene(0.01, 0, 0.2);
    config.method = GetParam();
    config.bodies.push_back(at(body("plate", BodyKind::fixed, box({0.6, 0.12, 0.02})), {0, 0, -0.01}));
    const Eigen::Quaterniond orientation(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
    add_flat_tool(config, orientation);
    // particles let the tool sink in further before they press back with as much
    const double height = GetParam() == Method::paper ? 0.0150 : 0.02;
    const DrawnTool drawn = draw_flat_tool(*simulate(sampled(config)), orientation, height);
    EXPECT_GT(drawn.felt.low, 4);
    const std::string turned = yaw == 0 ? ", along the lattice: " : ", turned at random: ";
    const auto row = [&](const char* what, double found) {
      return ValidationCase{
          "D19 flat tool drawn over a plane with 5 N" + turned + what, "0",
          quantity(1e3 * found * drawn.contact.low, "mN of ") + quantity(drawn.contact.low, "N"), GetParam(),
          "contact is the pressure between two lattices of particles, which is the ripple of the paper's Fig. 4"};
    };
    const double across = drawn.across / drawn.contact.low;
    EXPECT_TRUE(within(drawn.felt.ripple(), tol::kRipple, row("ripple that the hand feels", drawn.felt.ripple())))
        << "felt, yaw " << yaw;
    EXPECT_TRUE(within(drawn.contact.ripple(), tol::kRippleOfContact, row("ripple of contact", drawn.contact.ripple())))
        << "contact, yaw " << yaw;
    EXPECT_TRUE(within(across, tol::kRipple, row("push along the way", across)));
    const double line = spectral_line(drawn.pressed, 1e-3 * kDrawSpeed / 0.01) / drawn.contact.low;
    EXPECT_TRUE(within(line, tol::kLatticeLine, row("line at speed / spacing", line))) << "line, yaw " << yaw;
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, ContactIn, ::testing::ValuesIn(methods()),
                         [](const auto& param) { return to_string(param.param); });

// A hand pushes a tool at a plate of one spacing, at speeds that a hand reaches and past the plate's other side.
TEST(Contact, NothingPassesThroughAThinPlate) {
  for (const double speed : {0.3, 1.0, 2.0, 4.0})
    for (const bool ball : {false, true}) {
      SceneConfig config = contact_scene(0.005, 0.3, 0.2);
      config.gravity.setZero();
      config.numerics.max_speed = 2;
      config.bodies.push_back(at(body("plate", BodyKind::fixed, box({0.1, 0.1, 0.005})), {0, 0, -0.0025}));
      const ShapeConfig shape = ball ? sphere(0.01) : box({0.02, 0.02, 0.02});
      config.bodies.push_back(at(body("tool", BodyKind::rigid, shape), {0, 0, 0.0203}));
      ProxyConfig proxy;
      proxy.body = "tool";
      config.proxies.push_back(proxy);
      const auto simulation = simulate(sampled(config));
      StepInput input;
      input[0].engaged = true;
      input[0].gains = {1000, 5, 10, 0.2};
      for (int k = 0; k < 400; ++k) {
        const double way = std::min(0.05, speed * k * 1e-3);
        input[0].state.position = {0, 0, 0.0203 - way};
        input[0].state.linear = {0, 0, way < 0.05 ? -speed : 0};
        const StepOutput& out = simulation->step(input);
        ASSERT_TRUE(out.health.ok) << out.health.cause;
      }
      const RigidState& state = simulation->output().bodies[1].state;
      // the hand is 3 cm deep and pulls with 40 N
      EXPECT_NEAR(state.position.z(), 0.01, 0.005) << speed << (ball ? " m/s, ball" : " m/s, box");
      EXPECT_GT(simulation->output().proxies[0].contact_force.z(), 20);
    }
}

// A free box thrown at the plate without a hand.
TEST(Contact, AThrownBoxBouncesOffAThinPlate) {
  Random random(4);
  for (int round = 0; round < 5; ++round) {
    SceneConfig config = contact_scene(0.005, 0.3, 0.5);
    config.gravity.setZero();
    config.numerics.max_speed = 2;
    config.bodies.push_back(at(body("plate", BodyKind::fixed, box({0.2, 0.2, 0.005})), {0, 0, -0.0025}));
    BodyConfig thrown = at(body("box", BodyKind::rigid, box({0.02, 0.03, 0.02})), {0, 0, 0.03}, {0.1, 0, -2});
    thrown.orientation = random_rotation(random);
    config.bodies.push_back(thrown);
    const Scene scene = sampled(config);
    const auto simulation = simulate(scene);
    const double energy = simulation->step({}).health.kinetic_energy;
    for (int k = 0; k < 100; ++k) {
      const StepOutput& out = simulation->step({});
      EXPECT_LT(out.health.kinetic_energy, 1.01 * energy);
      EXPECT_GT(out.bodies[1].state.position.z(), 0);
    }
    EXPECT_GT(simulation->output().bodies[1].state.linear.z(), 0);
  }
}

// Four posts under a plate, one pair each: together they are no stiffer than the step allows.
TEST(Contact, ManySupportsAreStable) {
  SceneConfig config = contact_scene(0.02, 0.3, 0.1);
  for (int k = 0; k < 6; ++k)
    config.bodies.push_back(at(body("post " + std::to_string(k), BodyKind::fixed, box({0.04, 0.04, 0.1})),
                               {0.1 * (k % 3) - 0.1, k < 3 ? -0.1 : 0.1, -0.05}));
  config.bodies.push_back(at(body("plate", BodyKind::rigid, box({0.3, 0.3, 0.02})), {0, 0, 0.03}));
  const Scene scene = sampled(config);
  const auto simulation = simulate(scene);
  double speed = 0;
  for (int k = 0; k < 1000; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    speed = std::max(k < 80 ? 0 : speed, out.bodies[6].state.linear.norm());
  }
  EXPECT_LT(speed, 0.2);
  EXPECT_LT(simulation->output().bodies[6].state.linear.norm(), 1e-4);
  EXPECT_NEAR(simulation->output().bodies[6].state.position.z(), 0.01, 1e-3);
  EXPECT_TRUE(
      within(simulation->output().bodies[6].force.z() / (scene.bodies[6].mass * kGravity) - 1, tol::kStackForce));
}

// A belt carries a block along by its friction until it moves with it.
TEST(Contact, ABeltCarriesABlock) {
  Scene scene = level(0.4);
  scene.bodies[0].velocity = {0.5, 0, 0};
  const auto simulation = simulate(scene);
  const double t = 1, a = 0.4 * kGravity, until = 0.5 / a;
  run(*simulation, t);
  const double way = place_of_block(*simulation) + 0.85;
  EXPECT_TRUE(within(way / (0.5 * a * until * until + 0.5 * (t - until)) - 1, tol::kFrictionSlide));
}

TEST(Contact, RunsRepeatBitForBit) {
  const Scene scene = level(0.3);
  EXPECT_EQ(slide(scene, 0.4, {0.2, 0.1, 0.2}).way, slide(scene, 0.4, {0.2, 0.1, 0.2}).way);
  Scene tilted = scene;
  tilted.config.gravity = {4, 0, -9};
  const auto simulation = simulate(tilted);
  run(*simulation, 0.3);
  const double before = place_of_block(*simulation);
  simulation->reset();
  run(*simulation, 0.3);
  EXPECT_EQ(place_of_block(*simulation), before);
}

bool pays(const Scene& scene) {
  const auto simulation = simulate(scene);
  simulation->step({});
  const Footprint footprint = simulation->footprint();
  for (const auto& [name, bytes] : footprint.arrays)
    if (name.rfind("contact", 0) == 0) return true;
  for (const std::string& launch : footprint.launches)
    if (launch.find("contact") != std::string::npos) return true;
  return false;
}

// A solid that can touch no other costs nothing; two that can are one more launch, and no neighbours.
TEST(Contact, ScenesWithoutItPayNothing) {
  SceneConfig config = contact_scene(0.05, 0.3, 0.2);
  const BodyConfig water = at(body("water", BodyKind::fluid, box({0.4, 0.4, 0.4})), {0.5, 0.5, 0});
  const BodyConfig block = body("block", BodyKind::rigid, box({0.2, 0.2, 0.2}));
  const BodyConfig floor = at(body("floor", BodyKind::fixed, box({1, 1, 0.1})), {0, 0, -0.5});
  const BodyConfig wall = at(body("wall", BodyKind::fixed, box({1, 0.1, 1})), {0, 0.9, 0});
  config.bodies = {water, block};
  EXPECT_FALSE(pays(sampled(config)));
  config.bodies = {water, floor, wall};
  EXPECT_FALSE(pays(sampled(config)));
  config.bodies = {block, floor};
  EXPECT_TRUE(pays(sampled(config)));
  const auto simulation = simulate(sampled(config));
  simulation->step({});
  EXPECT_EQ(simulation->footprint().launches, (std::vector<std::string>{"begin", "contact", "wrench", "bodies"}));
  config.method = Method::paper;
  EXPECT_FALSE(pays(sampled(config)));
}

}  // namespace
}  // namespace palp::test::rigid_contact_test
