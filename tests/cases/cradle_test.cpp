// Newton's cradle: five balls in a row, a hair apart; one that comes sends one away.
#include <gtest/gtest.h>

#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::cradle_test {
namespace {

TEST(Cradle, OneBallComesAndOneGoes) {
  constexpr double radius = 0.05, gap = 2e-3, v = 0.5;
  SceneConfig config = contact_scene(0.02, 0, 1);
  config.gravity.setZero();
  for (int k = 0; k < 5; ++k)
    config.bodies.push_back(at(body("ball " + std::to_string(k), BodyKind::rigid, sphere(radius)),
                               {(2 * radius + gap) * (k - 2) - (k == 0 ? 0.02 : 0), 0, 0}, {k == 0 ? v : 0, 0, 0}));
  const auto simulation = simulate(sampled(config));
  run(*simulation, 0.3);
  const std::vector<BodyOutput>& balls = simulation->output().bodies;
  double worst = 0;
  for (std::size_t k = 0; k < 4; ++k) worst = std::max(worst, balls[k].state.linear.norm());
  EXPECT_TRUE(within(balls[4].state.linear.x() / v - 1, tol::kRestitution,
                     {"D16 Newton's cradle, e = 1: speed of the last ball", quantity(v, "m/s"),
                      quantity(balls[4].state.linear.x(), "m/s")}));
  EXPECT_TRUE(within(worst / v, tol::kRestitution,
                     {"D16 Newton's cradle, e = 1: fastest of the four others", "0", quantity(worst, "m/s")}));
}

}  // namespace
}  // namespace palp::test::cradle_test
