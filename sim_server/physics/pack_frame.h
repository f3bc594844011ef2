// Positions and one scalar of every particle in the scene's order, for streaming: 12 or 16 bytes a particle.
#pragma once

#include "sim_server/physics/particles.h"
#include "sim_server/solver/simulation.h"

namespace palp {

PALP_HD inline real density_of(const Medium& medium, Tag tag, real p) {
  const Material& m = medium.material[tag.material()];
  return tag.is_fluid() ? m.density + p / (m.sound_speed * m.sound_speed) : m.density;
}

struct PackFrame {
  ParticleView state;
  Medium medium;
  float* position;
  float* scalar;  // unused when none is asked for
  FrameScalar field;

  PALP_HD float value(std::uint32_t i) const {
    const Packed vp = state.vp[i];
    switch (field) {
      case FrameScalar::speed:
        return static_cast<float>(vp.xyz().norm());
      case FrameScalar::density:
        return static_cast<float>(density_of(medium, state.tag[i], vp.w));
      case FrameScalar::pressure:
        return static_cast<float>(acting_pressure(medium, vp.w));
      case FrameScalar::temperature:
        return state.temperature != nullptr ? static_cast<float>(state.temperature[i]) : 0.0f;
      case FrameScalar::none:
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
    if (field != FrameScalar::none) scalar[to] = value(i);
  }
};

}  // namespace palp
