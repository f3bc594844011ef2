// Moves the particles at the end of a sub-step: fluids by symplectic Euler, rigid bodies' particles with
// their body, elastic ones where elastic.h moved them.
#pragma once

#include "sim_server/physics/elastic.h"

namespace palp {

struct MoveParticles {
  ParticleView state;
  const Packed* acceleration;  // of fluids
  BodyViews bodies;
  ElasticViews elastic;
  CellGrid grid;
  real dt;

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = state.tag[i];
    if (tag.kind() == Kind::fixed) return;
    const Packed xV = state.xV[i], vp = state.vp[i];
    Vec3 x, v;
    if (tag.is_fluid()) {
      v = vp.xyz() + dt * acceleration[i].xyz();
      x = xV.xyz() + dt * v;
    } else {
      const BodyState& body = bodies.body[tag.body()];
      const std::uint32_t k = body.force_first + state.id[i] - body.first;
      if (tag.kind() == Kind::elastic) {
        v = elastic.v[k].xyz();
        x = grid.wrap_fully(elastic.rest[k].xyz() + elastic.u[k].xyz());
      } else {
        const Vec3 r = body.q * bodies.local[k].xyz();
        v = body.v + body.w.cross(r);
        x = grid.wrap_fully(body.x + r);
      }
    }
    state.xV[i] = pack(grid.wrap(x), xV.w);
    state.vp[i] = pack(v, vp.w);
  }
};

}  // namespace palp
