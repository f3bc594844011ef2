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
      case ScalarField::none:
        break;
    }
    return 0.0f;
  }
  PALP_HD void operator()(std::uint32_t i) const {
    const std::uint32_t to = state.id[i];
    const Packed x = state.xV[i];
    position[3 * std::size_t(to)] = static_cast<float>(x.x);
    position[3 * std::size_t(to) + 1] = static_cast<float>(x.y);
    position[3 * std::size_t(to) + 2] = static_cast<float>(x.z);
    if (field != ScalarField::none) scalar[to] = value(i);
    if (solid != nullptr) {
      const real share = state.solid[i].K;
      solid[to] =
          static_cast<std::uint8_t>(share > 0 ? (share < 1 ? real(255) * share + real(0.5) : real(255)) : real(0));
    }
  }
};

}  // namespace palp
