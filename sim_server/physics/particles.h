// The particles as the kernels see them: raw pointers, null where the plan has no such array.
//
// symbol      meaning                                                     unit
// x, V        position; current volume m / rho (solids: rest volume)      m, m^3
// v, p        velocity; pressure (the fluid's state: rho = rho0 + p/c^2)  m/s, Pa
// m           mass                                                        kg
// T           temperature                                                 K
// h           specific enthalpy                                           J/kg
// K, piece    solid fraction and piece (pieces.h) of matter that changes state  -
#pragma once

#include "idl/vocabulary.h"
#include "sim_server/physics/real.h"
#include "sim_server/physics/smoothing.h"

namespace palp {

// A particle's kind, material and body in one word, and three bits: it has left the domain (outside.h), it sleeps
// (sleep.h), its body keeps fluids out by its distance field (walls.h).
struct Tag {
  std::uint32_t bits;
  PALP_HD BodyKind kind() const { return static_cast<BodyKind>(bits & 3u); }
  PALP_HD bool is_fluid() const { return (bits & 3u) == 0; }
  PALP_HD std::uint32_t material() const { return (bits >> 2) & 0xfu; }
  PALP_HD std::uint32_t body() const { return (bits >> 8) & 0x7fffffu; }
  PALP_HD bool inactive() const { return (bits & 0x80u) != 0; }
  PALP_HD Tag as_inactive() const { return {bits | 0x80u}; }
  PALP_HD bool asleep() const { return (bits & 0x40u) != 0; }
  PALP_HD bool by_geometry() const { return (bits & 0x80000000u) != 0; }
  PALP_HD Tag with_geometry(bool on) const { return {on ? bits | 0x80000000u : bits & ~0x80000000u}; }
  PALP_HD Tag as_asleep(bool sleeps) const { return {sleeps ? bits | 0x40u : bits & ~0x40u}; }
};
inline constexpr std::uint32_t kMaxMaterials = 16;

inline Tag make_tag(BodyKind kind, std::uint32_t material, std::uint32_t body) {
  return {static_cast<std::uint32_t>(kind) | material << 2 | body << 8};
}

inline constexpr std::uint32_t kNone = 0xffffffffu;
// For what is the difference of two indices, which wraps around: of no two of less than 2^31 things, where kNone is -1.
inline constexpr std::uint32_t kNoDifference = 0x80000000u;

struct alignas(8) Solidity {
  real K;
  std::uint32_t piece;  // kNone: it is liquid, or its piece is not known yet
};

// One set of per-particle arrays, sorted by cell. There are two: the state, and the copy that sorting writes.
struct ParticleView {
  Packed* xV = nullptr;
  Packed* vp = nullptr;
  real* mass = nullptr;
  Tag* tag = nullptr;
  std::uint32_t* id = nullptr;  // index in the scene's order
  real* temperature = nullptr;
  real* enthalpy = nullptr;
  Solidity* solid = nullptr;
  Packed* smooth = nullptr;  // s [1/m], layer (w) of shift.h
};

// Copies those members of a particle that a step changes.
PALP_HD inline void copy_changing(const ParticleView& from, std::uint32_t i, const ParticleView& to, std::uint32_t j) {
  to.xV[j] = from.xV[i];
  to.vp[j] = from.vp[i];
  if (to.temperature != nullptr) to.temperature[j] = from.temperature[i];
  if (to.enthalpy != nullptr) to.enthalpy[j] = from.enthalpy[i];
  if (to.solid != nullptr) to.solid[j] = from.solid[i];
}

// Copies the others.
PALP_HD inline void copy_lasting(const ParticleView& from, std::uint32_t i, const ParticleView& to, std::uint32_t j) {
  to.mass[j] = from.mass[i];
  to.tag[j] = from.tag[i];
  to.id[j] = from.id[i];
  if (to.smooth != nullptr) to.smooth[j] = from.smooth[i];
}

PALP_HD inline void copy_particle(const ParticleView& from, std::uint32_t i, const ParticleView& to, std::uint32_t j) {
  copy_changing(from, i, to, j);
  copy_lasting(from, i, to, j);
}

struct Material {
  real density;      // rho0 [kg/m^3]
  real sound_speed;  // c of a fluid; a light one beside heavy ones has more than the scene's [m/s]
  real viscosity;    // mu [Pa s]
  real shear, lame;  // of elastic bodies: mu, lambda [Pa]
  real damping;      // eta, of elastic bodies [Pa s]
  real yield;        // s_y, of elastic bodies [Pa]; 0: it does not yield
  real hardening;    // hardening modulus H [Pa]
  real tear;         // strain at which bonds of elastic bodies break; 0: never
  real hourglass;    // beta E, of elastic bodies [Pa]
};

// The constants of a sub-step, which every kernel gets.
struct Medium {
  Material material[kMaxMaterials];
  FluidKernel kernel;
  real spacing;      // dx [m]
  real sound_speed;  // c of the scene [m/s]
  real diffusion;    // delta of the density diffusion [-]
  real cover;        // C0, sum V W of a lattice [-]
  real artificial;   // alpha of the artificial viscosity [-]
  real shift;        // k of particle shifting [-]
  bool uniform;      // one fluid and nothing else: every particle has the same tag but for its body
  bool tension;      // true: fluid pressure may be negative
  real dt;           // sub-step [s]
};

// Returns the pressure that the forces use: clamped at zero unless the scene allows tension.
template <class S>
PALP_HD inline S acting_pressure(const Medium& medium, const S& p) {
  return medium.tension ? p : positive(p);
}

// The forcing of one haptic step. Kernels read it through a pointer, so that a captured graph sees new values.
struct Forcing {
  Vec3 gravity;          // [m/s^2], balanced by pressure
  Vec3 level_gravity;    // gravity without its components along periodic axes, which no pressure can balance
  Vec3 body_force;       // [m/s^2]
  bool changed = false;  // gravity has changed since what sleeps was last judged
};

}  // namespace palp
