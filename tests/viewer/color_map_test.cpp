// Colour maps and the range of values that they span.
#include "viewer/color_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace palp::test {
namespace {

TEST(ColorMap, LightnessOfTheSequentialMapRisesEvenly) {
  const auto map = color_map(ColorMapKind::sequential);
  const double first = lightness(map.front()), last = lightness(map.back());
  EXPECT_GT(last - first, 0.5);
  for (int i = 0; i < kColorMapSize; ++i) {
    const double even = first + (last - first) * i / (kColorMapSize - 1);
    EXPECT_NEAR(lightness(map[static_cast<std::size_t>(i)]), even, 0.02) << "entry " << i;
  }
}

// Returns what remains of a colour for eyes without the middle cones (Machado, Oliveira and Fernandes, 2009).
Rgb8 seen_by_deuteranope(Rgb8 c) {
  const auto linear = [](std::uint8_t v) { return std::pow(v / 255.0, 2.2); };
  const double r = linear(c.r), g = linear(c.g), b = linear(c.b);
  const auto byte = [](double v) {
    return static_cast<std::uint8_t>(std::lround(255 * std::pow(std::clamp(v, 0.0, 1.0), 1 / 2.2)));
  };
  return {byte(0.367322 * r + 0.860646 * g - 0.227968 * b), byte(0.280085 * r + 0.672501 * g + 0.047413 * b),
          byte(-0.011820 * r + 0.042940 * g + 0.968881 * b)};
}

int difference(Rgb8 a, Rgb8 b) { return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b); }

TEST(ColorMap, LightnessRisesAllAlongEveryMapButTheDivergingOne) {
  for (const ColorMapKind kind : {ColorMapKind::sequential, ColorMapKind::viridis, ColorMapKind::cividis}) {
    const auto map = color_map(kind);
    // a step of a byte may take 0.004 of lightness back
    for (std::size_t i = 0; i + 1 < map.size(); ++i) EXPECT_GT(lightness(map[i + 1]), lightness(map[i]) - 0.004);
    EXPECT_GT(lightness(map.back()) - lightness(map.front()), 0.55);
  }
}

TEST(ColorMap, EveryMapCanBeReadWithoutTheMiddleCones) {
  for (std::size_t k = 0; k < kColorMapNames.size(); ++k) {
    const auto map = color_map(static_cast<ColorMapKind>(k));
    for (std::size_t a = 0; a < map.size(); a += 15) {
      for (std::size_t b = a + 15; b < map.size(); b += 15) {
        EXPECT_GT(difference(seen_by_deuteranope(map[a]), seen_by_deuteranope(map[b])), 12)
            << kColorMapNames[k] << " at " << a << " and " << b;
      }
    }
  }
}

TEST(ColorMap, ViridisBeginsAndEndsAsItsModel) {
  const auto map = color_map(ColorMapKind::viridis);
  EXPECT_LT(difference(map.front(), {0x44, 0x01, 0x54}), 12);
  EXPECT_LT(difference(map[128], {0x21, 0x90, 0x8c}), 15);
  EXPECT_LT(difference(map.back(), {0xfd, 0xe7, 0x25}), 12);
}

TEST(ColorMap, TheDivergingMapIsLightInTheMiddleAndEvenToBothSides) {
  const auto map = color_map(ColorMapKind::diverging);
  for (std::size_t i = 0; i < kColorMapSize / 2; ++i) {
    EXPECT_NEAR(lightness(map[i]), lightness(map[kColorMapSize - 1 - i]), 0.02);
    EXPECT_LE(lightness(map[i]), lightness(map[i + 1]) + 0.004);
  }
  EXPECT_GT(map.front().b, map.front().r + 80);
  EXPECT_GT(map.back().r, map.back().b + 80);
}

TEST(ColorMap, RangesEndAtRoundNumbersAndHoldTheValues) {
  EXPECT_DOUBLE_EQ(nice_ceiling(0.3), 0.5);
  EXPECT_DOUBLE_EQ(nice_ceiling(1), 1);
  EXPECT_DOUBLE_EQ(nice_ceiling(5.1), 10);
  const std::vector<float> speeds{0.1f, 0.2f, 0.31f};
  EXPECT_EQ(suitable_range(ScalarField::speed, speeds, 0), (ValueRange{0, 0.5}));
  const std::vector<float> densities{997, 1001, 1004};
  EXPECT_EQ(suitable_range(ScalarField::density, densities, 1000), (ValueRange{995, 1005}));
  const std::vector<float> pressures{-120, 15, 430};
  const ValueRange range = suitable_range(ScalarField::pressure, pressures, 0);
  EXPECT_EQ(range, (ValueRange{-200, 600}));
  EXPECT_EQ(suitable_range(ScalarField::density_error, std::vector<float>{-0.001f, 0.004f}, 1000),
            (ValueRange{-0.005, 0.005}));
  EXPECT_EQ(suitable_range(ScalarField::density_error, std::vector<float>(5, 0.0f), 1000), (ValueRange{-0.001, 0.001}));
  EXPECT_EQ(suitable_range(ScalarField::state, std::vector<float>(5, 0.9f), 1000), (ValueRange{0, 1}));
  const std::vector<float> bad{std::nanf(""), INFINITY};
  const ValueRange none = suitable_range(ScalarField::speed, bad, 0);
  EXPECT_LT(none.low, none.high);
  EXPECT_LT(suitable_range(ScalarField::pressure, std::vector<float>(5, 7.0f), 0).low, 7.1);
  const ValueRange alike = suitable_range(ScalarField::temperature, std::vector<float>(5, 293.0f), 0);
  EXPECT_GE(alike.high - alike.low, 1) << "noise of a microkelvin is no picture";
  EXPECT_LE(alike.high - alike.low, 2);
}

TEST(ColorMap, AFewOutliersDoNotStretchTheRange) {
  std::vector<float> densities;
  for (int i = 0; i < 1000; ++i) densities.push_back(i % 60 == 0 ? 300.0f : 996.0f + static_cast<float>(i % 9));
  EXPECT_EQ(suitable_range(ScalarField::density, densities, 1000), (ValueRange{995, 1005}));
}

TEST(ColorMap, ARangeStaysUntilItNoLongerFits) {
  SteadyRange steady;
  EXPECT_EQ(steady.update(ScalarField::speed, {0, 1}), (ValueRange{0, 1}));
  EXPECT_EQ(steady.update(ScalarField::speed, {0, 0.5}), (ValueRange{0, 1}));
  EXPECT_EQ(steady.update(ScalarField::speed, {0, 2}), (ValueRange{0, 2}));
  EXPECT_EQ(steady.update(ScalarField::speed, {0, 0.5}), (ValueRange{0, 0.5}));
  EXPECT_EQ(steady.update(ScalarField::density, {990, 1010}), (ValueRange{990, 1010}));
}

}  // namespace
}  // namespace palp::test
