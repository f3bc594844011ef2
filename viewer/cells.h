// Finds the places near another one, by cells of a lattice over all of them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace palp {

class Cells {
 public:
  Cells() = default;
  // places: x y z each [m], which must outlive the cells; what is not finite is nowhere. reach: above 0 [m].
  Cells(std::span<const float> places, double reach) : places_(places) {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::max()), high = -low;
    for (std::size_t i = 0; i < count(); ++i) {
      if (!place(i).allFinite()) continue;
      low = low.cwiseMin(place(i));
      high = high.cwiseMax(place(i));
    }
    if (!(low.array() <= high.array()).all()) return;
    low_ = low;
    size_ = std::max(reach, (high - low).maxCoeff() / (kMostCells - 1));
    for (int k = 0; k < 3; ++k) cells_[static_cast<std::size_t>(k)] = cell_along(high, k) + 1;
    // a counting sort
    first_.assign(number_of(0, 0, cells_[2]) + 1, 0);
    for (std::size_t i = 0; i < count(); ++i)
      if (place(i).allFinite()) ++first_[cell_of(i) + 1];
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    order_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < count(); ++i)
      if (place(i).allFinite()) order_[next[cell_of(i)]++] = i;
  }

  Eigen::Vector3d place(std::size_t i) const { return {places_[3 * i], places_[3 * i + 1], places_[3 * i + 2]}; }

  // Calls f(index) for each place in the cells around x: all within the reach are among them.
  template <class F>
  void around(const Eigen::Vector3d& x, F&& f) const {
    if (order_.empty()) return;
    std::array<int, 3> from{}, to{};
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      from[at] = std::max(cell_along(x, k) - 1, 0);
      to[at] = std::min(cell_along(x, k) + 1, cells_[at] - 1);
      if (from[at] > to[at]) return;
    }
    for (int z = from[2]; z <= to[2]; ++z)
      for (int y = from[1]; y <= to[1]; ++y)
        for (std::size_t n = first_[number_of(from[0], y, z)]; n < first_[number_of(to[0], y, z) + 1]; ++n)
          f(order_[n]);
  }

 private:
  static constexpr int kMostCells = 96;  // along each axis

  std::size_t count() const { return places_.size() / 3; }
  // -2 below the lattice, kMostCells + 1 above it
  int cell_along(const Eigen::Vector3d& x, int axis) const {
    const double cell = std::floor((x[axis] - low_[axis]) / size_);
    return cell > -2 ? static_cast<int>(std::min(cell, kMostCells + 1.0)) : -2;
  }
  std::size_t cell_of(std::size_t i) const {
    const Eigen::Vector3d x = place(i);
    return number_of(cell_along(x, 0), cell_along(x, 1), cell_along(x, 2));
  }
  std::size_t number_of(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(cells_[0]) +
           static_cast<std::size_t>(x);
  }

  std::span<const float> places_;
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero();
  double size_ = 1;                         // of a cell [m]
  std::array<int, 3> cells_{};              // along each axis
  std::vector<std::size_t> first_, order_;  // of each cell the first one in order_, which has all places
};

}  // namespace palp
