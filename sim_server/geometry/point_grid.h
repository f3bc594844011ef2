// Points in a uniform grid, for finding those near a place; and a domain that may be periodic. Host, double
// precision, for checks and probes. Results come in an order that depends only on the points.
#pragma once

#include <algorithm>
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
  // `reach`: the radius that near() covers. The points must be finite.
  PointGrid(const std::vector<Eigen::Vector3d>& points, const PeriodicBox& box, double reach) : origin_(box.min) {
    for (int axis = 0; axis < 3; ++axis) {
      const double length = box.max[axis] - box.min[axis];
      Axis& a = axis_[axis];
      a.periodic = box.is_periodic(axis);
      if (a.periodic)
        a.cells = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::min(length / reach, 1e9)), 1, kMostCells);
      a.size = a.periodic ? length / static_cast<double>(a.cells) : reach;
    }
    choose_cells(points);
    first_.assign(mask_ + 2, 0);
    entry_.resize(points.size());
    std::vector<std::uint64_t> number(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      number[i] = row_of(folded(1, cell_of(points[i], 1)), folded(2, cell_of(points[i], 2))) +
                  static_cast<std::uint64_t>(folded(0, cell_of(points[i], 0)));
      ++first_[(number[i] & mask_) + 1];
    }
    for (std::size_t b = 0; b <= mask_; ++b) first_[b + 1] += first_[b];
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < points.size(); ++i)
      entry_[next[number[i] & mask_]++] = {number[i], static_cast<std::uint32_t>(i)};
  }

  // Calls visit(index) for every point within reach of p, and for some farther ones; each once.
  template <class Visit>
  void near(const Eigen::Vector3d& p, Visit&& visit) const {
    std::array<std::int64_t, 3> low, high;
    for (int axis = 0; axis < 3; ++axis) {
      const Axis& a = axis_[axis];
      const auto k = static_cast<std::size_t>(axis);
      const std::int64_t center = cell_of(p, axis);
      low[k] = center - (a.periodic && a.cells <= 2 ? 0 : 1);
      high[k] = center + (a.periodic && a.cells == 1 ? 0 : 1);
      if (a.folds) continue;
      low[k] = std::max<std::int64_t>(low[k], 0);
      high[k] = std::min(high[k], a.cells - 1);
    }
    for (std::int64_t z = low[2]; z <= high[2]; ++z) {
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        const std::uint64_t row = row_of(folded(1, y), folded(2, z));
        for (std::int64_t x = low[0]; x <= high[0]; ++x) {
          const std::uint64_t number = row + static_cast<std::uint64_t>(folded(0, x));
          const std::size_t b = number & mask_;
          for (std::uint32_t e = first_[b]; e < first_[b + 1]; ++e)
            if (entry_[e].cell == number) visit(entry_[e].index);
        }
      }
    }
  }

 private:
  static constexpr std::int64_t kMostCells = 1 << 20;  // along an axis, so that a cell's number has less than 64 bits
  struct Axis {
    bool periodic = false;
    bool folds = false;      // cells past the ends are others' cells
    std::int64_t cells = 0;  // from the first one that holds a point on
    std::int64_t first = 0;
    double size = 1;
  };
  struct Entry {
    std::uint64_t cell;
    std::uint32_t index;
  };

  // Numbers the cells that hold points in rows along x, and chooses as many buckets, or where cells are many fewer. A
  // bucket is a number's lowest bits, so that neighbouring cells lie side by side in memory.
  void choose_cells(const std::vector<Eigen::Vector3d>& points) {
    double cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
      Axis& a = axis_[axis];
      if (!a.periodic && !points.empty()) {
        double low = points.front()[axis], high = low;
        for (const Eigen::Vector3d& p : points) {
          low = std::min(low, p[axis]);
          high = std::max(high, p[axis]);
        }
        const auto cell = [&](double x) { return static_cast<std::int64_t>(std::floor((x - origin_[axis]) / a.size)); };
        a.first = cell(low);
        a.cells = cell(high) - a.first + 1;
      }
      a.folds = a.periodic || a.cells > kMostCells;
      a.cells = std::min(a.cells, kMostCells);
      cells *= static_cast<double>(a.cells);
    }
    const double wanted = std::min(cells, 4.0 * static_cast<double>(points.size()));
    std::size_t buckets = 1;
    while (static_cast<double>(buckets) < wanted) buckets *= 2;
    mask_ = buckets - 1;
  }

  std::int64_t cell_of(const Eigen::Vector3d& p, int axis) const {
    const Axis& a = axis_[axis];
    return static_cast<std::int64_t>(std::floor((p[axis] - origin_[axis]) / a.size)) - a.first;
  }
  std::int64_t folded(int axis, std::int64_t cell) const {
    const Axis& a = axis_[axis];
    if (cell >= 0 && cell < a.cells) return cell;
    return (cell % a.cells + a.cells) % a.cells;
  }
  std::uint64_t row_of(std::int64_t y, std::int64_t z) const {
    return static_cast<std::uint64_t>((z * axis_[1].cells + y) * axis_[0].cells);
  }

  Eigen::Vector3d origin_;
  Axis axis_[3];
  std::size_t mask_ = 0;
  std::vector<std::uint32_t> first_;
  std::vector<Entry> entry_;
};

}  // namespace palp
