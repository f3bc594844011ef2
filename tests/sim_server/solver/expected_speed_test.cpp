// The speed that a plan is made for where a scene names none.
#include <cmath>

#include <gtest/gtest.h>

#include "sim_server/solver/plan.h"
#include "tests/support/scene_builder.h"

namespace palp::test::expected_speed_test {
namespace {

using namespace test;

// The sound speed suits the front of a breaking dam and what is thrown up, not only a fall through the depth.
TEST(ExpectedSpeed, IsTwiceThatOfAFallWhereAFluidRunsOff) {
  constexpr double deep = 0.4;
  SceneConfig config = scene(0.05);
  config.bodies.push_back(body("trough", BodyKind::fixed, box({1, 1, 0.6}, {0, 0, 0.2})));
  config.bodies[0].shapes.push_back(box({0.5, 0.5, 0.6}, {0, 0, 0.3}));
  config.bodies[0].shapes[1].subtract = true;
  config.bodies.push_back(body("water", BodyKind::fluid, box({0.5, 0.5, deep}, {0, 0, deep / 2})));
  const double fall = std::sqrt(2 * 9.81 * deep);
  EXPECT_NEAR(expected_speed(sample_scene(config, 100000)), fall, 1e-6);
  config.bodies[1].shapes[0].size.x() = 0.3;
  EXPECT_NEAR(expected_speed(sample_scene(config, 100000)), 2 * fall, 0.02);  // packed along its sides
}

}  // namespace
}  // namespace palp::test::expected_speed_test
