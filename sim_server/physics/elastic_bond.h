// The bond of an elastic particle with a neighbour at rest, and whose gradients are taken from it.
#pragma once

#include "sim_server/physics/real.h"

namespace palp {

// Marks beside a neighbour's index: the particle's own gradient is not taken from this bond; the neighbour's is not.
inline constexpr std::uint32_t kNotInMine = 0x80000000u, kNotInTheirs = 0x40000000u;

// A particle's bond with a neighbour.
struct ElasticBond {
  std::uint32_t neighbor;  // index with marks
  PALP_HD std::uint32_t j() const { return neighbor & ~(kNotInMine | kNotInTheirs); }
  PALP_HD bool in_mine() const { return (neighbor & kNotInMine) == 0; }
  PALP_HD bool in_theirs() const { return (neighbor & kNotInTheirs) == 0; }
  // Return the sum over the sides whose gradients the bond is in, the same bits from either side.
  PALP_HD Mat3 sum(const Mat3& mine, const Mat3& theirs) const {
    return real(in_mine()) * mine + real(in_theirs()) * theirs;
  }
  PALP_HD real sum(real mine, real theirs) const { return real(in_mine()) * mine + real(in_theirs()) * theirs; }
};

}  // namespace palp
