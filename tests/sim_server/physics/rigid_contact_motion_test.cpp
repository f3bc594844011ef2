// Contact over longer times and in hollow solids: what rests stays, what is in stays in, nothing gains energy.
#include <algorithm>

#include "sim_server/geometry/contact_shape.h"
#include "sim_server/solver/plan.h"
#include "tests/sim_server/geometry/mesh_shape.h"
#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/scene_files.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::rigid_contact_motion_test {
namespace {

using Eigen::Vector3d;
constexpr double kCup = 0.08, kBall = 0.03;  // inner radius or half width of a cup, a ball's radius

// Cups with their floor's inside at z = 0, open to the top: boxes, cylinders, and the latter as a mesh.
std::vector<std::vector<ShapeConfig>> cups() {
  const double wide = 2 * kCup + 0.04;
  const std::vector<ShapeConfig> square{box({wide, wide, 0.2}, {0, 0, 0.08}),
                                        cut(box({2 * kCup, 2 * kCup, 0.3}, {0, 0, 0.15}))};
  const std::vector<ShapeConfig> round{cylinder(kCup + 0.02, 0.2, {0, 0, 0.08}),
                                       cut(cylinder(kCup, 0.3, {0, 0, 0.15}))};
  return {square, round, {as_mesh(round, "contact_cup.obj", 0.01)}};
}

TEST(ContactMotion, CupsHoldABall) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const std::vector<ShapeConfig>& shapes : cups())
    for (const bool free : {false, true}) {
      // known gap (ARCHITECTURE.md): a free mesh cup with walls of one spacing may let the ball out
      if (free && shapes[0].type == ShapeType::mesh) continue;
      SCOPED_TRACE(std::to_string(static_cast<int>(shapes[0].type)) + (free ? ", on a floor" : ", fixed"));
      SceneConfig config = contact_scene(0.02, 0.3, 0.4);
      config.numerics.max_speed = 2;
      BodyConfig cup = at(body("cup", free ? BodyKind::rigid : BodyKind::fixed, shapes[0]), {0, 0, 0});
      cup.shapes = shapes;
      config.bodies = {cup, at(body("ball", BodyKind::rigid, sphere(kBall)), {0, 0, 0.06},
                               {uniform(random, -1, 1), uniform(random, -1, 1), -1.5})};
      if (free) config.bodies.push_back(at(body("floor", BodyKind::fixed, box({0.8, 0.8, 0.04})), {0, 0, -0.04}));
      const Scene scene = sampled(config);
      const auto simulation = simulate(scene);
      // what holds the ball, on the mean over the last second, and how high it is at least: it may still roll to and
      // fro, a little up the wall, too
      double carried = 0, lowest = 1;
      for (int k = 0; k < 3000; ++k) {
        const StepOutput& out = simulation->step({});
        ASSERT_TRUE(out.health.ok) << out.health.cause;
        const Vector3d x =
            out.bodies[0].state.orientation.conjugate() * (out.bodies[1].state.position - out.bodies[0].state.position);
        ASSERT_LT(std::hypot(x.x(), x.y()), (shapes.size() == 2 && shapes[0].type == ShapeType::box ? 1.5 : 1) * kCup);
        ASSERT_GT(x.z(), 0.8 * kBall) << k;
        if (k < 2000) continue;
        carried += out.bodies[1].force.z() / 1000;
        lowest = std::min(lowest, out.bodies[1].state.position.z() - out.bodies[0].state.position.z());
      }
      EXPECT_NEAR(lowest, kBall, 1e-3);
      EXPECT_TRUE(within(carried / (scene.bodies[1].mass * kGravity) - 1, tol::kCarried));
    }
}

// Returns true when a body reaches into the walls at +-half, or is near another one: springs may hold something there
// even while dampers cancel their forces.
bool may_touch(const Scene& scene, const StepOutput& out, double half) {
  std::vector<std::pair<Vector3d, double>> balls;  // centre, radius: around each body
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (scene.bodies[b].type != BodyKind::rigid) continue;
    if (out.bodies[b].force.norm() > 0) return true;
    const RigidState& s = out.bodies[b].state;
    double reach = 0;
    // the points of a circle move along it
    for (const ContactRound& r : scene.bodies[b].contact->rounds) {
      const Eigen::Array3d x = (s.position + s.orientation * r.center).array(), axis = (s.orientation * r.axis).array();
      if ((x.abs() + r.reach * (1 - axis.square()).max(0).sqrt()).maxCoeff() > half) return true;
    }
    for (const ContactPoint& p : scene.bodies[b].contact->points) {
      const Vector3d x = s.position + s.orientation * p.position;
      if (x.cwiseAbs().maxCoeff() + p.radius > half) return true;
      reach = std::max(reach, p.position.norm() + p.radius);
    }
    for (const auto& [x, radius] : balls)
      if ((s.position - x).norm() < reach + radius) return true;
    balls.emplace_back(s.position, reach);
  }
  return false;
}

