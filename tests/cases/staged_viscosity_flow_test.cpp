// Very viscous fluids, in stages: channel flows, drag on a sphere, a column at rest, a light tool that a hand moves.
#include <functional>

#include <gtest/gtest.h>

#include "sim_server/solver/plan.h"
#include "tests/support/backend.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"
#include "tests/support/towed_tool.h"

namespace palp::test::staged_viscosity_flow_test {
namespace {

// 1000 Pa s between walls 50 mm apart, periodic along x and y; a time unit L^2 / nu is 2.5 ms.
constexpr double kGap = 0.05, kViscosity = 1000, kDensity = 1000;

Scene channel(double support) {
  const double dx = kGap / 10, wall = 3 * dx, deep = 9 * dx;
  Scene scene = empty_scene(dx, {0, 0, -wall}, {deep, deep, kGap + wall});
  scene.config.periodic = {true, true, false};
  scene.config.gravity.setZero();
  scene.config.numerics.support_over_spacing = support;
  scene.config.numerics.artificial_viscosity = 0;
  scene.config.numerics.max_speed = 1;
  const auto batter = add_material(scene, kDensity, kViscosity);
  add_body(scene, "batter", BodyKind::fluid, batter, {0, 0, 0}, {deep, deep, kGap});
  add_body(scene, "bottom", BodyKind::fixed, batter, {0, 0, -wall}, {deep, deep, 0});
  add_body(scene, "top", BodyKind::fixed, batter, {0, 0, kGap}, {deep, deep, kGap + wall});
  scene.config.probes.push_back(probe_of("bottom"));
  return scene;
}

struct Flow {
  double worst = 0;  // difference of a speed from the profile
  double drag = 0;   // on the bottom [N]
  int stages = 0;
};

Flow run(const Scene& scene, double time, const std::function<double(double z)>& speed) {
  const auto simulation = simulate(scene);
  Flow flow;
  flow.stages = make_plan(scene).viscous_stages;
  while (simulation->output().time < time - 1e-9) {
    const StepOutput& out = simulation->step({});
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) break;
    flow.drag = out.bodies[1].force.x();
  }
  Snapshot s;
  simulation->snapshot(s);
  for (std::uint32_t i = 0; i < scene.bodies[0].count; ++i)
    flow.worst = std::max(flow.worst, std::abs(s.velocity[3 * i] - speed(s.position[3 * i + 2])));
  return flow;
}

class Batter : public ::testing::TestWithParam<double> {};

TEST_P(Batter, FlowsBetweenWallsAsCouetteAndPoiseuilleSay) {
  const double area = std::pow(9 * kGap / 10, 2);
  Scene couette = channel(GetParam());
  couette.bodies[2].velocity = {1, 0, 0};
  for (std::uint32_t i = 0; i < couette.bodies[2].count; ++i) couette.velocity[couette.bodies[2].first + i].x() = 1;
  const Flow dragged = run(couette, 0.02, [](double z) { return z / kGap; });
  EXPECT_GT(dragged.stages, 5);
  RecordProperty("stages", dragged.stages);
  RecordProperty("couette", std::to_string(dragged.worst));
  RecordProperty("couette_drag", std::to_string(dragged.drag / (kViscosity / kGap * area)));
  EXPECT_TRUE(within(dragged.worst, tol::kShearFlow));
  EXPECT_TRUE(within(dragged.drag / (kViscosity / kGap * area) - 1, tol::kShearFlow));
  Scene poiseuille = channel(GetParam());
  poiseuille.config.body_force = {8 * kViscosity / kDensity / (kGap * kGap), 0, 0};  // 1 m/s in the middle
  const Flow driven = run(poiseuille, 0.02, [](double z) { return 4 * z / kGap * (1 - z / kGap); });
  RecordProperty("poiseuille", std::to_string(driven.worst));
  RecordProperty("poiseuille_drag", std::to_string(driven.drag / (4 * kViscosity / kGap * area)));
  EXPECT_TRUE(within(driven.worst, tol::kShearFlow));
  EXPECT_TRUE(within(driven.drag / (4 * kViscosity / kGap * area) - 1, tol::kShearFlow));
}

INSTANTIATE_TEST_SUITE_P(Supports, Batter, ::testing::Values(2.0, 3.0),
                         [](const auto& param) { return "H_" + std::to_string(static_cast<int>(param.param)); });

// Batter that a body force drives past a sphere in a periodic box: in the end the drag balances that force, and is that
// of Hasimoto's array of spheres, 6 pi mu a U K.
TEST(BatterDrag, IsOfStokesOrder) {
  constexpr double dx = 0.015, side = 0.24, radius = 0.06, viscosity = 300;
  Scene scene = empty_scene(dx, {0, 0, 0}, {side, side, side});
  scene.config.periodic = {true, true, true};
  scene.config.gravity.setZero();
  scene.config.numerics.support_over_spacing = 2;
  scene.config.numerics.max_speed = 1;  // the pressure on the sphere squeezes the batter by less than 1 %
  const auto batter = add_material(scene, 1000, viscosity), steel = add_material(scene, 1000, 0);
  const Eigen::Vector3d center(side / 2, side / 2, side / 2);
  const auto inside = [&](const Eigen::Vector3d& x) { return (x - center).norm() < radius; };
  add_body(scene, "batter", BodyKind::fluid, batter, {0, 0, 0}, {side, side, side},
           [&](const Eigen::Vector3d& x) { return !inside(x); });
  const auto sphere = add_body(scene, "sphere", BodyKind::fixed, steel, {0, 0, 0}, {side, side, side}, inside);
  scene.config.probes.push_back(probe_of("sphere"));
  scene.config.body_force = {0, 0, 0.5};
  const auto simulation = simulate(scene);
  double drag = 0;
  while (simulation->output().time < 0.1) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    drag = out.bodies[sphere].force.z();
  }
  Snapshot s;
  simulation->snapshot(s);
  const Body& fluid = scene.bodies[0];
  double flux = 0;  // mean velocity over the whole box, that of the sphere being zero
  for (std::uint32_t i = 0; i < fluid.count; ++i) flux += s.velocity[3 * i + 2] * dx * dx * dx;
  const double U = flux / (side * side * side);
  const double a = std::cbrt(scene.bodies[sphere].volume * 3 / (4 * M_PI)), x = a / side;
  const double K = 1 / (1 - 2.8373 * x + 4.19 * x * x * x - 27.4 * std::pow(x, 6));
  const double stokes = 6 * M_PI * viscosity * a * U * K;
  RecordProperty("stages", make_plan(scene).viscous_stages);
  RecordProperty("drag_over_weight", std::to_string(drag / (0.5 * 1000 * fluid.volume)));
  RecordProperty("drag_over_hasimoto", std::to_string(drag / stokes));
  EXPECT_TRUE(within(drag / (0.5 * 1000 * fluid.volume) - 1, tol::kStokesBalance));
  EXPECT_TRUE(within(drag / stokes - 1, tol::kStokesDrag,
                     {"D8 Stokes drag of a sphere in a periodic box, a = 4 dx",
                      "6 pi mu a U K = " + quantity(stokes, "N (Hasimoto 1959)"), quantity(drag, "N")}));
}

