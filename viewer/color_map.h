// Colour maps and the range of values that they span.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "idl/messages.h"

namespace palp {

struct Rgb8 {
  std::uint8_t r = 0, g = 0, b = 0;
  bool operator==(const Rgb8&) const = default;
};

// Maps that people who see two of the three primaries can read, too. sequential: lightness rises evenly from deep blue
// to pale yellow. diverging: blue, light grey in the middle, red; for deviations from a rest value. viridis, cividis:
// close to matplotlib's maps of these names.
enum class ColorMapKind { sequential, diverging, viridis, cividis };
inline constexpr std::array<std::string_view, 4> kColorMapNames{"sequential", "diverging", "viridis", "cividis"};

inline constexpr int kColorMapSize = 256;
std::array<Rgb8, kColorMapSize> color_map(ColorMapKind kind);

// Returns the perceived lightness (the L of Oklab), 0 black .. 1 white.
double lightness(Rgb8 color);

// The values at the two ends of a map, low < high, in the field's SI unit.
struct ValueRange {
  double low = 0;
  double high = 1;
  bool operator==(const ValueRange&) const = default;
};

// Returns what the colour of a particle shows: the field's name, "body" for none.
std::string_view legend_name(ScalarField field);
// Returns the map that suits the field.
ColorMapKind color_map_of(ScalarField field);

// Returns the smallest of 1, 2, 5 times a power of ten that is not below value. value > 0.
double nice_ceiling(double value);

// Returns a range that suits the values, the outermost two percent at each end aside, with ends that are round numbers.
// Speed begins at zero; density lies evenly about rest_density when that is positive.
ValueRange suitable_range(ScalarField field, std::span<const float> values, double rest_density);

// Keeps a range until values leave it or fill less than two fifths of it, so that colours do not flicker.
class SteadyRange {
 public:
  const ValueRange& update(ScalarField field, const ValueRange& suitable);

 private:
  ScalarField field_ = ScalarField::none;
  ValueRange range_;
};

}  // namespace palp
