// The front of a collapsing column against Martin & Moyce 1952 (height twice the width) and Ritter's dry-bed speed.
#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::dam_break_test {
namespace {

constexpr const char* kPapersSurface =
    "density by summation falls short at free surfaces and walls, where particles then crowd and enter the wall";

class DamBreak : public ::testing::TestWithParam<Method> {};

TEST_P(DamBreak, FrontFollowsMartinAndMoyce) {
  constexpr double a = 0.1, dx = 0.01, wall = 3 * dx, deep = 9 * dx, reach = 0.5;
  Scene scene = empty_scene(dx, {-wall, 0, -wall}, {reach, deep, 0.3});
  scene.config.periodic = {false, true, false};
  scene.config.method = GetParam();
  const auto water = add_material(scene, 1000, 1e-3);
  add_body(scene, "water", BodyKind::fluid, water, {0, 0, 0}, {a, deep, 2 * a});
  add_body(scene, "tray", BodyKind::fixed, water, {-wall, 0, -wall}, {reach, deep, 2.3 * a},
           [](const Eigen::Vector3d& x) { return x.x() < 0 || x.z() < 0; });
  const auto simulation = simulate(scene);
  // T = t sqrt(2 g / a), Z = front / a
  const double measured[][2] = {{0.832, 1.217}, {1.219, 1.474}, {1.997, 2.292}, {2.547, 2.995}, {3.345, 4.134}};
  const double unit = std::sqrt(a / (2 * 9.81));
  Snapshot s;
  for (const auto& [T, Z] : measured) {
    const StepOutput* out = nullptr;
    do {
      out = &simulation->step({});
      ASSERT_TRUE(out->health.ok) << out->health.cause;
    } while (out->time < T * unit);
    simulation->snapshot(s);
    double front = 0, lowest = 1;
    for (std::uint32_t i = 0; i < scene.bodies[0].count; ++i) {
      front = std::max(front, s.position[3 * i] + 0.5 * dx);
      lowest = std::min(lowest, double(s.position[3 * i + 2]));
    }
    EXPECT_TRUE(within((front / a - Z) / Z, tol::kDamBreakFront,
                       {"D2 dam break: front at T = t sqrt(2 g / a) to 3.3, the worst",
                        "Z = x / a = " + quantity(Z, "at T = ") + quantity(T, "(Martin & Moyce 1952)"),
                        "Z = " + quantity(front / a, ""), GetParam(), kPapersSurface}))
        << "T = " << T;
    EXPECT_LT(front / a, 1 + 2 * T + dx / a) << "faster than Ritter's front";
    EXPECT_TRUE(within(std::max(0.0, -lowest) / dx, tol::kThroughFloor,
                       {"D2 dam break: how deep particles enter the floor", "0",
                        quantity(std::max(0.0, -1e3 * lowest), "mm"), GetParam(), kPapersSurface}));
    RecordProperty("front_at_" + std::to_string(T), std::to_string(front / a));
  }
  EXPECT_EQ(simulation->step({}).health.outside, 0u);
}

INSTANTIATE_TEST_SUITE_P(Methods, DamBreak, ::testing::ValuesIn(methods()),
                         [](const auto& param) { return to_string(param.param); });

}  // namespace
}  // namespace palp::test::dam_break_test
