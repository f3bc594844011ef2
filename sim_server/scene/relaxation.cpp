#include "sim_server/scene/relaxation.h"

#include <algorithm>
#include <cmath>

#include "sim_server/physics/smoothing.h"

namespace palp {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// All lengths in spacings.
constexpr float kListSkin = 0.3F;    // that a point moves at most with one list of neighbours
constexpr int kMaxStages = 3;        // of movement
constexpr int kShiftsPerStage = 20;  // points move this often with one list
constexpr float kShift = 0.1F;       // of the displacement, over H^2 sum V gradW
// By how much points a spacing apart are pushed harder, nearer ones more (Monaghan 2000): without it the kernel does
// not tell pairs from even places; it leaves sum V gradW uneven itself, so that in the end there is little of it.
constexpr float kRepulsion = 0.5F, kLastRepulsion = 0.05F;
constexpr float kMaxShift = 0.05F;       // a displacement at most
constexpr float kEven = 2e-3F;           // a largest sum V gradW at which points rest
constexpr float kSettled = 5e-4F;        // and a largest change of volumes
constexpr float kLeastDistance = 0.35F;  // that a point is moved to from a wall: past the reach of its guard (walls.h)
constexpr float kLeastSlope = 0.1F;      // squared sine of a wall to a held direction, to move along the surface
constexpr float kMaxVolumeChange = 0.25F;   // change of a point's volume
constexpr std::size_t kPointsAtOnce = 256;  // points that a thread takes at once

// All points in single precision, from the middle of the domain on: what each moving one reads of its neighbours.
struct Cloud {
  std::vector<float> x, y, z, volume;
  Vector3f period, inv_period;  // 0 along an axis that is not periodic
};

// Neighbours, within the support and twice the skin, of the moving points.
struct Lists {
  std::vector<std::vector<std::int32_t>> part;  // by chunk of the points
  std::vector<std::size_t> end;                 // by point: of its neighbours in its chunk's part

  const std::int32_t* begin_of(std::size_t k) const {
    return part[k / kPointsAtOnce].data() + (k % kPointsAtOnce == 0 ? 0 : end[k - 1]);
  }
  std::size_t count_of(std::size_t k) const { return end[k] - (k % kPointsAtOnce == 0 ? 0 : end[k - 1]); }
};

// The next move of a point.
struct Next {
  Vector3f shift;
  float volume, uneven;  // uneven: |sum V gradW|
};

class Relaxing {
 public:
  Relaxing(Relaxation& points, ThreadTeam& team)
      : points_(points),
        team_(team),
        middle_((points.box.min + points.box.max) / 2),
        support_(static_cast<float>(points.support / points.spacing)),
        full_(static_cast<float>(
            lattice_sum(FluidKernelOf<double>::with_support(points.support, points.spacing), points.spacing))) {
    const std::size_t n = points.place.size();
    cloud_.x.resize(n);
    cloud_.y.resize(n);
    cloud_.z.resize(n);
    cloud_.volume.assign(points.volume.begin(), points.volume.end());
    for (int a = 0; a < 3; ++a) {
      const double length = (points.box.max[a] - points.box.min[a]) / points.spacing;
      cloud_.period[a] = points.box.is_periodic(a) ? static_cast<float>(length) : 0;
      cloud_.inv_period[a] = points.box.is_periodic(a) ? static_cast<float>(1 / length) : 0;
    }
    std::vector<bool> moves(n, false);
    for (const std::uint32_t i : points.moving) moves[i] = true;
    for (std::uint32_t i = 0; i < n; ++i) {
      put(i, points.place[i]);
      if (!moves[i]) fixed_.push_back(i);
    }
    for (const std::uint32_t i : fixed_) fixed_place_.push_back(points.place[i]);
    moved_.assign(points.moving.size(), Vector3f::Zero());
    next_.resize(points.moving.size());
  }

