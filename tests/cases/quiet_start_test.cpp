// The first moments of a scene whose tool stands in a fluid: a hand feels nothing but the lift.
#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/tolerance.h"
#include "tests/support/tool_in_tray.h"

namespace palp::test::quiet_start_test {
namespace {

struct Start {
  Accuracy accuracy;
  double z;  // of the middle of the tool's bowl, whose radius is 5 cm; the oil is 16 cm deep [m]
};

void PrintTo(const Start& start, std::ostream* out) { *out << to_string(start.accuracy) << " at " << start.z << " m"; }

class QuietStart : public ::testing::TestWithParam<Start> {};

TEST_P(QuietStart, OfAToolInAFluid) {
  const Scene scene = sample_scene(tool_in_tray(GetParam().accuracy, GetParam().z), 100000);
  const auto simulation = simulate(scene);
  const StepOutput& out = simulation->step({});
  // fluids take some haptic steps at once, in the first of them
  const double elapsed = simulation->fluid_interval() / scene.config.rate_hz;
  EXPECT_TRUE(within(out.health.max_speed / elapsed, tol::kStartAcceleration));
  double least = 1e30, most = 0, mean = 0;
  constexpr int kSteps = 100;
  for (int k = 0; k < kSteps; ++k) {
    const double lift = simulation->step({}).proxies[0].contact_force.z();
    least = std::min(least, lift);
    most = std::max(most, lift);
    mean += lift / kSteps;
  }
  RecordProperty("least", std::to_string(least));
  RecordProperty("most", std::to_string(most));
  EXPECT_TRUE(within((most - least) / mean, tol::kStartForce));
}

INSTANTIATE_TEST_SUITE_P(Tools, QuietStart,
                         ::testing::Values(Start{Accuracy::fast, 0.13}, Start{Accuracy::fast, 0.07},
                                           Start{Accuracy::balanced, 0.155}, Start{Accuracy::balanced, 0.13},
                                           Start{Accuracy::accurate, 0.11}));

}  // namespace
}  // namespace palp::test::quiet_start_test
