#include "viewer/spray.h"

#include <algorithm>
#include <cmath>

#include <osg/BoundingBox>

#include "viewer/smooth_step.h"

namespace palp {
namespace {

// Company up to which a particle is alone, from which on it is no drop, and from which on there is no air.
constexpr float kLonely = 0.25f, kCompany = 1.75f, kSheet = 4.5f;
constexpr float kSlow = 0.25f, kFast = 1.25f;  // [m/s]; a fall of 3 mm and of 8 cm
constexpr double kLongestSince = 0.1;          // [s]
constexpr float kFastest = 20;                 // [m/s], as in frame_blend.cpp

// Places in the order of cells as wide as company reaches, so that those of three cells in a row lie side by side:
// cells.h would take thrice the time.
class Company {
 public:
  // places: finite [m], at least one. spacing: above 0 [m].
  Company(std::span<const osg::Vec3f> places, float spacing) : spacing_(spacing) {
    osg::BoundingBox box;
    for (const osg::Vec3f& p : places) box.expandBy(p);
    low_ = box._min;
    const osg::Vec3f size = box._max - box._min;
    double cell = kReachSpacings * spacing;
    const auto along = [&](int a) { return std::floor(double(size[a]) / cell) + 1; };
    while (along(0) * along(1) * along(2) > kMostCells) cell *= 1.5;
    per_metre_ = static_cast<float>(1 / cell);
    for (int a = 0; a < 3; ++a) cells_[a] = static_cast<int>(along(a));
    first_.assign(number_of(0, 0, cells_[2]) + 1, 0);
    for (const osg::Vec3f& p : places) ++first_[cell_of(p) + 1];
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    places_.resize(places.size());
    for (const osg::Vec3f& p : places) places_[next[cell_of(p)]++] = p;
  }

  // Returns the company of one of the places, or some of it that is enough to be part of the liquid.
  float of(const osg::Vec3f& x) const {
    constexpr auto kFrom = static_cast<float>(kNearSpacings), kTo = static_cast<float>(kReachSpacings);
    constexpr int kSteps[] = {0, -1, 1};  // most of it is in the same row
    const float per_spacing = 1 / spacing_, farthest = kTo * kTo * spacing_ * spacing_;
    const int at[3] = {cell_along(x, 0), cell_along(x, 1), cell_along(x, 2)};
    const int from = std::max(at[0] - 1, 0), to = std::min(at[0] + 1, cells_[0] - 1);
    float sum = -1;  // itself
    for (const int dz : kSteps) {
      for (const int dy : kSteps) {
        const int y = at[1] + dy, z = at[2] + dz;
        if (y < 0 || z < 0 || y >= cells_[1] || z >= cells_[2]) continue;
        for (std::size_t k = first_[number_of(from, y, z)]; k < first_[number_of(to, y, z) + 1]; ++k) {
          const float away2 = (places_[k] - x).length2();
          if (away2 < farthest) sum += 1 - smooth_step(kFrom, kTo, std::sqrt(away2) * per_spacing);
        }
        if (sum >= kSheet) return sum;
      }
    }
    return sum;
  }

 private:
  static constexpr double kMostCells = 4e6;

  int cell_along(const osg::Vec3f& p, int a) const {
    return std::min(static_cast<int>((p[a] - low_[a]) * per_metre_), cells_[a] - 1);
  }
  std::size_t cell_of(const osg::Vec3f& p) const {
    return number_of(cell_along(p, 0), cell_along(p, 1), cell_along(p, 2));
  }
  std::size_t number_of(int x, int y, int z) const {
    const auto row = static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_[1]) + static_cast<std::size_t>(y);
    return row * static_cast<std::size_t>(cells_[0]) + static_cast<std::size_t>(x);
  }

  float spacing_ = 0, per_metre_ = 0;
  osg::Vec3f low_;
  int cells_[3] = {};
  std::vector<std::uint32_t> first_;  // of each cell the first one of places_
  std::vector<osg::Vec3f> places_;
};

}  // namespace

float aloneness(float company) { return 1 - smooth_step(kLonely, kCompany, company); }

float airiness(float company) { return 1 - smooth_step(kLonely, kSheet, company); }

float whiteness(float airy, float speed) {
  if (!(speed > kSlow)) return 0;
  return airy * smooth_step(kSlow, kFast, speed);
}

osg::Vec3f velocity_of(std::size_t particle, const ParticleFrame& frame, const ParticleFrame* earlier) {
  if (earlier == nullptr || earlier->positions.size() != frame.positions.size()) return {};
  const double since = frame.sim_time - earlier->sim_time;
  if (!(since > 0 && since <= kLongestSince) || 3 * particle + 2 >= frame.positions.size()) return {};
  const float *p = &frame.positions[3 * particle], *q = &earlier->positions[3 * particle];
  const osg::Vec3f velocity = osg::Vec3f(p[0] - q[0], p[1] - q[1], p[2] - q[2]) / static_cast<float>(since);
  return velocity.length() <= kFastest ? velocity : osg::Vec3f();
}

std::vector<Flying> find_flying(std::span<const osg::Vec4f> places, const Interior& interior, double spacing,
                                std::span<const std::span<const float>> others) {
  std::vector<Flying> flying;
  if (!(spacing > 0)) return flying;
  std::vector<std::uint32_t> loose;
  std::vector<osg::Vec3f> near;  // the loose ones and what may be company of theirs
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!interior.beside_loose(i)) continue;
    near.emplace_back(places[i].x(), places[i].y(), places[i].z());
    if (interior.loose(i)) loose.push_back(static_cast<std::uint32_t>(i));
  }
  if (loose.empty()) return flying;
  for (const std::span<const float>& other : others) {
    for (std::size_t i = 0; i + 2 < other.size(); i += 3) {
      const osg::Vec3f place(other[i], other[i + 1], other[i + 2]);
      if (interior.beside_loose(place)) near.push_back(place);
    }
  }
  const Company company(near, static_cast<float>(spacing));
  for (const std::uint32_t i : loose) {
    const float of_it = company.of({places[i].x(), places[i].y(), places[i].z()});
    if (const float airy = airiness(of_it); airy > 0) flying.push_back({i, aloneness(of_it), airy});
  }
  return flying;
}

}  // namespace palp