// Boxes tumble against walls and one another, rough or not: friction takes energy and gives none, and neither does a
// bounce. What a contact stores while it lasts is not counted, so energy is only ever less than it was.
TEST(ContactMotion, EnergyNeverGrows) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const double friction : {0.0, 0.3, 1.0})
    for (const double restitution : {0.0, 0.6}) {
      SCOPED_TRACE("friction " + std::to_string(friction) + ", restitution " + std::to_string(restitution));
      SceneConfig config = contact_scene(0.02, friction, restitution);
      config.gravity.setZero();
      config.numerics.max_speed = 2;
      BodyConfig room = body("room", BodyKind::fixed, box({0.6, 0.6, 0.6}));
      room.shapes.push_back(cut(box({0.5, 0.5, 0.5})));
      config.bodies.push_back(room);
      for (int k = 0; k < 4; ++k) {
        const ShapeConfig shape = k == 0 ? sphere(0.05) : k == 1 ? cylinder(0.04, 0.1) : box({0.1, 0.08, 0.06});
        BodyConfig one = at(body("body " + std::to_string(k), BodyKind::rigid, shape),
                            {0.13 * (k % 2 ? 1 : -1), 0.13 * (k / 2 ? 1 : -1), 0}, random_vector(random, 1.5));
        one.orientation = random_rotation(random);
        one.angular_velocity = random_vector(random, 10);
        config.bodies.push_back(one);
      }
      const Scene scene = sampled(config);
      const auto simulation = simulate(scene);
      const double start = energy(scene, simulation->step({}));
      double least = start, worst = 0;
      for (int k = 0; k < 2000; ++k) {
        const StepOutput& out = simulation->step({});
        ASSERT_TRUE(out.health.ok) << out.health.cause;
        if (may_touch(scene, out, 0.25)) continue;  // what springs hold is not in the sum
        const double now = energy(scene, out);
        worst = std::max(worst, now - least);
        least = std::min(least, now);
      }
      EXPECT_TRUE(within(worst / start, tol::kContactEnergy));
      EXPECT_LT(least, 0.9 * start);
    }
}

// A block that is placed on a slope below its angle of static friction stays, though kinetic friction could not hold
// it; above that angle it slides.
TEST(ContactMotion, ABlockPlacedOnASlopeStays) {
  for (const double restitution : {0.2, 0.6})
    for (const double part : {0.83, 0.97, 1.03}) {
      SCOPED_TRACE(std::to_string(restitution) + ", " + std::to_string(part) + " of the friction angle");
      SceneConfig config = contact_scene(0.02, 0.7, restitution);
      config.materials[0].kinetic_friction = 0.5;
      const double slope = part * std::atan(0.7);
      config.gravity = {kGravity * std::sin(slope), 0, -kGravity * std::cos(slope)};
      config.bodies = {at(body("plate", BodyKind::fixed, box({1.2, 0.4, 0.08})), {0.3, 0, -0.04}),
                       at(body("block", BodyKind::rigid, box({0.12, 0.08, 0.05})), {0, 0, 0.025})};
      const auto simulation = simulate(sampled(config));
      run(*simulation, 1);
      const double way = simulation->output().bodies[1].state.position.x();
      if (part < 1)
        EXPECT_LT(std::abs(way), 1e-3);
      else
        EXPECT_GT(way, 0.1);
    }
}

// A block that falls on a slope stays below the angle of static friction. What hops by more than a tenth of a
// millimetre ends in slipping, which kinetic friction must stop, too.
TEST(ContactMotion, ABlockThatFallsOnASlopeStays) {
  for (const double gap : {1e-4, 5e-3})
    for (const int sub_steps : {1, 4}) {
      SCOPED_TRACE(std::to_string(1e3 * gap) + " mm above, sub-steps " + std::to_string(sub_steps));
      SceneConfig config = contact_scene(0.02, 0.7, 0.2);
      config.materials[0].kinetic_friction = gap > 1e-3 ? 0.6 : 0.5;
      config.numerics.sub_steps = sub_steps;
      const double slope = 30 * M_PI / 180;
      config.gravity = {kGravity * std::sin(slope), 0, -kGravity * std::cos(slope)};
      config.bodies = {at(body("plate", BodyKind::fixed, box({1.2, 0.4, 0.08})), {0.3, 0, -0.04}),
                       at(body("block", BodyKind::rigid, box({0.12, 0.08, 0.05})), {0, 0, 0.025 + gap})};
      const auto simulation = simulate(sampled(config));
      const RigidState& block = simulation->output().bodies[1].state;
      run(*simulation, 0.5);
      const double way = block.position.x();
      EXPECT_LT(std::abs(way), 2 * std::abs(gap) + 2e-4);
      run(*simulation, 2);
      EXPECT_TRUE(within((block.position.x() - way) / 0.02, tol::kStackDrift));
    }
}

