// Positions, one scalar and how solid it is of every particle in the scene's order, for streaming: 12 to 17 bytes a
// particle.
#pragma once

#include "sim_server/physics/equation_of_state.h"
#include "sim_server/physics/particles.h"

namespace palp {

// Returns a particle's density, of a fluid at pressure p [kg/m^3].
PALP_HD inline real density_of(const Medium& medium, Tag tag, real p) {
  const Material& m = medium.material[tag.material()];
  return tag.is_fluid() ? density_at(p, m.density, m.sound_speed) : m.density;
}

// Writes them into arrays in the scene's order.
struct PackFrame {
  ParticleView state;
  Medium medium;
  float* position;
  float* scalar;  // unused when none is asked for
  ScalarField field;
  std::uint8_t* solid;  // in 255ths; null where nothing changes state

  PALP_HD float value(std::uint32_t i) const {
    const Packed vp = state.vp[i];
    switch (field) {
      case ScalarField::speed:
        return static_cast<float>(vp.xyz().norm());
      case ScalarField::density:
        return static_cast<float>(density_of(medium, state.tag[i], vp.w));
      case ScalarField::pressure:
        return static_cast<float>(acting_pressure(medium, vp.w));
      case ScalarField::temperature:
        return state.temperature != nullptr ? static_cast<float>(state.temperature[i]) : 0.0f;
      case ScalarField::density_error: {
        const Tag tag = state.tag[i];
        return static_cast<float>(density_of(medium, tag, vp.w) / medium.material[tag.material()].density - real(1));
      }
      case ScalarField::state:
        return state.tag[i].is_fluid() || state.tag[i].kind() == BodyKind::elastic ? static_cast<float>(solid_share(i))
                                                                                   : 1.0f;
      case ScalarField::none:
        break;
    }
    return 0.0f;
  }
  // Returns how much of a particle of a fluid or an elastic body is solid, 0 to 1.
  PALP_HD real solid_share(std::uint32_t i) const {
    if (solid == nullptr) return state.tag[i].is_fluid() ? real(0) : real(1);
    const real share = state.solid[i].K;
    return share > 0 ? (share < 1 ? share : real(1)) : real(0);
  }
  PALP_HD void operator()(std::uint32_t i) const {
    const std::uint32_t to = state.id[i];
    const Packed x = state.xV[i];
    position[3 * std::size_t(to)] = static_cast<float>(x.x);
    position[3 * std::size_t(to) + 1] = static_cast<float>(x.y);
    position[3 * std::size_t(to) + 2] = static_cast<float>(x.z);
    if (field != ScalarField::none) scalar[to] = value(i);
    if (solid != nullptr) solid[to] = static_cast<std::uint8_t>(real(255) * solid_share(i) + real(0.5));
  }
};

}  // namespace palp
