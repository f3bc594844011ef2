// Contact of matter that has frozen or set (state_change.h) with rigid and fixed bodies, by the law for elastic bodies:
// it gets the solid's share K of the force, while the fluid's forces keep 1 - K (bonded.h).
//
// A fluid's particles may be nearer to a wall than half a spacing. A particle that freezes there may stay there until
// it has left, so that freezing pushes nothing away and stores no energy.
//
// A drop that tore off has lost the density of those that it left, and no pressure keeps it out of a wall before it is
// deep inside: liquid particles meet walls too, without friction, at a fifth of a spacing, where fluids otherwise do
// not get to.
#pragma once

#include "sim_server/physics/elastic_contact.h"
#include "sim_server/physics/state_change.h"

namespace palp {

// The matter that changes state, by slot (ElasticMatter has the meaning of the members).
struct FrozenMatter {
  ChangeViews change;
  Medium medium;
  ClosestApproach* near;  // by contact state, from the state `first` on
  std::uint32_t first;

  PALP_HD bool acts(std::uint32_t i) const { return change.x[i].w > real(0); }
  PALP_HD bool rough(std::uint32_t i) const { return change.solid[i] > real(0); }
  PALP_HD real share(std::uint32_t i) const { return rough(i) ? change.solid[i] : real(1); }
  PALP_HD Motion motion(std::uint32_t i) const { return {change.x[i].xyz(), change.v[i].xyz(), Vec3(0, 0, 0), false}; }
  PALP_HD real mass(std::uint32_t i) const { return medium.material[change.tag[i].material()].density * change.x[i].w; }
  PALP_HD void add(std::uint32_t i, const Vec3& f) const { change.force[i] = pack(change.force[i].xyz() + f, 0); }
  PALP_HD real reach(std::uint32_t i, std::uint32_t place, real half, real distance) const {
    const std::uint32_t solid = rough(i) ? 1 : 0;
    const real limit = solid != 0 ? half : real(0.4) * half;
    ClosestApproach& kept = near[place - first];
    if (distance >= limit)
      kept = {limit, solid};
    else if (kept.solid != solid)
      kept = {distance, solid};
    return kept.reach;
  }
};

}  // namespace palp
