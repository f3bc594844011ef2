// The scene "dam_break_box": that a dam break on a box in a tank can be put as a scene, and what must hold of any.
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scene_files.h"
#include "tests/support/tolerance.h"

namespace palp::testing {
namespace {

class DamBreakOnABox : public ::testing::TestWithParam<Method> {};

TEST_P(DamBreakOnABox, ReachesTheBoxBehindRittersFront) {
  SceneOverrides overrides;
  overrides.accuracy = Accuracy::fast;
  overrides.method = GetParam();
  const Scene scene = sample_scene(load_scene(source_file("config/scenes/dam_break_box.toml"), overrides), 1000000);
  const Body &water = body_named(scene, "water"), &box = body_named(scene, "box");
  const auto box_index = static_cast<std::size_t>(&box - scene.bodies.data());
  const double face = 0.8245, ritter = (1.992 - face) / (2 * std::sqrt(9.81 * 0.55));
  const auto simulation = simulate(scene);
  Snapshot s;
  double arrival = 0, push = 0;
  std::uint32_t outside = 0;
  while (simulation->output().time < 0.7) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    outside = std::max(outside, out.health.outside);
    push = std::max(push, -out.bodies[box_index].force.x());
    if (arrival > 0 || out.step % 5 != 0) continue;
    simulation->snapshot(s);
    for (std::uint32_t i = water.first; i < water.first + water.count; ++i)
      if (s.position[3 * i] - 0.5 * scene.spacing < face) arrival = out.time;
  }
  EXPECT_GT(push, 0) << "the box is hit";
  EXPECT_TRUE(within(arrival > 0 ? std::max(0.0, ritter / arrival - 1) : NAN, tol::kRitter,
                     {"D3 dam break on a box (SPHERIC test 2): water at the box",
                      "not before Ritter's front, " + quantity(ritter, "s"), quantity(arrival, "s"), GetParam()}));
  EXPECT_TRUE(within(outside, tol::kNoParticle,
                     {"D3 dam break on a box (SPHERIC test 2): particles that leave the tank", "0",
                      quantity(outside, "of ") + quantity(water.count, ""), GetParam(),
                      "nothing but pressure keeps particles out of a wall: fast ones pass it"}));
}

INSTANTIATE_TEST_SUITE_P(Methods, DamBreakOnABox, ::testing::ValuesIn(methods()),
                         [](const auto& param) { return to_string(param.param); });

}  // namespace
}  // namespace palp::testing
