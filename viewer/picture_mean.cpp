#include "viewer/picture_mean.h"

#include <array>
#include <cmath>

#include "config/srgb.h"

namespace palp {
namespace {

constexpr std::uint32_t kWhite = 65535;  // fine enough that each of 256 levels of sRGB has a light of its own

std::array<std::uint32_t, 256> lights() {
  std::array<std::uint32_t, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<std::uint32_t>(std::lround(kWhite * light_of_srgb(static_cast<double>(i) / 255)));
  return table;
}

std::vector<std::uint8_t> levels() {
  std::vector<std::uint8_t> table(kWhite + 1);
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<std::uint8_t>(std::lround(255 * srgb_of_light(static_cast<double>(i) / kWhite)));
  return table;
}

double halton(int index, int base) {
  double value = 0;
  for (double digit = 1.0 / base; index > 0; index /= base, digit /= base) value += digit * (index % base);
  return value;
}

}  // namespace

void PictureMean::add(const Picture& picture) {
  static const std::array<std::uint32_t, 256> light = lights();
  width_ = picture.width;
  height_ = picture.height;
  sum_.resize(picture.rgb.size());
  for (std::size_t i = 0; i < sum_.size(); ++i) sum_[i] += light[picture.rgb[i]];
  ++count_;
}

Picture PictureMean::mean() const {
  static const std::vector<std::uint8_t> level = levels();
  Picture picture{width_, height_, std::vector<std::uint8_t>(sum_.size())};
  for (std::size_t i = 0; i < sum_.size(); ++i) picture.rgb[i] = level[(sum_[i] + count_ / 2) / count_];
  return picture;
}

osg::Vec2d displacement(int k, int count) {
  const auto place = [](int index) { return osg::Vec2d(halton(index + 1, 2), halton(index + 1, 3)); };
  osg::Vec2d middle;
  for (int i = 0; i < count; ++i) middle += place(i) / count;
  return place(k) - middle;
}

}  // namespace palp
