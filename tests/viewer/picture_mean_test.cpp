#include "viewer/picture_mean.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palp::test {
namespace {

Picture gray(int level) { return {2, 1, std::vector<std::uint8_t>(6, static_cast<std::uint8_t>(level))}; }

TEST(PictureMean, OfEqualPicturesIsThatPicture) {
  for (int level = 0; level < 256; ++level) {
    PictureMean sum;
    for (int k = 0; k < 3; ++k) sum.add(gray(level));
    EXPECT_EQ(sum.mean().rgb, gray(level).rgb) << level;
  }
}

TEST(PictureMean, IsOfLightAndNotOfNumbers) {
  PictureMean sum;
  sum.add(gray(0));
  sum.add(gray(255));
  const Picture mean = sum.mean();
  EXPECT_EQ(mean.width, 2);
  EXPECT_EQ(mean.height, 1);
  EXPECT_EQ(mean.rgb, gray(188).rgb) << "sRGB of half of white's light is 187.5";
}

TEST(PictureMean, DisplacementsFillThePixelAndMoveNothingTogether) {
  EXPECT_EQ(displacement(0, 1), osg::Vec2d(0, 0));
  for (const int count : {2, 4, 9, 16, 64}) {
    osg::Vec2d sum;
    double most = 0, quadrants[2][2] = {};
    for (int k = 0; k < count; ++k) {
      const osg::Vec2d by = displacement(k, count);
      sum += by;
      most = std::max({most, std::abs(by.x()), std::abs(by.y())});
      quadrants[by.x() > 0][by.y() > 0] += 1;
    }
    EXPECT_LT(sum.length(), 1e-12) << count;
    EXPECT_LE(most, 0.5) << count;
    if (count < 16) continue;
    for (const auto& row : quadrants)
      for (const double quadrant : row) EXPECT_NEAR(quadrant / count, 0.25, 0.07) << count;
  }
}

}  // namespace
}  // namespace palp::test
