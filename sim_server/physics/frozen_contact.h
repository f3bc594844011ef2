// Contact of what has frozen or set (state_change.h) with rigid and fixed bodies, as that of elastic bodies: the
// solid's share K of it, while the fluid's forces keep 1 - K (bonded.h).
//
// A fluid's particles may be nearer to a wall than half a spacing. What freezes there may stay
// there until it has left, so that freezing pushes nothing away and stores no energy.
#pragma once

#include "sim_server/physics/elastic_contact.h"
#include "sim_server/physics/state_change.h"

namespace palp {

struct FrozenMatter {
  ChangeViews change;
  Medium medium;
  real* near;  // by contact state from `first` on: how near it may be [m], negative: it is not solid
  std::uint32_t first;

  PALP_HD real share(std::uint32_t i) const { return change.solid[i]; }
  PALP_HD Motion motion(std::uint32_t i) const { return {change.x[i].xyz(), change.v[i].xyz(), Vec3(0, 0, 0), false}; }
  PALP_HD real mass(std::uint32_t i) const { return medium.material[change.tag[i].material()].density * change.x[i].w; }
  PALP_HD void add(std::uint32_t i, const Vec3& f) const { change.force[i] = pack(change.force[i].xyz() + f, 0); }
  PALP_HD void let_go(std::uint32_t place) const { near[place - first] = real(-1); }
  PALP_HD real reach(std::uint32_t place, real half, real distance) const {
    real& kept = near[place - first];
    if (distance >= half)
      kept = half;
    else if (kept < real(0))
      kept = distance > real(0) ? distance : real(0);
    return kept;
  }
};

}  // namespace palp