  void run() {
    const PointGrid fixed(fixed_place_, points_.box, reach());
    for (int stage = 0; stage < kMaxStages; ++stage) {
      if (points_.progress) points_.progress(static_cast<double>(stage) / (kMaxStages + 1));
      list(fixed);
      if (run_stage()) break;
    }
    // as soon as volumes follow, nothing drives points from where they are crowded any more
    volumes_follow_ = true;
    list(fixed);
    run_stage();
    for (std::size_t k = 0; k < moved_.size(); ++k) {
      const std::uint32_t i = points_.moving[k];
      points_.place[i] = points_.box.wrapped(place_of(k));
      points_.volume[i] = static_cast<double>(cloud_.volume[i]);
    }
  }

 private:
  double reach() const { return static_cast<double>(support_ + 2 * kListSkin) * points_.spacing; }
  void put(std::size_t i, const Vector3d& place) {
    const Vector3f x = ((place - middle_) / points_.spacing).cast<float>();
    cloud_.x[i] = x.x();
    cloud_.y[i] = x.y();
    cloud_.z[i] = x.z();
  }
  Vector3d place_of(std::size_t k) const {
    return points_.place[points_.moving[k]] + points_.spacing * moved_[k].cast<double>();
  }

  void list(const PointGrid& fixed) {
    std::vector<Vector3d> now(moved_.size());
    for (std::size_t k = 0; k < now.size(); ++k) now[k] = place_of(k);
    const double reach2 = reach() * reach();
    const PointGrid moving(now, points_.box, reach());
    lists_.part.resize(now.size() / kPointsAtOnce + 1);
    for (std::vector<std::int32_t>& part : lists_.part) part.clear();
    lists_.end.resize(now.size());
    const auto sees = [&](const Vector3d& x, const Vector3d& y) {
      return points_.box.between(y, x).squaredNorm() < reach2 &&
             (!points_.walls.some_thin() || points_.walls.in_sight(x, y));
    };
    team_.in_chunks(now.size(), kPointsAtOnce, [&](std::size_t begin, std::size_t end) {
      std::vector<std::int32_t>& part = lists_.part[begin / kPointsAtOnce];
      for (std::size_t k = begin; k < end; ++k) {
        moving.near(now[k], [&](std::uint32_t m) {
          if (m != k && sees(now[k], now[m])) part.push_back(static_cast<std::int32_t>(points_.moving[m]));
        });
        fixed.near(now[k], [&](std::uint32_t m) {
          if (sees(now[k], fixed_place_[m])) part.push_back(static_cast<std::int32_t>(fixed_[m]));
        });
        lists_.end[k] = part.size();
      }
    });
    listed_ = moved_;
  }

  // Returns sum V gradW, upwards, and sum V W over the neighbours of a point and itself, lengths in spacings.
  template <class Kernel>
  std::pair<Vector3f, float> sums_of(const Kernel& kernel, std::size_t k) const {
    const std::int32_t* list = lists_.begin_of(k);
    const auto count = static_cast<std::int32_t>(lists_.count_of(k));
    const std::uint32_t i = points_.moving[k];
    const float *X = cloud_.x.data(), *Y = cloud_.y.data(), *Z = cloud_.z.data(), *V = cloud_.volume.data();
    const float xi = X[i], yi = Y[i], zi = Z[i];
    const Vector3f L = cloud_.period, inv_L = cloud_.inv_period;
    const float apart = volumes_follow_ ? kLastRepulsion : kRepulsion, inv_near = 1 / kernel.W(1.0F);
    float sx = 0, sy = 0, sz = 0, sum = 0;
#pragma omp simd reduction(+ : sx, sy, sz, sum)
    for (std::int32_t e = 0; e < count; ++e) {
      const std::int32_t j = list[e];
      float x = xi - X[j], y = yi - Y[j], z = zi - Z[j];
      x -= L.x() * __builtin_rintf(x * inv_L.x());
      y -= L.y() * __builtin_rintf(y * inv_L.y());
      z -= L.z() * __builtin_rintf(z * inv_L.z());
      const float r = std::sqrt(x * x + y * y + z * z), W = kernel.W(r), near = W * inv_near, near2 = near * near;
      const float s = V[j] * (1 + apart * near2 * near2) * kernel.F(r);
      sx -= s * x;
      sy -= s * y;
      sz -= s * z;
      sum += V[j] * W;
    }
    return {Vector3f(sx, sy, sz), sum + V[i] * kernel.W(0.0F)};
  }

