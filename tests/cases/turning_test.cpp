// The torque of a viscous fluid on what turns in it: on a ball within a spherical shell and on a cylinder in a hole, in
// creeping flow, v = w x r (R / r)^3 and w R^2 / r with the wall taken into account (Landau & Lifshitz 1987, sections
// 18 and 20).
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scene_builder.h"
#include "tests/support/tolerance.h"

namespace palp::test::turning_test {
namespace {

constexpr double kSpacing = 0.01, kSpin = 1, kViscosity = 20, kGap = 2.5, kHigh = 9 * kSpacing;

struct Case {
  const char* name;
  bool round;     // a ball, else a cylinder
  double radius;  // [spacings]
  ViscosityScheme by;
  const Tolerance* allowed;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

ShapeConfig shape(const Case& c, double radius, bool subtract = false) {
  ShapeConfig out = c.round ? sphere(radius) : box(Eigen::Vector3d::Zero());
  out.subtract = subtract;
  if (c.round) return out;
  out.type = ShapeType::cylinder;
  out.radius = radius;
  out.height = kHigh;
  return out;
}

class Turning : public ::testing::TestWithParam<Case> {};

TEST_P(Turning, FeelsTheTorqueOfTheFluid) {
  const Case& c = GetParam();
  const double R = c.radius * kSpacing, hole = kGap * R, half = hole + 2 * kSpacing;
  SceneConfig config = scene(kSpacing);
  config.gravity.setZero();
  config.materials[0].density = 1000;
  config.materials[0].viscosity = kViscosity;
  config.numerics.support_over_spacing = 3;
  config.numerics.artificial_viscosity = 0;
  config.numerics.max_speed = 0.5;
  config.numerics.viscosity = c.by;
  config.domain_max = {half, half, c.round ? half : kHigh / 2};
  config.domain_min = -config.domain_max;
  config.periodic = {false, false, !c.round};
  BodyConfig shell = body("shell", BodyKind::fixed, box(2 * config.domain_max));
  shell.shapes.push_back(shape(c, hole, true));
  BodyConfig fluid = body("fluid", BodyKind::fluid, shape(c, hole));
  fluid.shapes.push_back(shape(c, R, true));
  BodyConfig turns = body("turns", BodyKind::rigid, shape(c, R));
  turns.angular_velocity = {0, 0, kSpin};
  config.bodies = {shell, turns, fluid};
  ProxyConfig proxy;
  proxy.body = "turns";
  proxy.coupling_limit = {2e4, 400, 2e3, 40};
  config.proxies = {proxy};
  const auto simulation = simulate(sample_scene(config, 1000000));
  const double settle = 3 * R * R * 1000 / kViscosity, average = settle / 4;
  double torque = 0;
  int count = 0;
  StepInput input;
  input[0].engaged = true;
  input[0].gains = {2e4, 400, 2e3, 40};
  while (simulation->output().time < settle + average) {
    const double angle = kSpin * simulation->output().time;
    input[0].state.orientation = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ());
    input[0].state.angular = {0, 0, kSpin};
    const StepOutput& out = simulation->step(input);
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    if (out.time < settle) continue;
    torque -= out.bodies[1].torque.z();
    ++count;
  }
  torque /= count;
  const double exact = c.round ? 8 * M_PI * kViscosity * R * R * R * kSpin / (1 - std::pow(kGap, -3))
                               : 4 * M_PI * kViscosity * kHigh * kSpin * R * R / (1 - std::pow(kGap, -2));
  EXPECT_TRUE(within(
      torque / exact - 1, *c.allowed,
      {std::string("Torque on a ") + c.name, quantity(exact, "N m"), quantity(torque, "N m"), Method::accurate}));
}

INSTANTIATE_TEST_SUITE_P(
    Bodies, Turning,
    ::testing::Values(Case{"ball_of_six_spacings", true, 6, ViscosityScheme::staged, &tol::kTurning},
                      Case{"cylinder_of_six_spacings", false, 6, ViscosityScheme::staged, &tol::kTurning},
                      Case{"cylinder_of_four_spacings_explicitly", false, 4, ViscosityScheme::explicit_,
                           &tol::kTurning},
                      Case{"cylinder_of_two_spacings", false, 2, ViscosityScheme::staged, &tol::kTurningCoarse}),
    [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace palp::test::turning_test
