// A scene pays only for what it contains: arrays and launches by scene.
#include <gtest/gtest.h>

#include "tests/support/contents.h"
#include "tests/support/scenes.h"

namespace palp::test::lightness_test {
namespace {

TEST(Lightness, AFluidAlonePaysForNothingElse) {
  const Contents c = contents_of(pool_of_water());
  for (const std::string& name : c.arrays)
    for (const char* of_others : {"wall", "solid", "bodies", "temperature", "frame"})
      EXPECT_EQ(name.find(of_others), std::string::npos) << name;
  const Names expected{"sort", "density", "fluid force", "move", "health"};
  EXPECT_EQ(c.launches, expected);
}

TEST(Lightness, AWallAddsItsArraysAndOneStage) {
  const Contents base = contents_of(pool_of_water());
  Scene scene = pool_of_water();
  add_tray(scene, 0, {-0.2, -0.2, 0}, {0.2, 0.2, 0.4}, 0.15);
  const Contents c = contents_of(scene);
  EXPECT_EQ(added(base.arrays, c.arrays), (Names{"wall", "bodies"}));
  EXPECT_EQ(added(base.launches, c.launches), (Names{"walls"}));
}

TEST(Lightness, ABodyAddsItsArraysAndStages) {
  const Contents base = contents_of(pool_of_water());
  Scene scene = pool_of_water();
  add_body(scene, "box", BodyKind::rigid, 0, {-0.1, -0.1, 0.3}, {0.1, 0.1, 0.4});
  const Contents c = contents_of(scene);
  EXPECT_EQ(added(base.arrays, c.arrays),
            (Names{"wall", "bodies", "solid force", "solid local", "reactive bodies", "rigid bodies"}));
  EXPECT_EQ(added(base.launches, c.launches), (Names{"begin", "walls", "solid force", "wrench", "bodies"}));
}

TEST(Lightness, ATemperatureAddsItsArrays) {
  const Contents base = contents_of(pool_of_water());
  Scene scene = pool_of_water();
  scene.temperature.assign(scene.position.size(), 293);
  const Contents c = contents_of(scene);
  EXPECT_EQ(added(base.arrays, c.arrays), (Names{"state temperature", "sorted temperature"}));
  EXPECT_TRUE(added(base.launches, c.launches).empty());
}

TEST(Lightness, ABodyAloneNeedsNoFluidStages) {
  Scene scene = empty_scene(0.05, {-1, -1, -1}, {1, 1, 1});
  add_material(scene, 500, 0);
  add_body(scene, "box", BodyKind::rigid, 0, {-0.1, -0.1, 0}, {0.1, 0.1, 0.2});
  const Contents c = contents_of(scene);
  EXPECT_FALSE(c.arrays.count("wall"));
  EXPECT_FALSE(c.arrays.count("acceleration"));
  for (const char* stage : {"fluid force", "walls"}) EXPECT_FALSE(c.launches.count(stage)) << stage;
}

TEST(Lightness, AFrameIsPaidForWhenAskedFor) {
  const auto simulation = simulate(pool_of_water());
  simulation->step({});
  const std::size_t before = simulation->footprint().arrays.size();
  const Frame frame = frame_of(*simulation, ScalarField::none);
  EXPECT_EQ(simulation->footprint().arrays.size(), before + 1) << "positions only";
  EXPECT_EQ(frame.position.size(), 3 * simulation->scene().position.size());
  EXPECT_TRUE(frame.scalar.empty());
  ASSERT_TRUE(simulation->begin_frame(ScalarField::speed));
  EXPECT_EQ(simulation->footprint().arrays.size(), before + 2);
}

TEST(Lightness, StepsAllocateNothingMore) {
  const auto simulation = simulate(pool_of_water());
  simulation->step({});
  const Footprint before = simulation->footprint();
  for (int k = 0; k < 5; ++k) simulation->step({});
  EXPECT_EQ(simulation->footprint().bytes(), before.bytes());
  EXPECT_EQ(simulation->footprint().launches, before.launches);
}

}  // namespace
}  // namespace palp::test::lightness_test
