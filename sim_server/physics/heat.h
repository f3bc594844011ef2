// Heat: conduction within and between media, latent heat by enthalpy, sources, loss to air. It runs more slowly than
// the rest (plan.h) and between two of its steps nothing warms.
//
// symbol   meaning                                                                     unit     source
// h        specific enthalpy, the state; 0: solid at its melting temperature           J/kg     Voller 1985
// T(h)     T_m + h/c below 0; T_m to the latent heat L; T_m + (h - L)/c above          K
// f(h)     liquid fraction, h/L in 0..1                                                -
// k, c     conductivity; heat capacity                                                 W/(m K), J/(kg K)
// V        volume, at most m / rest density: a sheet by method "paper", whose density
//          is that of its few neighbours, would conduct ten times as well             m^3
// m dh/dt  sum_j V_i V_j 4 k_i k_j / (k_i + k_j) F (T_j - T_i) / M + sources           W        Cleary & Monaghan 1999
// M        sum_j V_j F x_j^2 within a lattice; 1 in the limit of many neighbours       -        below
// wall     V_i 2 k_i shear (T_w - T_i) / M, of a solid that acts by its geometry       W        heat_walls.h
// A        free surface: V (1 - S/S0 - e) / l, S = sum_j V_j W                         m^2      below
//
// Every pair conducts, those within a solid too. Heat that i gets j loses, so heat is kept to round-off. A body that is
// held at its temperature is a perfect conductor: the limit of large k_j, so that its temperature holds at its surface.
// M makes the flux through a lattice exact: with H = 2 dx it is 0.982. A material that does not melt has L = 0, and T_m
// then is only where its h is zero.
//
// The free surface is told by how little of a particle's neighbourhood is filled, by particles or by solids. S0 is S
// within a lattice, and l makes a plane surface of one come out exactly; a cube of 14 particles an edge comes out
// within 5 %. |sum V gradW|, the usual measure, is not used: in disordered particles its noise has a sign and amounts
// to several times the surface, while that of S cancels but for what passes the threshold e.
#pragma once

#include "sim_server/physics/rigid.h"

namespace palp {

struct HeatMaterial {
  real conductivity;  // k
  real capacity;      // c
  real melting;       // T_m
  real latent;        // L; 0: does not melt
  real density;       // at rest [kg/m^3]
};

// Returns T(h).
PALP_HD inline real temperature_of(const HeatMaterial& m, real h) {
  const real sensible = h < real(0) ? h : (h > m.latent ? h - m.latent : real(0));
  return m.melting + sensible / m.capacity;
}

// Returns the enthalpy at a temperature; at the melting temperature itself that of the solid.
PALP_HD inline real enthalpy_of(const HeatMaterial& m, real T) {
  const real h = m.capacity * (T - m.melting);
  return h > real(0) ? h + m.latent : h;
}

// Returns f(h), 0 solid to 1 liquid, of a material that melts; for one without latent heat it has no meaning and is 0.
PALP_HD inline real liquid_fraction(const HeatMaterial& m, real h) {
  if (!(m.latent > real(0)) || h <= real(0)) return real(0);
  return h < m.latent ? h / m.latent : real(1);
}

inline constexpr std::uint32_t kMaxHeatZones = 32;  // bits of HeatViews::zones_on

// A box in which particles are heated, or held at a temperature.
struct HeatZone {
  Vec3 center, half;   // centre and half size, from the centre of mass of the body that it follows and along that one's
                       // axes; without a body in the world [m]
  Quat q;              // rotation from the box's axes to the axes of the body or the world
  std::uint32_t body;  // the body that it follows, kNone
  bool holds;          // true: it holds a temperature; false: it heats
  real temperature;    // [K]
  real power;          // [W], shared among the particles in it by volume
};

struct HeatMedium {
  HeatMaterial material[kMaxMaterials];
  real dt;               // heat step [s]
  real loss;             // loss to air [W/(m^2 K)]
  real air_temperature;  // [K]
  real moment;           // M
  real cover;            // S0
  real depth;            // l [m]
};

// e, the share of the neighbourhood that may be missing without being a surface: the noise of S in a fluid.
inline constexpr real kCoverNoise = real(0.05);

// The part that a body has in heat. The last two have a distance field, and what particles they have take no part.
enum class HeatRole : std::uint32_t {
  conducts,   // its particles exchange heat
  held,       // its particles keep their temperatures
  held_wall,  // it keeps its temperature, and heat flows to its surface
  insulator   // no heat flows to it
};

// The solids that act by their geometry, as a particle feels them.
struct HeatWall {
  real shear;        // WallShare::shear of those that hold their temperatures [1/m^2]
  real temperature;  // of these, weighted by their shear [K]
  real share;        // WallShare::share of all of them
};
PALP_HD inline HeatWall no_heat_wall() { return {0, 0, 0}; }

struct HeatViews {
  const HeatRole* role = nullptr;  // by body
  HeatWall* wall = nullptr;        // by particle; null without solids that act by their geometry
  const HeatZone* zone = nullptr;
  real* zone_volume = nullptr;  // by zone: volume of the particles in it that can take up heat [m^3]
  std::uint32_t zones = 0;
  const std::uint32_t* zones_on = nullptr;  // one bit a zone: 1 where it is on
};

// Returns true when x is in the zone.
PALP_HD inline bool is_inside(const HeatZone& zone, const BodyState* bodies, const CellGrid& grid, const Packed& x) {
  Vec3 center = zone.center;
  if (zone.body != kNone) center = bodies[zone.body].x + bodies[zone.body].q * zone.center;
  Vec3 d = separation(grid, grid.wrap_fully(center), x);
  if (zone.body != kNone) d = bodies[zone.body].q.conjugate() * d;
  d = zone.q.conjugate() * d;
  for (int a = 0; a < 3; ++a)
    if (!(Eigen::numext::abs(d[a]) <= zone.half[a])) return false;
  return true;
}

// Measures the volume of the particles in each zone; one team a zone.
struct MeasureHeatZones {
  ParticleView state;
  CellGrid grid;
  const BodyState* bodies;
  HeatViews heat;
  std::uint32_t count;