// A block thrown along a level plate at the start of a scene stops where kinetic friction stops it.
TEST(ContactMotion, AThrownBlockStopsWhereItShould) {
  constexpr double mu = 0.5, speed = 0.5, expected = speed * speed / (2 * mu * kGravity);
  SceneConfig config = contact_scene(0.02, mu, 0.2);
  config.bodies = {at(body("plate", BodyKind::fixed, box({1.2, 0.4, 0.08})), {0.3, 0, -0.04}),
                   at(body("block", BodyKind::rigid, box({0.12, 0.08, 0.05})), {0, 0, 0.025}, {speed, 0, 0})};
  const auto simulation = simulate(sampled(config));
  run(*simulation, 1);
  EXPECT_TRUE(within(simulation->output().bodies[1].state.position.x() / expected - 1, tol::kFrictionSlide));
}

// A stack beside a ball in a cup, for a minute.
TEST(ContactMotion, AMinuteOfRest) {
  constexpr double dx = 0.02;
  SceneConfig config = contact_scene(dx, 0.3, 0.2);
  config.bodies.push_back(at(body("floor", BodyKind::fixed, box({0.8, 0.4, 0.04})), {0, 0, -0.02}));
  BodyConfig cup = at(body("cup", BodyKind::rigid, cups()[0][0]), {0.2, 0, 0.02});
  cup.shapes = cups()[0];
  config.bodies.push_back(cup);
  config.bodies.push_back(at(body("ball", BodyKind::rigid, sphere(kBall)), {0.2, 0, kBall + 0.02}));
  config.bodies.push_back(at(body("can", BodyKind::rigid, cylinder(0.05, 0.1)), {-0.2, 0.12, 0.05}));
  for (int k = 0; k < 3; ++k)
    config.bodies.push_back(
        at(body("box " + std::to_string(k), BodyKind::rigid, box({0.1, 0.1, 0.08})), {-0.2, -0.08, 0.08 * k + 0.04}));
  const Scene scene = sampled(config);
  const auto simulation = simulate(scene);
  run(*simulation, 1);
  const std::vector<BodyOutput> settled = simulation->output().bodies;
  const double before = energy(scene, simulation->output());
  run(*simulation, 60);
  for (std::size_t b = 1; b < scene.bodies.size(); ++b) {
    const RigidState& now = simulation->output().bodies[b].state;
    EXPECT_LT((now.position - settled[b].state.position).norm(), 0.1 * dx) << scene.bodies[b].name;
    // nothing keeps a ball from turning where it lies
    if (scene.bodies[b].name != "ball") {
      EXPECT_LT(now.orientation.angularDistance(settled[b].state.orientation), 0.01) << scene.bodies[b].name;
    }
  }
  EXPECT_LE(energy(scene, simulation->output()) - before, 1e-3 * scene.bodies[1].mass * kGravity * dx);
}

