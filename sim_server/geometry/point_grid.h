// Points in a uniform hashed grid, for finding those near a place; and a domain that may be periodic. Host, double
// precision, for checks and probes. Results come in an order that depends only on the points.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

namespace palp {

struct PeriodicBox {
  Eigen::Vector3d min = Eigen::Vector3d::Zero(), max = Eigen::Vector3d::Zero();
  std::array<bool, 3> periodic{};

  bool is_periodic(int axis) const { return periodic[static_cast<std::size_t>(axis)]; }
  // From b to a by the shortest way.
  Eigen::Vector3d between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
    Eigen::Vector3d d = a - b;
    for (int axis = 0; axis < 3; ++axis) {
      const double length = max[axis] - min[axis];
      if (is_periodic(axis) && 2 * std::abs(d[axis]) > length) d[axis] -= length * std::round(d[axis] / length);
    }
    return d;
  }
  // Into min <= p < max on periodic axes.
  Eigen::Vector3d wrapped(Eigen::Vector3d p) const {
    for (int axis = 0; axis < 3; ++axis) {
      const double length = max[axis] - min[axis];
      if (!is_periodic(axis)) continue;
      p[axis] -= length * std::floor((p[axis] - min[axis]) / length);
      if (p[axis] >= max[axis]) p[axis] = min[axis];
    }
    return p;
  }
};

class PointGrid {
 public:
  // Keeps a reference to the points, which must be finite. `reach`: the radius that near() covers.
  PointGrid(const std::vector<Eigen::Vector3d>& points, const PeriodicBox& box, double reach) : box_(box) {
    for (int axis = 0; axis < 3; ++axis) {
      const double length = box.max[axis] - box.min[axis];
      cells_[axis] = box.is_periodic(axis) ? std::max(1.0, std::floor(length / reach)) : 0;
      size_[axis] = box.is_periodic(axis) ? length / cells_[axis] : reach;
    }
    std::size_t buckets = 1;
    while (buckets < points.size()) buckets *= 2;
    mask_ = buckets - 1;
    first_.assign(buckets + 1, 0);
    entry_.resize(points.size());
    std::vector<Cell> cells(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      cells[i] = cell_of(points[i]);
      ++first_[bucket(cells[i]) + 1];
    }
    for (std::size_t b = 0; b < buckets; ++b) first_[b + 1] += first_[b];
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < points.size(); ++i) {
      entry_[next[bucket(cells[i])]++] = {cells[i], static_cast<std::uint32_t>(i)};
    }
  }

  // Calls visit(index) for every point within reach of p, and for some farther ones; each once.
  template <class Visit>
  void near(const Eigen::Vector3d& p, Visit&& visit) const {
    const Cell center = cell_of(p);
    std::array<int, 3> low, high;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double cells = cells_[static_cast<int>(axis)];
      low[axis] = cells == 1 || cells == 2 ? 0 : -1;
      high[axis] = cells == 1 ? 0 : 1;
    }
    for (int z = low[2]; z <= high[2]; ++z) {
      for (int y = low[1]; y <= high[1]; ++y) {
        for (int x = low[0]; x <= high[0]; ++x) {
          const Cell cell = wrapped({center[0] + x, center[1] + y, center[2] + z});
          const std::size_t b = bucket(cell);
          for (std::uint32_t e = first_[b]; e < first_[b + 1]; ++e) {
            if (entry_[e].cell == cell) visit(entry_[e].index);
          }
        }
      }
    }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  struct Entry {
    Cell cell;
    std::uint32_t index;
  };

  Cell cell_of(const Eigen::Vector3d& p) const {
    Cell cell;
    for (int axis = 0; axis < 3; ++axis) {
      cell[static_cast<std::size_t>(axis)] =
          static_cast<std::int64_t>(std::floor((p[axis] - box_.min[axis]) / size_[axis]));
    }
    return wrapped(cell);
  }
  Cell wrapped(Cell cell) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto count = static_cast<std::int64_t>(cells_[static_cast<int>(axis)]);
      if (count > 0) cell[axis] = (cell[axis] % count + count) % count;
    }
    return cell;
  }
  std::size_t bucket(const Cell& c) const {
    const auto mix = static_cast<std::uint64_t>(c[0]) * 0x9E3779B97F4A7C15ULL ^
                     static_cast<std::uint64_t>(c[1]) * 0xC2B2AE3D27D4EB4FULL ^
                     static_cast<std::uint64_t>(c[2]) * 0x165667B19E3779F9ULL;
    return static_cast<std::size_t>(mix ^ mix >> 29) & mask_;
  }

  PeriodicBox box_;
  Eigen::Vector3d size_ = Eigen::Vector3d::Ones();
  Eigen::Vector3d cells_ = Eigen::Vector3d::Zero();  // per axis, 0: not periodic
  std::size_t mask_ = 0;
  std::vector<std::uint32_t> first_;
  std::vector<Entry> entry_;
};

}  // namespace palp