  template <class Team>
  PALP_HD void operator()(std::uint32_t z, Team team) const {
    const HeatZone zone = heat.zone[z];
    real volume = 0;
    for (std::uint32_t i = team.lane(); i < count; i += team.size())
      if (heat.role[state.tag[i].body()] == HeatRole::conducts && !state.tag[i].inactive() &&
          is_inside(zone, bodies, grid, state.xV[i]))
        volume += state.xV[i].w;
    volume = team.sum(volume);
    if (team.leader()) heat.zone_volume[z] = volume;
  }
};

// Advances the enthalpy by one heat step. It reads temperatures and writes enthalpies, so the order does not matter.
struct ConductHeat {
  ParticleView state;
  CellGrid grid;
  FluidKernel kernel;
  HeatMedium medium;
  const BodyState* bodies;
  HeatViews heat;

  // Returns V of particle j, whose place and volume are xV_j [m^3].
  PALP_HD real volume(std::uint32_t j, Tag tag_j, const Packed& xV_j) const {
    const real at_rest = state.mass[j] / medium.material[tag_j.material()].density;
    return xV_j.w < at_rest ? xV_j.w : at_rest;
  }

  // Returns the power that the zones give to particle i [W]; a zone that holds a temperature sets its enthalpy h.
  PALP_HD real zone_power(std::uint32_t i, const HeatMaterial& material, real& h) const {
    real power = 0;
    for (std::uint32_t z = 0; z < heat.zones; ++z) {
      if ((*heat.zones_on >> z & 1u) == 0 || !is_inside(heat.zone[z], bodies, grid, state.xV[i])) continue;
      if (heat.zone[z].holds)
        h = enthalpy_of(material, heat.zone[z].temperature);
      else
        power += heat.zone[z].power * state.xV[i].w / heat.zone_volume[z];
    }
    return power;
  }

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag_i = state.tag[i];
    if (heat.role[tag_i.body()] != HeatRole::conducts || tag_i.inactive()) return;
    const HeatMaterial material_i = medium.material[tag_i.material()];
    const real T_i = state.temperature[i], k_i = material_i.conductivity;
    const Packed xV_i = state.xV[i];
    const real V_i = volume(i, tag_i, xV_i);
    real flux = 0, cover = 0;
    for_neighbors(grid, state.xV, xV_i.xyz(), kernel.support, team,
                  [&](std::uint32_t j, const Packed& xV_j, const Vec3&, real r2) {
                    const Tag tag_j = state.tag[j];
                    const HeatRole role = heat.role[tag_j.body()];
                    if (role > HeatRole::held) return;
                    const real V_j = volume(j, tag_j, xV_j), r = Eigen::numext::sqrt(r2);
                    const real k_j = medium.material[tag_j.material()].conductivity, sum = k_i + k_j;
                    const real k =
                        role == HeatRole::held ? real(4) * k_i : (sum > real(0) ? real(4) * k_i * k_j / sum : real(0));
                    flux += V_j * kernel.F(r) * k * (state.temperature[j] - T_i);
                    cover += V_j * kernel.W(r);
                  });
    flux = team.sum(flux);
    cover = team.sum(cover);
    if (!team.leader()) return;
    if (heat.wall != nullptr) {
      const HeatWall wall = heat.wall[i];
      flux += real(2) * k_i * wall.shear * (wall.temperature - T_i);
      cover += wall.share;
    }
    real h = state.enthalpy[i], power = V_i * flux / medium.moment;
    const real missing = real(1) - cover / medium.cover - kCoverNoise;
    if (missing > real(0)) power += medium.loss * (V_i * missing / medium.depth) * (medium.air_temperature - T_i);
    power += zone_power(i, material_i, h);
    state.enthalpy[i] = h + medium.dt * power / state.mass[i];
  }
};

// Computes temperatures from enthalpies.
struct UpdateTemperature {
  ParticleView state;
  HeatMedium medium;
  HeatViews heat;

  PALP_HD void operator()(std::uint32_t i) const {
    const Tag tag = state.tag[i];
    if (heat.role[tag.body()] == HeatRole::conducts)
      state.temperature[i] = temperature_of(medium.material[tag.material()], state.enthalpy[i]);
  }
};

}  // namespace palp