// Balls, cans and boxes, turned at random, fall into a tray and come to rest there, hardly in one another.
TEST(ContactMotion, ManyBodiesSettleInATray) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  constexpr double dx = 0.02;
  SceneConfig config = contact_scene(dx, 0.4, 0.2);
  BodyConfig tray = body("tray", BodyKind::fixed, box({0.5, 0.5, 0.3}));
  tray.shapes.push_back(cut(box({0.4, 0.4, 0.3}, {0, 0, 0.05})));
  config.bodies.push_back(tray);
  for (int k = 0; k < 27; ++k) {
    const int row = k / 3, layer = k / 9;
    const ShapeConfig shape = k % 3 == 0 ? sphere(0.04) : k % 3 == 1 ? cylinder(0.03, 0.08) : box({0.08, 0.06, 0.05});
    BodyConfig one = at(body("body " + std::to_string(k), BodyKind::rigid, shape),
                        0.12 * Vector3d(k % 3 - 1, row % 3 - 1, layer) + random_vector(random, 0.005));
    one.orientation = random_rotation(random);
    config.bodies.push_back(one);
  }
  const Scene scene = sampled(config);
  const auto simulation = simulate(scene);
  const double start = energy(scene, simulation->step({}));
  run(*simulation, 4);
  const StepOutput& out = simulation->output();
  int slow = 0;
  for (std::size_t b = 1; b < scene.bodies.size(); ++b) {
    const Vector3d x = out.bodies[b].state.position;
    slow += out.bodies[b].state.linear.norm() < 0.02 ? 1 : 0;
    EXPECT_LT(std::max(std::abs(x.x()), std::abs(x.y())), 0.2) << scene.bodies[b].name;
    EXPECT_GT(x.z(), -0.1 + 0.02) << scene.bodies[b].name;
  }
  EXPECT_LT(energy(scene, out), start);
  EXPECT_GE(slow, 24) << "a ball may still roll";
}

// A flat tool on a plate that is a mesh.
TEST(ContactMotion, AMeshIsFlatToo) {
  SceneConfig config = contact_scene(0.01, 0, 0.2);
  config.bodies = {
      at(body("plate", BodyKind::fixed, as_mesh({box({0.6, 0.12, 0.02})}, "contact_plate.obj", 0.01)), {0, 0, -0.01})};
  add_flat_tool(config, Eigen::Quaterniond::Identity());
  const DrawnTool drawn = draw_flat_tool(*simulate(sampled(config)), Eigen::Quaterniond::Identity());
  EXPECT_GT(drawn.contact.low, 4);
  EXPECT_TRUE(within(drawn.contact.ripple(), tol::kRippleOfContact));
}

// The paper's section 6.1 in the scene of its figure 6: the ladle is lowered until the hand feels 5 N, drawn to the
// side for 1.6 s and raised. What the hand feels while it slides is flat.
TEST(ContactMotion, ALadleSlidesOverTheBlockInATray) {
  const Scene scene = scene_file("tray_rigid", Accuracy::balanced);
  const auto simulation = simulate(scene);
  StepInput input;
  input[0].engaged = true;
  input[0].gains = {2000, 40, 20, 0.4};
  double height = 0.62, pressed = 0, mean = 0, drawn = 0, low = 1e30, high = -1e30, friction = 0;
  double felt_low = 1e30, felt_high = -1e30;
  for (int k = 0; k < 4200; ++k) {
    mean += 0.05 * (pressed - mean);  // the knock at the first touch is not the hand's 5 N
    const bool lowering = mean < 5 && drawn == 0, drawing = !lowering && drawn < 1.6, raising = drawn >= 1.6;
    const double vertical = lowering ? (height > 0.575 ? -0.05 : -0.02) : raising ? 0.1 : 0;
    height += 1e-3 * vertical;
    drawn += drawing ? 1e-3 : 0;
    input[0].state.position = {-0.1 + 0.1 * drawn, 0, height};
    input[0].state.linear = {drawing ? 0.1 : 0, 0, vertical};
    const StepOutput& out = simulation->step(input);
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    pressed = out.proxies[0].contact_force.z();
    // hand and ladle have stopped swinging from the start; five centimetres are left
    if (drawing && drawn > 1.1) {
      low = std::min(low, pressed);
      high = std::max(high, pressed);
      felt_low = std::min(felt_low, out.proxies[0].force.z());
      felt_high = std::max(felt_high, out.proxies[0].force.z());
      friction = std::max(friction, std::abs(-out.proxies[0].contact_force.x() / pressed - 0.3));
    }
  }
  EXPECT_GT(drawn, 1.59);
  EXPECT_GT(low, 3);
  EXPECT_TRUE(within((felt_high - felt_low) / low, tol::kRipple,
                     {"D19 ladle drawn over the block of tray_rigid, mu = 0.3: ripple that the hand feels", "0",
                      quantity(1e3 * (felt_high - felt_low), "mN of ") + quantity(low, "N")}));
  EXPECT_TRUE(within((high - low) / low, tol::kRippleOfContact,
                     {"D19 ladle drawn over the block of tray_rigid, mu = 0.3: ripple of contact", "0",
                      quantity(1e3 * (high - low), "mN of ") + quantity(low, "N")}));
  EXPECT_TRUE(within(friction / 0.3, tol::kFrictionSlide));
  EXPECT_EQ(pressed, 0) << "raised again";
}

}  // namespace
}  // namespace palp::test::rigid_contact_motion_test
