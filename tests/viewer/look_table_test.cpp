// The numbers of looks, as shaders take them.
#include "viewer/look_table.h"

#include <gtest/gtest.h>

#include <osg/Image>

namespace palp::test::look_table_test {
namespace {

const float* texels_of(const LookTable& table, int row) {
  return reinterpret_cast<const float*>(table.texture()->getImage()->data(0, row));
}

TEST(LookTable, ReflectionFollowsFromTheRefractiveIndex) {
  Look look;
  look.refractive_index = 1.5f;
  EXPECT_NEAR(surface_numbers(look)[2], 0.04, 1e-6);
  look.refractive_index = 1.333f;
  EXPECT_NEAR(surface_numbers(look)[2], 0.0204, 1e-4);
  look.refractive_index = 1;
  EXPECT_EQ(surface_numbers(look)[2], 0) << "what bends no light reflects none";
}

TEST(LookTable, BetweenTwoLooksAllNumbersAre) {
  const Look ice{true, 0.12f, 0, 1.31f, {2.2f, 0.9f, 0.5f}, 0.025f, 0}, water{true, 0.03f, 0, 1.333f, {}, 1e3f, 0};
  EXPECT_EQ(between(ice, water, 0), ice);
  const Look half = between(ice, water, 0.5f);
  EXPECT_FLOAT_EQ(half.roughness, 0.075f);
  EXPECT_FLOAT_EQ(half.absorption_per_m[0], 1.1f);
  EXPECT_NEAR(half.scattering_length, 0.1f, 2e-3f) << "half of the root of haze";
  EXPECT_FLOAT_EQ(between(ice, water, 1).roughness, water.roughness);
}

TEST(LookTable, LikeLooksShareARow) {
  LookTable table;
  Look honey, metal;
  honey.absorption_per_m = {5, 20, 80};
  honey.scattering_length = 0.1f;
  metal.metallic = 1;
  metal.roughness = 0.3f;
  EXPECT_EQ(table.row_of(honey), 0);
  EXPECT_EQ(table.row_of(metal), 1);
  EXPECT_EQ(table.row_of(honey), 0);
  EXPECT_EQ(texels_of(table, 0)[1], 20);
  EXPECT_FLOAT_EQ(texels_of(table, 0)[3], 10) << "of haze, 1/m";
  EXPECT_EQ(texels_of(table, 1)[4], 0.3f);
  EXPECT_EQ(texels_of(table, 1)[7], 1);
  EXPECT_EQ(table.depth_of(0), osg::Vec4f(5, 20, 80, 10));
  EXPECT_EQ(table.surface_of(1), surface_numbers(metal));
  table.clear();
  EXPECT_EQ(table.row_of(metal), 0);
}

TEST(LookTable, ManyLooksAndStrongOnesStayNumbersThatAPictureCanHold) {
  LookTable table;
  Look look;
  look.absorption_per_m = {kMostAbsorptionPerM, kMostAbsorptionPerM, kMostAbsorptionPerM};
  for (int i = 0; i < 300; ++i) {
    look.roughness = static_cast<float>(i) / 300;
    EXPECT_EQ(table.row_of(look), std::min(i, LookTable::kRows - 1));
  }
  // of a hundred particles of 10 mm, below the largest half float
  EXPECT_LE(texels_of(table, 7)[0] * 1.0f, 65504);
  EXPECT_LE(texels_of(table, 7)[3] * 1.0f, 65504);
}

}  // namespace
}  // namespace palp::test::look_table_test
