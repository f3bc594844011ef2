// Particle shifting: deep in a viscous fluid particles move by a little more than their velocity, away from where they
// are crowded, so that they stay evenly spread. Otherwise a lattice of particles that is sheared resists as an elastic
// solid does until it has broken up, and the clumps and voids that a flow makes stay.
//
// symbol   meaning                                                                  unit
// C        sum V_j W, C0 that of a lattice                                          -
// S        -grad C                                                                  1/m
// s        the mean of S over neighbours, by V W: what is smooth in it              1/m
// e        sum V_j F |v_ij.x_ij|, the rate of strain                                1/s
// k, a     Medium::shift, kAside                                                    -
// n_i      a direction of the particle's own, each component from -1 to 1           -
// dx_i     e dt (k H^2 (S_i - s_i) + a dx n_i)                                      m
//
// With s = 0 and a = 0 that is the shift of Lind, Xu, Stansby & Rogers 2012, with strain as its clock, so that what
// rests is not moved. On a lattice S vanishes, however it is sheared; the last part takes particles off it. What is
// smooth in S is no disorder, and would only carry matter from one place to another.
//
// Shifts move matter without a velocity, that is by nobody's work, and so they are left out where that was felt
// (tools/results/felt_remaining.md):
// - near surfaces, where S tells of missing neighbours: they feed waves;
// - in wakes: the drag on a ball at Re 1000 fell by a fifth. A wake is what a solid has had in its reach;
// - where viscosity does not smooth a flow over a spacing: there disorder is what takes its energy away.
// So particles are counted by layers: 0 on a surface, kTouched once a solid has been in reach, elsewhere one more than
// the least of their neighbours' (kTouched counting as 0) and at most kDeep. Those of kDeep are shifted: they are two
// support radii from all that.
#pragma once

#include "sim_server/physics/cell_grid.h"
#include "sim_server/physics/particles.h"

namespace palp {

// The layer of the particles that are shifted, and that of those which a solid has had in its reach.
inline constexpr real kDeep = 3, kTouched = -1;
// The time from one look at the layers to the next [s]: the fastest wave passes a support radius or two meanwhile.
inline constexpr double kLayerInterval = 0.008;
// As many haptic steps at the start have a look each, which is what it takes to count layers up to kDeep.
inline constexpr int kFirstLooks = 4;

// A particle is one of a surface from this |grad C| H on where its C is below that share of C0: with H = 2.7 dx the
// face of a lattice has 1.27 and 0.79, the row beneath 0.08 and 1.00; within a fluid whose particles are displaced by
// up to a quarter of a spacing along each axis none of 7,500 has both.
inline constexpr real kFaceSlope = real(0.9), kFaceCover = real(0.9);
// Below this share of C0 it is a spray, whatever the slope.
inline constexpr real kSprayCover = real(0.6);

// The largest e dx^2 / nu of a particle that is shifted; from half of it on it is shifted less. Vortices of 25 x 25
// particles at Re 100 have 1.3 to 2.
inline constexpr real kSmoothedStrain = real(4);
// The largest k e dt: a shift by more of H^2 grad C would take a particle past where it is even.
inline constexpr real kLargestShift = real(0.1);
// a: how fast a lattice that is sheared loses its order, in spacings for each unit of strain. A vortex of 50 x 50
// particles at Re 100 decays in the first half of a second from a lattice at 1.43 of its rate with 0, at 1.09, 1.06,
// 1.04 and 1.02 with 0.02, 0.05, 0.1 and 0.2 (k = 20, s = 0).
inline constexpr real kAside = real(0.2);

// Returns n_i, by the particle's index in the scene: the same whatever the order of particles.
PALP_HD inline Vec3 own_direction(std::uint32_t id) {
  Vec3 n;
  for (std::uint32_t a = 0; a < 3; ++a) {
    std::uint32_t h = 3 * id + a + 1;  // a hash of few operations and little bias, "lowbias32" by C. Wellons
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    n[a] = static_cast<real>((h ^ h >> 16) >> 8) * real(1.1920929e-7) - real(1);  // 2^-23
  }
  return n;
}

// Returns by how much particle `id` is shifted in a sub-step [m]. sums: S (xyz) [1/m], e (w) [1/s]. smooth: s (xyz)
// [1/m], its layer (w).
PALP_HD inline Vec3 shift_of(const Medium& medium, Tag tag, std::uint32_t id, const Packed& sums,
                             const Packed& smooth) {
  const Material& fluid = medium.material[tag.material()];
  const real smoothed = kSmoothedStrain * fluid.viscosity / (fluid.density * medium.spacing * medium.spacing);
  const real resolved = min(real(1), real(2) * (real(1) - sums.w / smoothed));
  if (smooth.w < kDeep || !(resolved > real(0))) return Vec3(0, 0, 0);
  const real H = medium.kernel.support, strained = resolved * min(sums.w * medium.dt, kLargestShift / medium.shift);
  return strained * (medium.shift * H * H * (sums.xyz() - smooth.xyz()) + kAside * medium.spacing * own_direction(id));
}

// Looks at what is around each particle, and writes its layer and s to `state`. `before`: those of the last look.
struct LookAround {
  ParticleView state, before;
  CellGrid grid;
  Medium medium;
  const Packed* sums;        // as of shift_of()
  const Packed* wall_slope;  // of solids with a distance field (walls.h); null without any

  template <class Team>
  PALP_HD void operator()(std::uint32_t i, Team team) const {
    const Tag tag = state.tag[i];
    if (!tag.is_fluid() || tag.inactive()) return;
    real cover = 0, missing = 0;  // kDeep less the least layer of a neighbour, at most kDeep
    Vec3 mean(0, 0, 0);
    for_neighbors(grid, state.xV, state.xV[i].xyz(), medium.kernel.support, team,
                  [&](std::uint32_t j, const Packed& xV_j, const Vec3&, real r2) PALP_INLINE {
                    const Packed S_j = fetch(sums, j), s_j = fetch(before.smooth, j);
                    const real VW = xV_j.w * medium.kernel.W(Eigen::numext::sqrt(r2));
                    cover += VW;
                    mean += VW * S_j.xyz();
                    const real missing_j = kDeep - positive(s_j.w);
                    if (j != i && missing_j > missing) missing = missing_j;
                  });
    cover = team.sum(cover);
    mean = team.sum(mean);
    missing = team.max(missing);
    if (!team.leader()) return;
    const real wall = wall_slope != nullptr ? wall_slope[i].w : real(0);
    const real edge = medium.kernel.support / kFaceSlope;
    real layer = min(kDeep, kDeep - missing + real(1));
    const real full = (cover + wall) / medium.cover;
    if (full < kSprayCover || (full < kFaceCover && edge * edge * sums[i].xyz().squaredNorm() > real(1))) layer = 0;
    if (wall > real(0) || before.smooth[i].w < real(0)) layer = kTouched;
    const Vec3 s = layer < kDeep ? Vec3(0, 0, 0) : Vec3(mean / cover);
    state.smooth[i] = pack(s, layer);
  }
};

// Copies what a look has found to where the next one reads it.
struct KeepLook {
  ParticleView state, before;

  PALP_HD void operator()(std::uint32_t i) const { before.smooth[i] = state.smooth[i]; }
};

}  // namespace palp
