// The share of a pair's fluid forces, and of its part in the density's rate, that bonds (state_change.h) leave: 1 - K_i
// K_j, K being the solid fraction, and 1 - K towards rigid and fixed bodies of other groups that have a distance field,
// by which they meet what is solid (frozen_contact.h). Eq. 6 of the paper has K^f_i K^f_j = (1 - K_i)(1 - K_j) there
// (method "paper"), which gives a mush of K = 1/2 half of the forces that either state has, and lets water flow through
// what has frozen. Between two pieces there are no bonds, and fluid forces in full: they are two bodies (paper 3.2).
#pragma once

#include "sim_server/physics/particles.h"

namespace palp {

PALP_HD inline bool may_be_bonded(std::uint32_t piece_i, std::uint32_t piece_j) {
  return piece_i == piece_j || piece_i == kNone || piece_j == kNone;
}

// The policy of scenes in which nothing changes state.
struct NoBonds {
  PALP_HD static real solid(const ParticleView&, std::uint32_t) { return real(0); }
  PALP_HD bool leaves_all(real) const { return true; }
  PALP_HD real share(Tag, real, Tag, real) const { return real(1); }
  PALP_HD real paper_share(Tag, real, Tag, real) const { return real(1); }
  PALP_HD real wall_share(Tag, real, std::uint32_t) const { return real(1); }
};

// The policy of scenes in which matter changes state.
struct Bonded {
  const std::uint32_t* group;   // by body: bonds form within a group
  const std::uint32_t* shaped;  // by body: 1 where it has a distance field

  PALP_HD static Solidity solid(const ParticleView& view, std::uint32_t i) { return view.solid[i]; }
  // Returns whether bonds leave all of the forces between a fluid particle and any other.
  PALP_HD bool leaves_all(Solidity i) const { return !(i.K > real(0)); }
  PALP_HD bool bonded(Tag tag_i, Solidity i, Tag tag_j, Solidity j) const {
    return i.K * j.K > real(0) && group[tag_i.body()] == group[tag_j.body()] && may_be_bonded(i.piece, j.piece);
  }
  PALP_HD real share(Tag tag_i, Solidity i, Tag tag_j, Solidity j) const {
    if (bonded(tag_i, i, tag_j, j)) return real(1) - i.K * j.K;
    const real K = tag_i.is_fluid() ? i.K : j.K;
    if (!(K > real(0)) || tag_i.is_fluid() == tag_j.is_fluid()) return real(1);
    if (group[tag_i.body()] == group[tag_j.body()]) return real(1);
    return shaped[(tag_i.is_fluid() ? tag_j : tag_i).body()] != 0 ? real(1) - K : real(1);
  }
  // Returns the share towards a body that has a distance field.
  PALP_HD real wall_share(Tag tag, Solidity i, std::uint32_t body) const {
    return group[tag.body()] == group[body] ? real(1) : real(1) - i.K;
  }
  // A particle without bonds, K = 0, has left the solid: between them forces are those of two bodies.
  PALP_HD real paper_share(Tag tag_i, Solidity i, Tag tag_j, Solidity j) const {
    return bonded(tag_i, i, tag_j, j) ? (real(1) - i.K) * (real(1) - j.K) : real(1);
  }
};

}  // namespace palp
