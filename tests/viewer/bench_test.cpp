// The benchmark of drawing: that it names and times what is drawn, and leaves the stage as it was.
#include "viewer/bench.h"

#include <gtest/gtest.h>

#include "tests/viewer/picture_tools.h"

namespace palp::test::bench_test {
namespace {

TEST(Bench, TimesEachPassOfAFluid) {
  Stage stage(small_stage(160, 120));
  const DrawingTimes times = time_drawing(stage, 500, Medium::clear, 0.1);
  EXPECT_EQ(times.particles, 500u);
  EXPECT_GT(times.seen, 0u);
  EXPECT_LE(times.seen, 500u);
  EXPECT_GE(times.pictures, 10u);
  EXPECT_GT(times.picture, 0);
  EXPECT_GE(times.slowest, times.picture);
  for (const char* pass : {"medium depth", "medium smoothing", "medium thickness", "shadow", "picture"}) {
    ASSERT_TRUE(times.passes.contains(pass)) << pass;
    EXPECT_GT(times.passes.at(pass), 0) << pass;
  }
  const std::string table = table_of(times);
  EXPECT_NE(table.find("500 particles"), std::string::npos);
  EXPECT_NE(table.find("medium smoothing"), std::string::npos);
}

TEST(Bench, OneTintNeedsNoPass) {
  Stage stage(small_stage(160, 120));
  const DrawingTimes times = time_drawing(stage, 500, Medium::opaque, 0.1);
  EXPECT_TRUE(times.passes.contains("medium depth"));
  EXPECT_EQ(times.passes.contains("medium tint") ? times.passes.at("medium tint") : 0, 0);
}

TEST(Bench, BeadsNeedNoPassOfSurfaces) {
  Stage stage(small_stage(160, 120));
  const DrawingTimes times = time_drawing(stage, 500, Medium::beads, 0.1);
  EXPECT_EQ(times.passes.contains("medium depth") ? times.passes.at("medium depth") : 0, 0);
  EXPECT_EQ(stage.scene().cloud().drawn(), 500u);
  const Picture picture = shoot(stage);
  EXPECT_EQ(picture.width, 160);
}

}  // namespace
}  // namespace palp::test::bench_test
