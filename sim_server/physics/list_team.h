// The CPU's teams: one thread with a stored list of a particle's neighbours, which reaches somewhat past the support
// radius and so is valid until a particle has moved by half of that margin.
#pragma once

#include "sim_server/physics/cell_grid.h"
#include "sim_server/physics/lanes.h"

namespace palp {

struct ListTeam : SerialTeam {
  const std::uint32_t* begin;
  const std::uint32_t* end;
  ListTeam(const std::uint32_t* from, const std::uint32_t* to) : begin(from), end(to) {}
};

// Calls f as for_neighbors() of cell_grid.h, in two passes over each block of the list. The first has no branches,
// because a processor cannot predict which neighbours are in reach. Always inline, so that the sums of f stay in
// registers.
template <class F>
[[gnu::always_inline]] inline void for_neighbors(const CellGrid& g, const Packed* xV, const Vec3& x_i, real support,
                                                 ListTeam team, F&& f) {
  constexpr std::ptrdiff_t kBlock = 128;
  struct Hit {
    std::uint32_t j;
    real r2;
    Vec3 d;
  } hits[kBlock + 1];
  const real support2 = support * support;
  const bool periodic = g.periodic(0) || g.periodic(1) || g.periodic(2);
  for (const std::uint32_t* block = team.begin; block < team.end; block += kBlock) {
    const std::uint32_t* end = team.end - block > kBlock ? block + kBlock : team.end;
    int count = 0;
    for (const std::uint32_t* j = block; j != end; ++j) {
      const Vec3 d = periodic ? separation(g, x_i, xV[*j]) : Vec3(x_i - xV[*j].xyz());
      const real r2 = d.squaredNorm();
      hits[count] = {*j, r2, d};
      count += r2 < support2 ? 1 : 0;
    }
    for (int k = 0; k < count; ++k) f(hits[k].j, xV[hits[k].j], hits[k].d, hits[k].r2);
  }
}

// The same, by the lanes of a vector register.
template <class Alike>
struct VectorTeam : ListTeam {
  using Real = Lanes;
  Alike alike;
  VectorTeam(const ListTeam& of, const Alike& says) : ListTeam(of), alike(says) {}
  real sum(const Lanes& value) const { return palp::sum(value); }
  Vec3 sum(const Vec3Of<Lanes>& v) const { return {sum(v.x()), sum(v.y()), sum(v.z())}; }
};
template <class Alike, class F>
auto by_lanes(ListTeam team, bool may, const Alike& alike, F&& f) {
  return may ? f(VectorTeam<Alike>(team, alike)) : f(team);
}

// Calls f(j, xV_j, x_ij, r2), all of them in lanes, with as many neighbours as there are lanes, or as are alike in a
// row: the first of them stands for what they have in common. Others come one by one. Lanes past the support radius, or
// left over, have no volume, since to pass them over would cost more than what comes to nothing. Always inline, as
// above, and f is called in one place, so that it is inlined, too.
template <class Alike, class F>
[[gnu::always_inline]] inline void for_neighbors(const CellGrid& g, const Packed* xV, const Vec3& x_i, real support,
                                                 VectorTeam<Alike> team, F&& f) {
  const Lanes support2 = support * support, number = lane_numbers();
  const Vec3Of<Lanes> x = x_i.cast<Lanes>();
  const bool periodic = g.periodic(0) || g.periodic(1) || g.periodic(2);
  for (const std::uint32_t* at = team.begin; at < team.end;) {
    const std::ptrdiff_t left = team.end - at;
    std::ptrdiff_t taken = left < kLanes ? left : kLanes;
    LaneIndex j;
    if (left >= kLanes)
      std::memcpy(j.of, at, sizeof(j.of));
    else
      for (int k = 0; k < kLanes; ++k) j.of[k] = at[k < left ? k : 0];
    bool alike = true;
    for (const std::uint32_t one : j.of) alike = alike & team.alike(one);
    if (!alike) {
      std::ptrdiff_t run = 1;
      if (team.alike(*at))
        while (run < taken && team.alike(at[run])) ++run;
      taken = run;
      for (std::ptrdiff_t k = taken; k < kLanes; ++k) j.of[k] = *at;
    }
    PackedOf<Lanes> xV_j = fetch<Lanes>(xV, j);
    Vec3Of<Lanes> d = x - xV_j.xyz();
    if (periodic) d = shortest(g, d);
    const Lanes r2 = d.squaredNorm();
    xV_j.w = select(r2 < support2, xV_j.w, Lanes(0));
    if (taken < kLanes) xV_j.w = select(number < Lanes(static_cast<real>(taken)), xV_j.w, Lanes(0));
    f(j, xV_j, d, r2);
    at += taken;
  }
}

}  // namespace palp
