// The hand must not feel the particles' lattice: a tool drawn at an even speed over something soft, or through a fluid,
// shows no line at speed over spacing.
#include <gtest/gtest.h>

#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::lattice_ripple_test {
namespace {

using Eigen::Vector3d;
constexpr double kSpacing = 0.01, kLine = 1e-3 * kDrawSpeed / kSpacing;  // in cycles a step
constexpr const char* kPapersLattice =
    "contact is the pressure between two lattices of particles, which is the ripple of the paper's Fig. 4";

class LatticeLine : public ::testing::TestWithParam<Method> {};

ValidationCase row(const std::string& title, double line, double force, Method method) {
  return {title + ": line at speed / spacing", "0", quantity(1e3 * line, "mN of ") + quantity(force, "N"), method,
          kPapersLattice};
}

// A flat tool, pressed with about 6 N into jelly that is bonded to a plate.
TEST_P(LatticeLine, OverJelly) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (const double yaw : {0.0, uniform(random, 0.1, 0.7)}) {
    SceneConfig config = contact_scene(kSpacing, 0, 0.2);
    config.method = GetParam();
    config.materials[0].young_modulus = 5e4;
    config.materials[0].damping = 10;
    config.bodies = {at(body("plate", BodyKind::fixed, box({0.3, 0.08, 0.02})), {-0.05, 0, -0.04}),
                     at(body("jelly", BodyKind::elastic, box({0.3, 0.08, 0.03})), {-0.05, 0, -0.015})};
    config.bodies[1].bonded_to = {"plate"};
    const Eigen::Quaterniond orientation(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
    add_flat_tool(config, orientation);
    const DrawnTool drawn = draw_flat_tool(*simulate(sampled(config)), orientation, 0.0185, 1);
    ASSERT_FALSE(drawn.pressed.empty());
    EXPECT_GT(drawn.contact.low, 1);
    const double line = spectral_line(drawn.pressed, kLine);
    RecordProperty(yaw == 0 ? "ripple" : "ripple_turned", std::to_string(drawn.contact.ripple()));
    const bool along = yaw == 0;
    EXPECT_TRUE(
        within(line / drawn.contact.low, along ? tol::kSoftLatticeLineAlong : tol::kSoftLatticeLine,
               row(std::string("D19 flat tool drawn over jelly, ") + (along ? "along the lattice" : "turned at random"),
                   line, drawn.contact.low, GetParam())));
  }
}

// A block half under water, in a pool without end along its way.
TEST_P(LatticeLine, ThroughWater) {
  SceneConfig config = contact_scene(kSpacing, 0, 0.2);
  config.method = GetParam();
  config.accuracy = Accuracy::fast;
  config.domain_min = {-0.2, -0.06, -0.15};
  config.domain_max = {0.2, 0.06, 0.15};
  config.periodic = {true, true, false};
  config.bodies = {at(body("floor", BodyKind::fixed, box({0.4, 0.12, 0.03})), {0, 0, -0.115}),
                   at(body("water", BodyKind::fluid, box({0.4, 0.12, 0.1})), {0, 0, -0.05})};
  add_flat_tool(config, Eigen::Quaterniond::Identity());
  config.bodies[2].position = {-0.15, 0, 0.025};
  const auto simulation = simulate(sampled(config));
  const DrawnTool drawn = draw_flat_tool(*simulation, Eigen::Quaterniond::Identity(), 0, 1.3);
  ASSERT_FALSE(drawn.pressed.empty());
  double lift = 0;
  for (const double f : drawn.pressed) lift += f / static_cast<double>(drawn.pressed.size());
  const double line = spectral_line(drawn.pressed, kLine);
  RecordProperty("lift", std::to_string(lift));
  EXPECT_TRUE(
      within(line / lift, tol::kSoftLatticeLine, row("D19 block drawn half under water", line, lift, GetParam())));
}

INSTANTIATE_TEST_SUITE_P(Methods, LatticeLine, ::testing::ValuesIn(methods()),
                         [](const auto& param) { return to_string(param.param); });

}  // namespace
}  // namespace palp::test::lattice_ripple_test
