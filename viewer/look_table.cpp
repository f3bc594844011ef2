#include "viewer/look_table.h"

#include <algorithm>
#include <cmath>

#include <osg/Image>

namespace palp {
namespace {

constexpr float kSoftOver = 3e-3f;        // [m]
constexpr float kMostAbsorption = 1e4f;   // [1/m]: black within a millimetre; sums of it fit half floats
constexpr float kShortestInHaze = 1e-4f;  // [m]

}  // namespace

osg::Vec4f surface_numbers(const Look& look) {
  const float root = (look.refractive_index - 1) / (look.refractive_index + 1);
  return {look.roughness, look.scattering_length / (look.scattering_length + kSoftOver), root * root, look.metallic};
}

osg::Vec4f grain_numbers(const Look& look, const osg::BoundingBox& box) {
  const osg::Vec3f size = box._max - box._min;
  const int longest = size.x() >= size.y() && size.x() >= size.z() ? 0 : size.y() >= size.z() ? 1 : 2;
  osg::Vec4f grain(0, 0, 0, look.grain);
  grain[longest] = 1;
  return grain;
}

Look between(const Look& a, const Look& b, float t) {
  if (t == 0) return a;
  Look look = a;
  look.roughness = std::lerp(a.roughness, b.roughness, t);
  look.metallic = std::lerp(a.metallic, b.metallic, t);
  look.refractive_index = std::lerp(a.refractive_index, b.refractive_index, t);
  look.grain = std::lerp(a.grain, b.grain, t);
  look.foam = std::lerp(a.foam, b.foam, t);
  for (std::size_t k = 0; k < 3; ++k)
    look.absorption_per_m[k] = std::lerp(a.absorption_per_m[k], b.absorption_per_m[k], t);
  // by the square root: the last haze is seen most
  const auto root_haze = [](const Look& of) { return 1 / std::sqrt(std::max(of.scattering_length, kShortestInHaze)); };
  const float root = std::lerp(root_haze(a), root_haze(b), t);
  look.scattering_length = 1 / (root * root);
  return look;
}

LookTable::LookTable() : texture_(new osg::Texture2D) {
  osg::ref_ptr<osg::Image> image = new osg::Image;
  image->allocateImage(kColumns, kRows, 1, GL_RGBA, GL_FLOAT);
  image->setInternalTextureFormat(GL_RGBA32F_ARB);
  std::fill_n(reinterpret_cast<float*>(image->data()), 4 * kColumns * kRows, 0.0f);
  texture_->setImage(image);
  texture_->setInternalFormat(GL_RGBA32F_ARB);
  texture_->setFilter(osg::Texture::MIN_FILTER, osg::Texture::NEAREST);
  texture_->setFilter(osg::Texture::MAG_FILTER, osg::Texture::NEAREST);
  texture_->setResizeNonPowerOfTwoHint(false);
  texture_->setUnRefImageDataAfterApply(false);
}

unsigned char LookTable::row_of(const Look& look) {
  const auto found = std::ranges::find(looks_, look);
  if (found != looks_.end()) return static_cast<unsigned char>(found - looks_.begin());
  if (looks_.size() == kRows) return kRows - 1;
  const std::size_t row = looks_.size();
  looks_.push_back(look);
  auto* texel = reinterpret_cast<float*>(texture_->getImage()->data(0, static_cast<int>(row)));
  for (std::size_t k = 0; k < 3; ++k) texel[k] = std::min(look.absorption_per_m[k], kMostAbsorption);
  texel[3] = 1 / std::max(look.scattering_length, kShortestInHaze);
  const osg::Vec4f surface = surface_numbers(look);
  for (int k = 0; k < 4; ++k) texel[4 + k] = surface[k];
  texel[8] = look.clear ? 1 : 0;
  texel[9] = look.foam;
  texture_->getImage()->dirty();
  return static_cast<unsigned char>(row);
}

osg::Vec4f LookTable::texel(int column, int row) const {
  const auto* texel = reinterpret_cast<const float*>(texture_->getImage()->data(static_cast<unsigned>(column), row));
  return {texel[0], texel[1], texel[2], texel[3]};
}

}  // namespace palp
