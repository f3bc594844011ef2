// Cylinders and tubes that roll: down slopes, on level floors, in a bore.
#include <algorithm>

#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::rolling_test {
namespace {

using Eigen::Vector3d;

// A round body that lies along y, of radius kRadius, and what it has of m r^2 as inertia.
struct Roller {
  const char* name;
  std::vector<ShapeConfig> shapes;
  double inertia;
};
constexpr double kRadius = 0.05;

std::vector<Roller> rollers() {
  const auto lying = [](ShapeConfig shape) {
    shape.orientation = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX());
    return shape;
  };
  const ShapeConfig full = lying(cylinder(kRadius, 0.1)), bore = cut(lying(cylinder(0.8 * kRadius, 0.12)));
  return {{"cylinder", {full}, 0.5},
          {"disc", {lying(cylinder(kRadius, 0.01))}, 0.5},
          {"tube", {full, bore}, 0.5 * (1 + 0.64)}};
}

Scene on_a_floor(const Roller& roller, double friction, double slope, double speed, double rim) {
  SceneConfig config = contact_scene(0.02, friction, 0.2);
  config.domain_max.x() = 4;
  config.gravity = {kGravity * std::sin(slope), 0, -kGravity * std::cos(slope)};
  BodyConfig round = at(body("round", BodyKind::rigid, roller.shapes[0]), {0, 0, kRadius}, {speed, 0, 0});
  round.shapes = roller.shapes;
  round.angular_velocity = {0, rim / kRadius, 0};
  config.bodies = {at(body("floor", BodyKind::fixed, box({4, 0.4, 0.08})), {1.8, 0, -0.04}), round};
  return sampled(config);
}

// Down a slope a round body rolls with g sin / (1 + I / m r^2), and slips with g (sin - mu cos) where that needs more
// friction than there is.
TEST(Rolling, RoundBodiesRollDownASlope) {
  for (const Roller& roller : rollers())
    for (const double degrees : {0.5, 15.0, 30.0})
      for (const double mu : {0.5, 0.1}) {
        SCOPED_TRACE(std::string(roller.name) + ", mu " + std::to_string(mu) + ", degrees " + std::to_string(degrees));
        const double slope = degrees * M_PI / 180, k = roller.inertia;
        const bool slips = std::tan(slope) > mu * (1 + 1 / k);
        const double expected = kGravity * (slips ? std::sin(slope) - mu * std::cos(slope) : std::sin(slope) / (1 + k));
        const auto simulation = simulate(on_a_floor(roller, mu, slope, 0, 0));
        const RigidState& round = simulation->output().bodies[1].state;
        run(*simulation, 0.1);
        const double before = round.linear.x();
        run(*simulation, 0.5);
        const double found = (round.linear.x() - before) / 0.5;
        EXPECT_TRUE(within(found / expected - 1, slips ? tol::kFrictionSlide : tol::kRolling,
                           {"Round bodies on slopes of 0.5 to 30 degrees: acceleration, the worst",
                            quantity(expected, "m/s^2"), quantity(found, "m/s^2")}));
        EXPECT_LT(std::abs(round.position.y()), 1e-5) << "it leaves its way";
      }
}

// On a level floor nothing slows a body that rolls, and its points are not felt as bumps; thrown without spin it comes
// to roll at 1 / (1 + I / m r^2) of its speed.
TEST(Rolling, RoundBodiesRollOn) {
  for (const Roller& roller : rollers()) {
    SCOPED_TRACE(roller.name);
    for (const double speed : {0.01, 0.1, 1.0}) {
      const auto simulation = simulate(on_a_floor(roller, 0.3, 0, speed, speed));
      const RigidState& round = simulation->output().bodies[1].state;
      run(*simulation, 0.5);
      const double before = round.linear.x();
      double low = 1, high = 0;
      for (int k = 0; k < 1500; ++k) {
        simulation->step({});
        low = std::min(low, round.position.z());
        high = std::max(high, round.position.z());
      }
      EXPECT_TRUE(within(round.linear.x() / before - 1, tol::kRolling)) << speed;
      EXPECT_TRUE(within((high - low) / kRadius, tol::kRollingBumps)) << speed;
    }
    const auto simulation = simulate(on_a_floor(roller, 0.3, 0, 1, 0));
    run(*simulation, 1);
    EXPECT_TRUE(within(simulation->output().bodies[1].state.linear.x() * (1 + roller.inertia) - 1, tol::kRolling));
  }
}

// A cylinder swings in a bore as a pendulum that rolls, and loses nothing.
TEST(Rolling, ACylinderSwingsInABore) {
  constexpr double gap = 0.2, start = 0.3;
  const Eigen::Quaterniond along_y(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX()));
  SceneConfig config = contact_scene(0.02, 0.5, 0.2);
  BodyConfig bore = body("bore", BodyKind::fixed, box({0.6, 0.3, 0.4}));
  bore.shapes.push_back(cut(cylinder(kRadius + gap, 0.4, {0, 0, gap})));
  bore.shapes.back().orientation = along_y;
  BodyConfig round = at(body("round", BodyKind::rigid, cylinder(kRadius, 0.1)),
                        {gap * std::sin(start), 0, gap * (1 - std::cos(start))});
  round.shapes[0].orientation = along_y;
  config.bodies = {bore, round};
  const auto simulation = simulate(sampled(config));
  const RigidState& state = simulation->output().bodies[1].state;
  double last = 0, widest = 0;
  std::vector<double> ups;  // times at which it passes the bottom towards x
  for (int k = 1; k <= 6000; ++k) {
    simulation->step({});
    const double x = state.position.x();
    if (last < 0 && x >= 0) ups.push_back(1e-3 * (k - x / (x - last)));
    if (k > 4800) widest = std::max(widest, std::abs(x));
    last = x;
  }
  ASSERT_GE(ups.size(), 4u);
  const double period = (ups.back() - ups.front()) / static_cast<double>(ups.size() - 1);
  const double expected = 2 * M_PI * std::sqrt(1.5 * gap / kGravity) * (1 + start * start / 16);
  EXPECT_TRUE(within(period / expected - 1, tol::kRolling));
  EXPECT_TRUE(within(widest / (gap * std::sin(start)) - 1, tol::kRollingSwing));
}

}  // namespace
}  // namespace palp::test::rolling_test
