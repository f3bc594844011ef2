#include "sim_server/scene/relaxation.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim_server/physics/smoothing.h"

namespace palp {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// All lengths in spacings.
constexpr double kSupport = 2.2;     // of the kernel
constexpr double kListSkin = 0.3;    // that a point moves at most with one list of neighbours
constexpr int kMinStages = 3;        // of movement, at least
constexpr int kMaxStages = 12;       // and where two points are nearer than kMinDistance, at most
constexpr double kCrowd = 5;         // points this near to one of the two go on, too
constexpr int kShiftsPerStage = 20;  // points move this often in a stage
constexpr float kRelist = 0.1F;      // a largest displacement after which neighbours are listed anew
constexpr float kMinDistance = 0.88F;
constexpr double kShiftCoefficient = 0.2;  // of the displacement, over spacing^2 sum V gradW
constexpr float kMaxShift = 0.1F;          // a displacement at most
constexpr float kConvergedShift = 2e-3F;   // a largest displacement at which they rest
constexpr double kMaxVolumeChange = 0.25;  // change of a point's volume
constexpr int kVolumeRounds = 4;
constexpr std::size_t kPointsAtOnce = 256;  // points that a thread takes at once

// Kernels W and F of q = r / H over the value of W at 0. u is not negative, so that points out of reach count nothing.
constexpr auto kKernel = WendlandC2Of<float>::unit();

// All points in single precision, from the middle of the domain on: what each moving one reads of its neighbours.
struct Cloud {
  std::vector<float> x, y, z, volume;
  Vector3f period, inv_period;  // 0 along an axis that is not periodic
};

// Neighbours, within the support and twice the skin, of the points that go on.
struct Lists {
  std::vector<std::vector<std::int32_t>> part;  // by chunk of the points
  std::vector<std::size_t> end;                 // by point: of its neighbours in its chunk's part

  const std::int32_t* begin_of(std::size_t g) const {
    return part[g / kPointsAtOnce].data() + (g % kPointsAtOnce == 0 ? 0 : end[g - 1]);
  }
  std::size_t count_of(std::size_t g) const { return end[g] - (g % kPointsAtOnce == 0 ? 0 : end[g - 1]); }
};

class Relaxing {
 public:
  Relaxing(Relaxation& points, ThreadTeam& team)
      : points_(points), team_(team), middle_((points.box.min + points.box.max) / 2) {
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
    listed_.assign(points.moving.size(), Vector3f::Zero());
    shift_.assign(points.moving.size(), Vector3f::Zero());
    held_.assign(points.moving.size(), Vector3f::Zero());
    clear_.assign(points.moving.size(), -1);
    team.for_each(points.moving.size(), kPointsAtOnce,
                  [&](std::size_t k) { move(static_cast<std::uint32_t>(k), moved_[k]); });
    all_go();
  }

  void run() {
    const PointGrid fixed(fixed_place_, points_.box, (kSupport + 2 * kListSkin) * points_.spacing);
    for (int stage = 0; stage < kMaxStages; ++stage) {
      if (points_.progress) points_.progress(static_cast<double>(stage) / kMaxStages);
      if (stage >= kMinStages) keep_crowded();
      if (going_.empty()) break;
      if (stage == 0 || stage >= kMinStages || farthest_since_listing() > kRelist) list(fixed);
      if (run_stage()) break;
    }
    all_go();
    list(fixed);
    assign_volumes();
    for (std::size_t k = 0; k < moved_.size(); ++k) points_.place[points_.moving[k]] = points_.box.wrapped(place_of(k));
  }

 private:
  // Shares the space out: V = V0 / sum V W, relative to what a lattice has for the sum.
  void assign_volumes() {
    const double full = lattice_sum();
    std::vector<float> next(moved_.size());
    for (int round = 0; round < kVolumeRounds; ++round) {
      team_.for_each(moved_.size(), kPointsAtOnce, [&](std::size_t k) {
        const float own = cloud_.volume[points_.moving[k]];
        next[k] = static_cast<float>(std::clamp(own * full / (static_cast<double>(own) + weight_around(k)),
                                                1 - kMaxVolumeChange, 1 + kMaxVolumeChange));
      });
      for (std::size_t k = 0; k < next.size(); ++k) cloud_.volume[points_.moving[k]] = next[k];
    }
    for (const std::uint32_t i : points_.moving) points_.volume[i] = static_cast<double>(cloud_.volume[i]);
  }

