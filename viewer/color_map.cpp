#include "viewer/color_map.h"

#include <algorithm>
#include <cmath>

#include "config/srgb.h"

namespace palp {
namespace {

// Oklab (B. Ottosson, 2020): equal steps look equal, so maps are drawn as polylines in it.
struct Lab {
  double l, a, b;
};

Rgb8 to_rgb(const Lab& c) {
  const double l = std::pow(c.l + 0.3963377774 * c.a + 0.2158037573 * c.b, 3);
  const double m = std::pow(c.l - 0.1055613458 * c.a - 0.0638541728 * c.b, 3);
  const double s = std::pow(c.l - 0.0894841775 * c.a - 1.2914855480 * c.b, 3);
  const auto byte = [](double v) {
    return static_cast<std::uint8_t>(std::lround(255 * srgb_of_light(std::clamp(v, 0.0, 1.0))));
  };
  return {byte(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          byte(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          byte(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

constexpr Lab kSequential[] = {{0.36, 0.005, -0.130},
                               {0.51, -0.055, -0.105},
                               {0.66, -0.110, -0.005},
                               {0.81, -0.095, 0.110},
                               {0.96, -0.015, 0.115}};
constexpr Lab kDiverging[] = {
    {0.42, -0.020, -0.150}, {0.66, -0.045, -0.095}, {0.92, 0.000, 0.000}, {0.66, 0.110, 0.075}, {0.42, 0.140, 0.070}};

constexpr Lab kViridis[] = {{0.285, 0.102, -0.091},  {0.373, 0.053, -0.115},  {0.448, -0.007, -0.098},
                            {0.520, -0.055, -0.061}, {0.594, -0.092, -0.018}, {0.667, -0.125, 0.033},
                            {0.746, -0.140, 0.099},  {0.830, -0.112, 0.158},  {0.918, -0.039, 0.182}};
constexpr Lab kCividis[] = {{0.253, -0.020, -0.089},
                            {0.423, -0.002, -0.052},
                            {0.583, -0.000, 0.005},
                            {0.750, -0.012, 0.084},
                            {0.927, -0.035, 0.170}};

std::span<const Lab> stops_of(ColorMapKind kind) {
  switch (kind) {
    case ColorMapKind::diverging:
      return kDiverging;
    case ColorMapKind::viridis:
      return kViridis;
    case ColorMapKind::cividis:
      return kCividis;
    case ColorMapKind::sequential:
      break;
  }
  return kSequential;
}

double round_to(double value, double step, bool up) {
  const double n = value / step;
  return step * (up ? std::ceil(n - 1e-9) : std::floor(n + 1e-9));
}

}  // namespace

std::array<Rgb8, kColorMapSize> color_map(ColorMapKind kind) {
  const std::span<const Lab> stops = stops_of(kind);
  std::array<Rgb8, kColorMapSize> map;
  for (int i = 0; i < kColorMapSize; ++i) {
    const double t = static_cast<double>(i) / (kColorMapSize - 1) * static_cast<double>(stops.size() - 1);
    const auto k = std::min(static_cast<std::size_t>(t), stops.size() - 2);
    const double f = t - static_cast<double>(k);
    const auto mix = [f](double x, double y) { return x + f * (y - x); };
    map[static_cast<std::size_t>(i)] =
        to_rgb({mix(stops[k].l, stops[k + 1].l), mix(stops[k].a, stops[k + 1].a), mix(stops[k].b, stops[k + 1].b)});
  }
  return map;
}

double lightness(Rgb8 color) {
  const double r = light_of_srgb(color.r / 255.0), g = light_of_srgb(color.g / 255.0),
               b = light_of_srgb(color.b / 255.0);
  return 0.2104542553 * std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b) +
         0.7936177850 * std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b) -
         0.0040720468 * std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
}

std::string_view legend_name(ScalarField field) {
  return field == ScalarField::none ? std::string_view("body") : row_of(field).name;
}

ColorMapKind color_map_of(ScalarField field) {
  const bool about_rest = field == ScalarField::density || field == ScalarField::density_error;
  return about_rest ? ColorMapKind::diverging : ColorMapKind::sequential;
}

double nice_ceiling(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (value <= step * power * (1 + 1e-9)) return step * power;
  }
  return 10 * power;
}

ValueRange suitable_range(ScalarField field, std::span<const float> values, double rest_density) {
  // a few thousand samples say enough
  std::vector<float> sample;
  const std::size_t stride = values.size() / 4096 + 1;
  for (std::size_t i = 0; i < values.size(); i += stride) {
    if (std::isfinite(values[i])) sample.push_back(values[i]);
  }
  if (sample.empty()) return {};
  std::sort(sample.begin(), sample.end());
  const std::size_t aside = sample.size() / 50;  // drops that fly, particles at a corner
  const double low = sample[aside];
  const double high = sample[sample.size() - 1 - aside];
  if (field == ScalarField::speed) return {0, nice_ceiling(std::max(high, 1e-3))};
  if (field == ScalarField::density && rest_density > 0) {
    const double off = std::max({high - rest_density, rest_density - low, 1e-3 * rest_density});
    const double half = nice_ceiling(off);
    return {rest_density - half, rest_density + half};
  }
  if (field == ScalarField::density_error) {
    const double half = nice_ceiling(std::max({high, -low, 1e-3}));
    return {-half, half};
  }
  if (field == ScalarField::state) return {0, 1};
  // about a field that is the same everywhere; differences below this [Pa], [K] mean nothing
  const double least = std::max(1.0, 1e-6 * std::abs(high)), wider = std::max(0.0, least - (high - low)) / 2;
  const double step = nice_ceiling((high - low + 2 * wider) / 5);
  const double from = round_to(low - wider, step, false);
  return {from, std::max(round_to(high + wider, step, true), from + step)};
}

const ValueRange& SteadyRange::update(ScalarField field, const ValueRange& suitable) {
  const bool left = suitable.low < range_.low || suitable.high > range_.high;
  const bool small = suitable.high - suitable.low < 0.4 * (range_.high - range_.low);
  if (field != field_ || left || small) range_ = suitable;
  field_ = field;
  return range_;
}

}  // namespace palp
