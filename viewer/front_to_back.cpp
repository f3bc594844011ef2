#include "viewer/front_to_back.h"

#include <algorithm>
#include <array>
#include <utility>

namespace palp {

std::span<const std::uint32_t> FrontToBack::rank(std::span<const osg::Vec4f> places, const osg::Vec3f& along) {
  constexpr std::size_t kLayers = 512;
  ranks_.resize(places.size());
  box_.init();
  for (const osg::Vec4f& place : places) box_.expandBy(place.x(), place.y(), place.z());
  if (places.empty()) return ranks_;
  float nearest = 0, farthest = 0;  // along it
  for (int a = 0; a < 3; ++a) {
    nearest += along[a] * (along[a] > 0 ? box_._min[a] : box_._max[a]);
    farthest += along[a] * (along[a] > 0 ? box_._max[a] : box_._min[a]);
  }
  const float per_metre = farthest > nearest ? kLayers / (farthest - nearest) : 0;
  std::array<std::uint32_t, kLayers> next{};  // of each layer first its size, then the rank of its next place
  for (std::size_t i = 0; i < places.size(); ++i) {
    const osg::Vec4f& p = places[i];
    const float way = (p.x() * along.x() + p.y() * along.y() + p.z() * along.z() - nearest) * per_metre;
    ranks_[i] = static_cast<std::uint32_t>(std::clamp(way, 0.0f, kLayers - 1.0f));
    ++next[ranks_[i]];
  }
  std::uint32_t before = 0;
  for (std::uint32_t& rank : next) before += std::exchange(rank, before);
  for (std::uint32_t& rank : ranks_) rank = next[rank]++;
  return ranks_;
}

}  // namespace palp