  void all_go() {
    going_.resize(moved_.size());
    std::iota(going_.begin(), going_.end(), 0u);
  }
  void put(std::size_t i, const Vector3d& place) {
    const Vector3f x = ((place - middle_) / points_.spacing).cast<float>();
    cloud_.x[i] = x.x();
    cloud_.y[i] = x.y();
    cloud_.z[i] = x.z();
  }
  // Moves a moving point to this displacement, or to where solids leave it room.
  void move(std::uint32_t k, const Vector3f& to) {
    moved_[k] = to;
    if (points_.hold && (to - held_[k]).norm() > clear_[k]) {
      const FreePlace free = points_.hold(place_of(k));
      moved_[k] = ((free.place - points_.place[points_.moving[k]]) / points_.spacing).cast<float>();
      held_[k] = moved_[k];
      clear_[k] = static_cast<float>(free.clear / points_.spacing);
    }
    put(points_.moving[k], place_of(k));
  }
  Vector3d place_of(std::size_t k) const {
    return points_.place[points_.moving[k]] + points_.spacing * moved_[k].cast<double>();
  }

  void list(const PointGrid& fixed) {
    std::vector<Vector3d> now(moved_.size());
    for (std::size_t k = 0; k < now.size(); ++k) now[k] = place_of(k);
    const double reach = (kSupport + 2 * kListSkin) * points_.spacing, reach2 = reach * reach;
    const PointGrid moving(now, points_.box, reach);
    lists_.part.resize(going_.size() / kPointsAtOnce + 1);
    for (std::vector<std::int32_t>& part : lists_.part) part.clear();
    lists_.end.resize(going_.size());
    team_.in_chunks(going_.size(), kPointsAtOnce, [&](std::size_t begin, std::size_t end) {
      std::vector<std::int32_t>& part = lists_.part[begin / kPointsAtOnce];
      for (std::size_t g = begin; g < end; ++g) {
        const std::uint32_t k = going_[g];
        moving.near(now[k], [&](std::uint32_t m) {
          if (m != k && points_.box.between(now[m], now[k]).squaredNorm() < reach2)
            part.push_back(static_cast<std::int32_t>(points_.moving[m]));
        });
        fixed.near(now[k], [&](std::uint32_t m) {
          if (points_.box.between(fixed_place_[m], now[k]).squaredNorm() < reach2)
            part.push_back(static_cast<std::int32_t>(fixed_[m]));
        });
        lists_.end[g] = part.size();
      }
    });
    listed_ = moved_;
  }

  // Returns the displacement of a point that goes on, down the gradient of sum V W, in spacings.
  Vector3f shift_of(std::size_t g) const {
    constexpr auto inv_support = static_cast<float>(1 / kSupport);
    const auto scale = static_cast<float>(kShiftCoefficient * 21 / (2 * EIGEN_PI * std::pow(kSupport, 4)));
    const auto near = static_cast<float>(0.2 / std::pow(WendlandC2Of<double>::unit().W(1 / kSupport), 4));
    const std::int32_t* list = lists_.begin_of(g);
    const auto count = static_cast<std::int32_t>(lists_.count_of(g));
    const std::uint32_t i = points_.moving[going_[g]];
    const float *X = cloud_.x.data(), *Y = cloud_.y.data(), *Z = cloud_.z.data(), *V = cloud_.volume.data();
    const float xi = X[i], yi = Y[i], zi = Z[i];
    const Vector3f L = cloud_.period, inv_L = cloud_.inv_period;
    float sx = 0, sy = 0, sz = 0;
#pragma omp simd reduction(+ : sx, sy, sz)
    for (std::int32_t e = 0; e < count; ++e) {
      const std::int32_t j = list[e];
      float x = xi - X[j], y = yi - Y[j], z = zi - Z[j];
      x -= L.x() * __builtin_rintf(x * inv_L.x());
      y -= L.y() * __builtin_rintf(y * inv_L.y());
      z -= L.z() * __builtin_rintf(z * inv_L.z());
      const float q = std::min(1.0F, std::sqrt(x * x + y * y + z * z) * inv_support);
      const float W = kKernel.W(q), W2 = W * W;
      // Monaghan 2000: points nearer than a spacing are pushed harder
      const float s = V[j] * (1 + near * W2 * W2) * kKernel.F(q);
      sx += s * x;
      sy += s * y;
      sz += s * z;
    }
    const Vector3f shift = scale * inv_support * Vector3f(sx, sy, sz);
    return shift * std::min(1.0F, kMaxShift / std::max(shift.norm(), 1e-30F));
  }

  // Returns sum V W over the neighbours of a point.
  double weight_around(std::size_t k) const {
    constexpr auto inv_support = static_cast<float>(1 / kSupport);
    double sum = 0;
    for_neighbors(k, [&](std::uint32_t j, float r) {
      sum += static_cast<double>(cloud_.volume[j] * kKernel.W(r * inv_support));
    });
    return sum;
  }

