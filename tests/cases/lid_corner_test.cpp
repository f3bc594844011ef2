// A lid drives a viscous fluid into the corner below it, where two solids press on and drag the same particles.
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/lid.h"

namespace palp::test::lid_corner_test {
namespace {

// viscosity [Pa s] and sound speed [m/s]: sub-steps that sound sets, that viscosity sets, and between; then stages, by
// which the drag of walls is not limited.
struct Fluid {
  const char* name;
  double viscosity, sound_speed;
  ViscosityScheme scheme = ViscosityScheme::explicit_;
  double support_over_spacing = 3;
};
void PrintTo(const Fluid& fluid, std::ostream* out) { *out << fluid.name; }

class LidCorner : public ::testing::TestWithParam<Fluid> {};

TEST_P(LidCorner, KeepsItsFluidCalm) {
  Scene scene = box_with_lid({0.12, 0.01, GetParam().viscosity, true});
  scene.config.numerics.support_over_spacing = GetParam().support_over_spacing;
  scene.config.numerics.sound_speed = GetParam().sound_speed;
  scene.config.numerics.viscosity = GetParam().scheme;
  scene.config.numerics.tension = false;  // which draws particles together in pairs where the lid sucks
  const auto simulation = simulate(scene);
  double fastest = 0;
  for (int k = 0; k < 100; ++k) {
    fastest = std::max(fastest, simulation->step({}).health.max_speed);
    ASSERT_LT(fastest, 1.05) << "after " << k << " steps; no particle can outrun the lid";
  }
  EXPECT_GT(fastest, 0.6);
}

INSTANTIATE_TEST_SUITE_P(Fluids, LidCorner,
                         ::testing::Values(Fluid{"sound", 5, 20}, Fluid{"both", 10, 10}, Fluid{"between", 25, 20},
                                           Fluid{"viscosity", 50, 20}, Fluid{"stages", 50, 20, ViscosityScheme::staged},
                                           Fluid{"thick", 200, 20, ViscosityScheme::staged},
                                           Fluid{"short_reach", 50, 20, ViscosityScheme::staged, 2}),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace palp::test::lid_corner_test