// A tank of honey settles under a gravity that grows in: the pressure is that of any fluid, and nothing moves.
TEST(BatterAtRest, HasTheHydrostaticPressure) {
  constexpr double dx = 0.01, depth = 0.1, width = 0.12;
  Scene scene = empty_scene(dx, {-0.03, 0, -0.03}, {width + 0.03, 0.09, 0.2});
  scene.config.periodic = {false, true, false};
  scene.config.gravity_ramp = 0.1;
  const auto honey = add_material(scene, 1400, 1000);
  add_body(scene, "honey", BodyKind::fluid, honey, {0, 0, 0}, {width, 0.09, depth});
  add_tray(scene, honey, {0, 0, 0}, {width, 0.09, 0.13}, 0.03, {false, true, false});
  scene.config.probes.push_back(probe_of("tray"));
  ASSERT_GT(make_plan(scene).viscous_stages, 1);
  const auto simulation = simulate(scene);
  const StepOutput* out = nullptr;
  while (simulation->output().time < 0.6) {
    out = &simulation->step({});
    ASSERT_TRUE(out->health.ok) << out->health.cause;
  }
  Snapshot s;
  simulation->snapshot(s);
  const double bottom = 1400 * 9.81 * depth, weight = bottom * width * 0.09;
  double square = 0;
  for (std::uint32_t i = 0; i < scene.bodies[0].count; ++i)
    square += std::pow(s.pressure[i] - 1400 * 9.81 * (depth - s.position[3 * i + 2]), 2) / scene.bodies[0].count;
  RecordProperty("profile_rms", std::to_string(std::sqrt(square) / bottom));
  RecordProperty("wall_force_error", std::to_string(-out->bodies[1].force.z() / weight - 1));
  RecordProperty("speed", std::to_string(out->health.max_speed / std::sqrt(9.81 * depth)));
  EXPECT_TRUE(within(std::sqrt(square) / bottom, tol::kHydrostaticProfile));
  EXPECT_TRUE(within(-out->bodies[1].force.z() / weight - 1, tol::kWallForce));
  EXPECT_TRUE(within(out->health.max_speed / std::sqrt(9.81 * depth), tol::kRestingSpeed));
}

// A tool of 43 g in batter whose drag would stop it within a fraction of a sub-step: the hand that pulls it feels a
// steady force, which grows as the speed does.
TEST(BatterTool, IsPulledSteadily) {
  const auto pulled = [&](double speed) {
    const Scene scene = towed_tool(0.16, 1000);
    RecordProperty("stages", make_plan(scene).viscous_stages);
    const auto simulation = simulate(scene);
    StepInput input = towing_hand(scene, speed);
    std::vector<double> force;
    for (int k = 0; k < 250; ++k) {
      const StepOutput& out = simulation->step(input);
      EXPECT_TRUE(out.health.ok) << out.health.cause;
      if (!out.health.ok) return 0.0;
      input[0].state.position.x() += speed / scene.config.rate_hz;
      force.push_back(out.proxies[0].force.x());
    }
    // the batter's pressure builds up slowly; what would be felt as a rattle is the difference from three steps' mean
    double ripple = 0;
    for (std::size_t k = 50; k + 1 < force.size(); ++k)
      ripple = std::max(ripple, std::abs(force[k] - (force[k - 1] + force[k] + force[k + 1]) / 3));
    RecordProperty("force_at_" + std::to_string(speed), std::to_string(force.back()));
    RecordProperty("ripple_at_" + std::to_string(speed), std::to_string(ripple / std::abs(force.back())));
    EXPECT_LT(force.back(), 0) << "against the hand";
    EXPECT_TRUE(within(ripple / std::abs(force.back()), tol::kSteadyPull));
    return force.back();
  };
  const double slow = pulled(0.005), fast = pulled(0.01);
  EXPECT_TRUE(within(fast / (2 * slow) - 1, tol::kLinearDrag));
}

}  // namespace
}  // namespace palp::test::staged_viscosity_flow_test
