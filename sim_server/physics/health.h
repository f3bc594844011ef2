// The figures by which the server decides whether to trust a state: non-finite values, largest speed and compression,
// energy.
#pragma once

#include "sim_server/physics/equation_of_state.h"
#include "sim_server/physics/rigid.h"

namespace palp {

struct HealthSums {
  real max_speed = 0;        // [m/s]
  real max_mach = 0;         // largest speed over the sound speed in the particle's medium
  real max_compression = 0;  // rho / rho0 - 1
  real kinetic_energy = 0;   // energy of fluids and elastic bodies [J]
  real fluid_mass = 0;       // [kg]
  real compressed_mass = 0;  // sum of mass times compression, of particles that are compressed [kg]
  real unsolved = 0;         // share of the energy of an implicit solve that its last round still changed
  std::uint32_t non_finite = 0;
  std::uint32_t outside = 0;   // particles outside the domain
  std::uint32_t inactive = 0;  // those of them that take no part any more (outside.h)
  std::uint32_t asleep = 0;    // particles that are not computed because they rest (sleep.h)
  real inactive_mass = 0;      // their mass [kg]
};

// Returns the number of parts in which n particles are measured: many, to fill a GPU, but each has sums to combine.
PALP_HD inline std::uint32_t health_parts(std::uint32_t n) { return n < 64 * 512 ? n / 64 + 1 : 512; }

template <class Team>
PALP_HD inline HealthSums combine(HealthSums s, Team team) {
  s.max_speed = team.max(s.max_speed);
  s.max_mach = team.max(s.max_mach);
  s.max_compression = team.max(s.max_compression);
  s.kinetic_energy = team.sum(s.kinetic_energy);
  s.fluid_mass = team.sum(s.fluid_mass);
  s.compressed_mass = team.sum(s.compressed_mass);
  s.non_finite = team.sum(s.non_finite);
  s.outside = team.sum(s.outside);
  s.inactive = team.sum(s.inactive);
  s.asleep = team.sum(s.asleep);
  s.inactive_mass = team.sum(s.inactive_mass);
  return s;
}

// Measures each of health_parts() equal parts of the particles; one team a part.
struct MeasureHealth {
  ParticleView state;
  Medium medium;
  CellGrid grid;
  std::uint32_t count;
  HealthSums* part;

  template <class Team>
  PALP_HD void operator()(std::uint32_t block, Team team) const {
    const std::uint32_t parts = health_parts(count);
    const std::uint32_t begin = static_cast<std::uint32_t>(std::uint64_t(count) * block / parts);
    const std::uint32_t end = static_cast<std::uint32_t>(std::uint64_t(count) * (block + 1) / parts);
    HealthSums s;
    for (std::uint32_t i = begin + team.lane(); i < end; i += team.size()) {
      const Tag tag = state.tag[i];
      const Packed xV = state.xV[i], vp = state.vp[i];
      const Vec3 v = vp.xyz();
      const real speed2 = v.squaredNorm();
      // comparisons that are false for NaN: fmax and its kin would hide it
      const real T = state.temperature != nullptr ? state.temperature[i] : real(0);
      if (!(speed2 + xV.xyz().squaredNorm() + vp.w * vp.w + T * T < real(1e30))) {
        ++s.non_finite;
        continue;
      }
      if (tag.inactive()) {
        ++s.outside;
        ++s.inactive;
        s.inactive_mass += state.mass[i];
        continue;
      }
      const Vec3 low = xV.xyz() - grid.origin;
      for (int a = 0; a < 3; ++a)
        if (!grid.periodic(a) && (low[a] < real(0) || low[a] * grid.inv_cell[a] > real(grid.n[a]))) {
          ++s.outside;
          break;
        }
      if (tag.asleep()) ++s.asleep;
      if (tag.kind() == BodyKind::fixed) continue;
      const real speed = Eigen::numext::sqrt(speed2);
      if (speed > s.max_speed) s.max_speed = speed;
      const Material& material = medium.material[tag.material()];
      const real mach = speed / (tag.is_fluid() ? material.sound_speed : medium.sound_speed);
      if (mach > s.max_mach) s.max_mach = mach;
      if (tag.kind() == BodyKind::elastic) s.kinetic_energy += real(0.5) * state.mass[i] * speed2;
      if (!tag.is_fluid()) continue;
      const real compression = compression_at(vp.w, material.density, material.sound_speed);
      if (compression > s.max_compression) s.max_compression = compression;
      s.fluid_mass += state.mass[i];
      if (compression > real(0)) s.compressed_mass += state.mass[i] * compression;
      s.kinetic_energy += real(0.5) * state.mass[i] * speed2;
    }
    s = combine(s, team);
    if (team.leader()) part[block] = s;
  }
};

// Combines the parts; one team.
struct CollectHealth {
  const HealthSums* part;
  std::uint32_t parts;
  HealthSums* total;
  real* unsolved;  // null without an implicit solve; set to zero for the next haptic step

  template <class Team>
  PALP_HD void operator()(std::uint32_t, Team team) const {
    HealthSums s;
    for (std::uint32_t b = team.lane(); b < parts; b += team.size()) {
      if (part[b].max_speed > s.max_speed) s.max_speed = part[b].max_speed;
      if (part[b].max_mach > s.max_mach) s.max_mach = part[b].max_mach;
      if (part[b].max_compression > s.max_compression) s.max_compression = part[b].max_compression;
      s.kinetic_energy += part[b].kinetic_energy;
      s.fluid_mass += part[b].fluid_mass;
      s.compressed_mass += part[b].compressed_mass;
      s.non_finite += part[b].non_finite;
      s.outside += part[b].outside;
      s.inactive += part[b].inactive;
      s.asleep += part[b].asleep;
      s.inactive_mass += part[b].inactive_mass;
    }
    s = combine(s, team);
    if (!team.leader()) return;
    if (unsolved != nullptr) {
      s.unsolved = *unsolved;
      *unsolved = real(0);
    }
    *total = s;
  }
};

}  // namespace palp