  template <class Kernel>
  Next next_of(const Kernel& kernel, std::size_t k) const {
    auto [gradient, sum] = sums_of(kernel, k);
    const WallsHere walls = points_.walls.at(place_of(k));
    gradient -= (points_.spacing * walls.slope).cast<float>();
    sum += static_cast<float>(walls.share);
    Next next;
    const Vector3f& held = points_.held[k];
    gradient -= gradient.dot(held) * held;
    next.uneven = gradient.norm();
    next.shift = -kShift * support_ * support_ * gradient;
    next.shift *= std::min(1.0F, kMaxShift / std::max(next.shift.norm(), 1e-30F));
    const Vector3f normal = walls.normal.cast<float>(), off = normal - normal.dot(held) * held;
    const float deep = kLeastDistance - static_cast<float>(walls.distance / points_.spacing) - next.shift.dot(normal);
    if (deep > 0 && off.squaredNorm() > kLeastSlope) next.shift += deep / off.squaredNorm() * off;
    const float volume = cloud_.volume[points_.moving[k]] * full_ / sum;
    next.volume = !volumes_follow_ ? cloud_.volume[points_.moving[k]]
                                   : std::clamp(volume, 1 - kMaxVolumeChange, 1 + kMaxVolumeChange);
    return next;
  }

  // Moves the points kShiftsPerStage times. Returns true when they have come to rest.
  bool run_stage() {
    bool rests = false;
    with_type(FluidKernelOf<float>::with_support(support_, 1.0F), [&](const auto& kernel) {
      for (int round = 0; round < kShiftsPerStage && !rests; ++round) {
        team_.for_each(next_.size(), kPointsAtOnce, [&](std::size_t k) { next_[k] = next_of(kernel, k); });
        float worst = 0, change = 0;
        for (std::size_t k = 0; k < next_.size(); ++k) {
          const Vector3f since = moved_[k] + next_[k].shift - listed_[k];
          moved_[k] = listed_[k] + since * std::min(1.0F, kListSkin / std::max(since.norm(), 1e-30F));
          put(points_.moving[k], place_of(k));
          float& volume = cloud_.volume[points_.moving[k]];
          change = std::max(change, std::abs(next_[k].volume - volume));
          volume = next_[k].volume;
          worst = std::max(worst, next_[k].uneven);
        }
        rests = worst < kEven && change < kSettled;
      }
    });
    return rests;
  }

  Relaxation& points_;
  ThreadTeam& team_;
  Vector3d middle_;              // of the domain [m]
  float support_;                // of the kernel, in spacings
  float full_;                   // sum V W in a lattice
  bool volumes_follow_ = false;  // as points move
  Cloud cloud_;
  Lists lists_;
  std::vector<std::uint32_t> fixed_;   // indices of the points that do not move
  std::vector<Vector3d> fixed_place_;  // [m]
  std::vector<Vector3f> moved_;        // by moving point: displacement since the start, in spacings
  std::vector<Vector3f> listed_;       // the same when neighbours were last listed
  std::vector<Next> next_;
};

}  // namespace

void relax(Relaxation& points, ThreadTeam& team) {
  Relaxing relaxing(points, team);
  relaxing.run();
}

double lattice_sum(const FluidKernelOf<double>& kernel, double spacing) {
  const int reach = static_cast<int>(kernel.support / spacing);
  double sum = 0;
  for (int x = -reach; x <= reach; ++x)
    for (int y = -reach; y <= reach; ++y)
      for (int z = -reach; z <= reach; ++z) sum += kernel.W(spacing * Vector3d(x, y, z).norm());
  return spacing * spacing * spacing * sum;
}

}  // namespace palp
