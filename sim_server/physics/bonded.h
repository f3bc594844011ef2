// What bonds (state_change.h) leave of a pair's fluid forces, and of its part in the density's rate: 1 - K_i K_j, K
// being the solid fraction, and 1 - K towards rigid and fixed bodies of other groups that have a distance field, by
// which they meet what is solid (frozen_contact.h). Eq. 6 of the paper has K^f_i K^f_j = (1 - K_i)(1 - K_j) there (method "paper"), which gives
// a mush of K = 1/2 half of the forces that either state has, and lets water flow through what has frozen.
#pragma once

#include "sim_server/physics/particles.h"

namespace palp {

// For scenes in which nothing changes state.
struct NoBonds {
  PALP_HD static real solid(const ParticleView&, std::uint32_t) { return real(0); }
  PALP_HD real share(Tag, real, Tag, real) const { return real(1); }
  PALP_HD real paper_share(Tag, real, Tag, real) const { return real(1); }
};

struct Bonded {
  const std::uint32_t* group;   // by body: matter that bonds
  const std::uint32_t* shaped;  // by body: 1 where it has a distance field

  PALP_HD static real solid(const ParticleView& view, std::uint32_t i) { return view.solid[i]; }
  PALP_HD real share(Tag tag_i, real K_i, Tag tag_j, real K_j) const {
    const real K = tag_i.is_fluid() ? K_i : K_j;
    if (!(K > real(0))) return real(1);
    if (group[tag_i.body()] == group[tag_j.body()]) return real(1) - K_i * K_j;
    if (tag_i.is_fluid() == tag_j.is_fluid()) return real(1);
    return shaped[(tag_i.is_fluid() ? tag_j : tag_i).body()] != 0 ? real(1) - K : real(1);
  }
  // A particle without bonds, K = 0, has left the solid: between them forces are those of two bodies.
  PALP_HD real paper_share(Tag tag_i, real K_i, Tag tag_j, real K_j) const {
    const bool bonded = K_i > real(0) && K_j > real(0) && group[tag_i.body()] == group[tag_j.body()];
    return bonded ? (real(1) - K_i) * (real(1) - K_j) : real(1);
  }
};

}  // namespace palp
