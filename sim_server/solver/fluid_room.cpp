#include "sim_server/solver/fluid_room.h"

#include <algorithm>
#include <cmath>

namespace palp {
namespace {

class Room {
 public:
  Room(const Scene& scene, const Plan& plan) : dx_(scene.spacing) {
    low_ = Eigen::Vector3d::Constant(1e30);
    Eigen::Vector3d high = -low_;
    for (std::size_t i = 0; i < scene.position.size(); ++i) {
      if (scene.bodies[scene.body[i]].type != BodyKind::fixed && !flows(scene, plan, scene.body[i])) continue;
      low_ = low_.cwiseMin(scene.position[i]);
      high = high.cwiseMax(scene.position[i]);
    }
    double cells = 1;
    for (int a = 0; a < 3; ++a) cells *= (high[a] - low_[a]) / dx_ + 1;
    if (!(cells < kMostCells)) return;
    for (int a = 0; a < 3; ++a) n_[a] = static_cast<int>(std::lround((high[a] - low_[a]) / dx_)) + 1;
    state_.assign(static_cast<std::size_t>(n_[0]) * static_cast<std::size_t>(n_[1]) * static_cast<std::size_t>(n_[2]),
                  kEmpty);
    for (std::size_t i = 0; i < scene.position.size(); ++i)
      if (scene.bodies[scene.body[i]].type == BodyKind::fixed) state_[cell_of(scene.position[i])] = kSolid;
    for (std::size_t i = 0; i < scene.position.size(); ++i)
      if (flows(scene, plan, scene.body[i])) enter(cell_of(scene.position[i]));
    while (!open_.empty()) {
      const std::size_t c = open_.back();
      open_.pop_back();
      spread(c);
    }
  }
  // Returns the middles of the cells that fluid can get to; none where there are too many cells.
  std::vector<Eigen::Vector3d> reached() const {
    std::vector<Eigen::Vector3d> out;
    for (std::size_t c = 0; c < state_.size(); ++c)
      if (state_[c] == kReached) out.push_back(low_ + dx_ * index_of(c).cast<double>());
    return out;
  }

 private:
  static constexpr double kMostCells = 2e7;
  static constexpr char kEmpty = 0, kSolid = 1, kReached = 2;
  // A cell's middle lies at low_ + dx_ * index, so that the particles of walls on a lattice lie in middles.
  std::size_t cell_of(const Eigen::Vector3d& x) const {
    Eigen::Vector3i k;
    for (int a = 0; a < 3; ++a) k[a] = std::clamp(static_cast<int>(std::lround((x[a] - low_[a]) / dx_)), 0, n_[a] - 1);
    return at(k);
  }
  std::size_t at(const Eigen::Vector3i& k) const {
    return (static_cast<std::size_t>(k.z()) * static_cast<std::size_t>(n_[1]) + static_cast<std::size_t>(k.y())) *
               static_cast<std::size_t>(n_[0]) +
           static_cast<std::size_t>(k.x());
  }
  Eigen::Vector3i index_of(std::size_t c) const {
    const auto x = static_cast<std::size_t>(n_[0]), y = static_cast<std::size_t>(n_[1]);
    return Eigen::Vector3i(static_cast<int>(c % x), static_cast<int>(c / x % y), static_cast<int>(c / x / y));
  }
  void enter(std::size_t c) {
    if (state_[c] != kEmpty) return;
    state_[c] = kReached;
    open_.push_back(c);
  }
  void spread(std::size_t c) {
    const Eigen::Vector3i k = index_of(c);
    for (int a = 0; a < 3; ++a)
      for (const int side : {-1, 1}) {
        Eigen::Vector3i next = k;
        next[a] += side;
        if (next[a] >= 0 && next[a] < n_[a]) enter(at(next));
      }
  }

  double dx_;
  Eigen::Vector3d low_;
  int n_[3] = {1, 1, 1};
  std::vector<char> state_;
  std::vector<std::size_t> open_;
};

}  // namespace

std::vector<Eigen::Vector3d> fluid_room(const Scene& scene, const Plan& plan) { return Room(scene, plan).reached(); }

}  // namespace palp