  template <class F>
  void for_neighbors(std::size_t g, const F& f) const {
    const std::int32_t* list = lists_.begin_of(g);
    const std::size_t count = lists_.count_of(g);
    const std::uint32_t i = points_.moving[going_[g]];
    for (std::size_t e = 0; e < count; ++e) {
      const auto j = static_cast<std::uint32_t>(list[e]);
      Vector3f d(cloud_.x[i] - cloud_.x[j], cloud_.y[i] - cloud_.y[j], cloud_.z[i] - cloud_.z[j]);
      for (int a = 0; a < 3; ++a) d[a] -= cloud_.period[a] * std::rint(d[a] * cloud_.inv_period[a]);
      f(j, d.norm());
    }
  }

  // Moves the points that go on kShiftsPerStage times. Returns true when they have come to rest.
  bool run_stage() {
    for (int round = 0; round < kShiftsPerStage; ++round) {
      team_.for_each(going_.size(), kPointsAtOnce, [&](std::size_t g) { shift_[going_[g]] = shift_of(g); });
      team_.for_each(going_.size(), kPointsAtOnce, [&](std::size_t g) {
        const std::uint32_t k = going_[g];
        const Vector3f since = moved_[k] + shift_[k] - listed_[k];
        const float share = std::min(1.0F, static_cast<float>(kListSkin) / std::max(since.norm(), 1e-30F));
        move(k, listed_[k] + since * share);
      });
      float farthest = 0;
      for (const std::uint32_t k : going_) farthest = std::max(farthest, shift_[k].squaredNorm());
      if (farthest < kConvergedShift * kConvergedShift) return true;
    }
    return false;
  }

  float farthest_since_listing() const {
    float farthest = 0;
    for (const std::uint32_t k : going_) farthest = std::max(farthest, (moved_[k] - listed_[k]).norm());
    return farthest;
  }

  // Lets only those points go on that are near a pair that is too close.
  void keep_crowded() {
    std::vector<std::uint8_t> mark(going_.size(), 0);
    team_.for_each(going_.size(), kPointsAtOnce, [&](std::size_t g) {
      for_neighbors(g, [&](std::uint32_t, float r) { mark[g] = r < kMinDistance ? 1 : mark[g]; });
    });
    std::vector<Vector3d> crowded;
    for (std::size_t g = 0; g < going_.size(); ++g)
      if (mark[g] != 0) crowded.push_back(place_of(going_[g]));
    const double reach = kCrowd * points_.spacing;
    const PointGrid grid(crowded, points_.box, reach);
    team_.for_each(going_.size(), kPointsAtOnce, [&](std::size_t g) {
      const Vector3d x = place_of(going_[g]);
      mark[g] = 0;
      grid.near(x, [&](std::uint32_t c) {
        if (points_.box.between(crowded[c], x).squaredNorm() < reach * reach) mark[g] = 1;
      });
    });
    std::size_t kept = 0;
    for (std::size_t g = 0; g < going_.size(); ++g)
      if (mark[g] != 0) going_[kept++] = going_[g];
    going_.resize(kept);
  }

  // Returns sum W over the neighbourhood of a particle of a whole cubic lattice, itself included.
  static double lattice_sum() {
    constexpr auto kernel = WendlandC2Of<double>::unit();
    double sum = 0;
    for (int x = -3; x <= 3; ++x)
      for (int y = -3; y <= 3; ++y)
        for (int z = -3; z <= 3; ++z) sum += kernel.W(Vector3d(x, y, z).norm() / kSupport);
    return sum;
  }

  Relaxation& points_;
  ThreadTeam& team_;
  Vector3d middle_;  // of the domain [m]
  Cloud cloud_;
  Lists lists_;
  std::vector<std::uint32_t> going_;   // indices in points_.moving of those that go on
  std::vector<std::uint32_t> fixed_;   // indices of the points that do not move
  std::vector<Vector3d> fixed_place_;  // [m]
  std::vector<Vector3f> moved_;        // by moving point: displacement since the start, in spacings
  std::vector<Vector3f> listed_;       // the same when neighbours were last listed
  std::vector<Vector3f> held_;         // the same when solids were last asked for room
  std::vector<float> clear_;           // how far all was free around there, in spacings
  std::vector<Vector3f> shift_;
};

}  // namespace

void relax(Relaxation& points, ThreadTeam& team) {
  Relaxing relaxing(points, team);
  relaxing.run();
}

}  // namespace palp
