// The cell grid and the loop over neighbours. Particles are stored sorted by cell, x fastest, so the cells of a row are
// one contiguous run of particles, or a few (CellGrid::tiled), and a neighbourhood is a few runs.
#pragma once

#include "sim_server/physics/real.h"

namespace palp {

struct CellGrid {
  Vec3 origin;                           // lowest corner of cell (0,0,0) [m]
  Vec3 cell, inv_cell;                   // cell edge and its inverse [m, 1/m]
  Vec3 period;                           // domain length along periodic axes, 0 elsewhere [m]
  int n[3];                              // cells per axis; periodic axes have at least 3
  real margin = 0;                       // distance past the domain up to which a particle takes part [m]
  bool tiled = false;                    // cells are numbered by tiles, so that particles that follow one
                                         // another lie in a compact block and have most neighbours in common
  const std::uint32_t* start = nullptr;  // [cells + 1] first particle of each cell

  PALP_HD bool periodic(int axis) const { return period[axis] > real(0); }
  // Particles outside the domain are binned in its outermost cells, where they still find each other.
  PALP_HD int cell_of(real x, int axis) const {
    const real c = (x - origin[axis]) * inv_cell[axis];
    if (!(c > real(0))) return 0;
    const int i = c < real(n[axis]) ? static_cast<int>(c) : n[axis] - 1;
    return i < n[axis] ? i : n[axis] - 1;
  }
  static constexpr int kTileCells = 128;
  PALP_HD static constexpr int tile(int axis) { return axis == 0 ? 8 : 4; }  // edge, in cells
  PALP_HD int tiles(int axis) const { return (n[axis] + tile(axis) - 1) / tile(axis); }
  PALP_HD std::uint32_t index(int cx, int cy, int cz) const {
    if (!tiled) return (static_cast<std::uint32_t>(cz) * n[1] + cy) * n[0] + cx;
    const std::uint32_t number =
        (static_cast<std::uint32_t>(cz / tile(2)) * tiles(1) + cy / tile(1)) * tiles(0) + cx / tile(0);
    return number * kTileCells + (cz % tile(2) * tile(1) + cy % tile(1)) * tile(0) + cx % tile(0);
  }
  // Sets the cell that has an index. Those of tiles at the domain's end may lie past it.
  PALP_HD void cell_at(std::uint32_t index, int (&at)[3]) const {
    const std::uint32_t size[3] = {std::uint32_t(tiled ? tile(0) : n[0]), std::uint32_t(tiled ? tile(1) : n[1]),
                                   std::uint32_t(tiled ? tile(2) : n[2])};
    const std::uint32_t within = index % (size[0] * size[1] * size[2]), number = index / (size[0] * size[1] * size[2]);
    const std::uint32_t nx = tiled ? tiles(0) : 1, ny = tiled ? tiles(1) : 1;
    at[0] = static_cast<int>(number % nx * size[0] + within % size[0]);
    at[1] = static_cast<int>(number / nx % ny * size[1] + within / size[0] % size[1]);
    at[2] = static_cast<int>(number / nx / ny * size[2] + within / size[0] / size[1]);
  }
  // Calls run(begin, end) for the runs of particles in the cells [first, last] of a row.
  template <class G>
  PALP_HD void for_row(int first, int last, int cy, int cz, G&& run) const {
    while (first <= last) {
      const int tile_end = first / tile(0) * tile(0) + tile(0) - 1, end = tiled && tile_end < last ? tile_end : last;
      const std::uint32_t* from = start + index(first, cy, cz);
      run(from[0], from[end - first + 1]);
      first = end + 1;
    }
  }
  PALP_HD std::uint32_t index_of(const Vec3& x) const {
    return index(cell_of(x.x(), 0), cell_of(x.y(), 1), cell_of(x.z(), 2));
  }
  PALP_HD std::uint32_t cells() const {
    return tiled ? static_cast<std::uint32_t>(tiles(0)) * tiles(1) * tiles(2) * kTileCells
                 : static_cast<std::uint32_t>(n[0]) * n[1] * n[2];
  }
  // Returns x moved back into the domain along periodic axes, by one period at most; a sub-step moves a particle by far
  // less.
  PALP_HD Vec3 wrap(Vec3 x) const {
    for (int a = 0; a < 3; ++a) {
      if (!periodic(a)) continue;
      if (x[a] < origin[a])
        x[a] += period[a];
      else if (x[a] >= origin[a] + period[a])
        x[a] -= period[a];
    }
    return x;
  }
  // Returns x moved back into the domain from anywhere: a body may have crossed a periodic domain many times, for its
  // centre is not wrapped.
  PALP_HD Vec3 wrap_fully(Vec3 x) const {
    for (int a = 0; a < 3; ++a)
      if (periodic(a)) x[a] -= period[a] * Eigen::numext::floor((x[a] - origin[a]) / period[a]);
    return x;
  }
};

// Returns the cell of x along one axis; along a periodic one cells are counted on past the domain's ends.
PALP_HD inline int open_cell(const CellGrid& g, int axis, real x) {
  if (!g.periodic(axis)) return g.cell_of(x, axis);
  const real c = Eigen::numext::floor((x - g.origin[axis]) * g.inv_cell[axis]);
  const int n = g.n[axis];
  // in this form a position that is not a number has a cell too
  return c > real(-n) ? (c < real(2 * n) ? static_cast<int>(c) : 2 * n - 1) : -n;
}

// Returns the cell of the domain that a cell past the ends of a periodic axis is an image of, and in `shift` the length
// to add to the positions of its particles.
PALP_HD inline int wrapped_cell(const CellGrid& g, int axis, int cell, real& shift) {
  shift = real(0);
  if (cell < 0) {
    shift = -g.period[axis];
    return cell + g.n[axis];
  }
  if (cell >= g.n[axis]) {
    shift = g.period[axis];
    return cell - g.n[axis];
  }
  return cell;
}

// Returns the distance of x, in cell c, from a row of cells along one axis.
PALP_HD inline real gap_to(const CellGrid& g, int axis, real x, int c, int row) {
  if (row == c) return real(0);
  const real edge = g.origin[axis] + static_cast<real>(row < c ? row + 1 : row) * g.cell[axis];
  return row < c ? x - edge : edge - x;
}

// Calls run(begin, end, shift) for runs of particles that together hold all within reach of x_i; add shift to their
// positions. The rows of cells are shared among the team's groups.
template <class Team, class G>
PALP_HD inline void for_each_run(const CellGrid& g, const Vec3& x_i, real reach, Team team, G&& run) {
  reach *= real(1.0001);  // rounding must not lose a particle at the very edge
  const real y = x_i.y(), z = x_i.z();
  const int cy = open_cell(g, 1, y), cz = open_cell(g, 2, z);
  const int y0 = open_cell(g, 1, y - reach), y1 = open_cell(g, 1, y + reach);
  const int z0 = open_cell(g, 2, z - reach), z1 = open_cell(g, 2, z + reach);
  const int rows_y = y1 - y0 + 1;
  int rz = z0 + team.group() / rows_y, ry = y0 + team.group() % rows_y;
  for (; rz <= z1; ry += team.groups()) {
    while (ry > y1) {
      ry -= rows_y;
      ++rz;
    }
    if (rz > z1) break;
    const real gap_y = gap_to(g, 1, y, cy, ry), gap_z = gap_to(g, 2, z, cz, rz);
    const real half2 = reach * reach - gap_y * gap_y - gap_z * gap_z;
    if (!(half2 > real(0))) continue;
    const real half = Eigen::numext::sqrt(half2);
    Vec3 shift(0, 0, 0);
    const int wy = wrapped_cell(g, 1, ry, shift[1]), wz = wrapped_cell(g, 2, rz, shift[2]);
    const int first = open_cell(g, 0, x_i.x() - half), last = open_cell(g, 0, x_i.x() + half);
    const int n = g.n[0];
    const auto shifted = [&](std::uint32_t begin, std::uint32_t end) { run(begin, end, shift); };
    g.for_row(first > 0 ? first : 0, last < n ? last : n - 1, wy, wz, shifted);
    // a periodic row goes on at its other end
    if (first < 0) {
      shift[0] = -g.period[0];
      g.for_row(first + n, n - 1, wy, wz, shifted);
    }
    if (last >= n) {
      shift[0] = g.period[0];
      g.for_row(0, last - n, wy, wz, shifted);
    }
  }
}

// Returns d between nearest images.
PALP_HD inline Vec3 nearest_image(const CellGrid& g, Vec3 d) {
  for (int a = 0; a < 3; ++a)
    if (g.periodic(a)) d[a] -= g.period[a] * Eigen::numext::floor(d[a] / g.period[a] + real(0.5));
  return d;
}

// Returns d, by the shortest way along periodic axes; both places lie in the domain.
template <class S>
PALP_HD inline Vec3Of<S> shortest(const CellGrid& g, Vec3Of<S> d) {
  for (int a = 0; a < 3; ++a) {
    const real period = g.period[a], half = real(0.5) * period;
    if (half == real(0)) continue;
    d[a] = select(d[a] > half, d[a] - period, select(d[a] < -half, d[a] + period, d[a]));
  }
  return d;
}

// Returns x_i - x_j, by the shortest way along periodic axes.
PALP_HD inline Vec3 separation(const CellGrid& g, const Vec3& x_i, const Packed& x_j) {
  return shortest<real>(g, Vec3(x_i.x() - x_j.x, x_i.y() - x_j.y, x_i.z() - x_j.z));
}

// Calls f(j, xV_j, x_i - x_j, r^2) for every particle j within the support radius of x_i, the particle itself included.
// A team of lanes shares the loop: its groups share the rows of cells, the lanes of a group the particles of a row.
template <class Team, class F>
PALP_HD inline void for_neighbors(const CellGrid& g, const Packed* xV, const Vec3& x_i, real support, Team team,
                                  F&& f) {
  const real support2 = support * support;
  for_each_run(g, x_i, support, team, [&](std::uint32_t begin, std::uint32_t end, const Vec3& shift) {
    const Vec3 x = x_i - shift;
    for (std::uint32_t j = begin + team.lane(); j < end; j += team.size()) {
      const Packed x_j = xV[j];
      const Vec3 d(x.x() - x_j.x, x.y() - x_j.y, x.z() - x_j.z);
      const real r2 = d.squaredNorm();
      if (r2 < support2) f(j, x_j, d, r2);
    }
  });
}

// The CPU's team: one thread does the whole loop.
struct SerialTeam {
  using Real = real;
  PALP_HD int group() const { return 0; }
  PALP_HD int groups() const { return 1; }
  PALP_HD std::uint32_t lane() const { return 0; }
  PALP_HD std::uint32_t size() const { return 1; }
  PALP_HD bool leader() const { return true; }
  template <class T>
  PALP_HD T sum(const T& value) const {
    return value;
  }
  PALP_HD real max(real value) const { return value; }
  // Calls f(i) for those i of [begin, end) of which test(i) is true.
  template <class Test, class F>
  PALP_HD void for_those(std::uint32_t begin, std::uint32_t end, Test&& test, F&& f) const {
    for (std::uint32_t i = begin; i < end; ++i)
      if (test(i)) f(i);
  }
};

// Returns f(pairs): a team that takes several neighbours at a time where alike(j) is true of all of them, if they may
// be taken so and there is such a team (list_team.h), else the team itself. pairs.Real: the scalar of what it calls for
// pairs.
template <class Team, class Alike, class F>
PALP_HD inline auto by_lanes(Team team, bool, const Alike&, F&& f) {
  return f(team);
}

}  // namespace palp
