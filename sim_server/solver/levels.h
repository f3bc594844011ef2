// The numbers that an accuracy level expands to where a scene says nothing of its own. Levels are data: levels_test
// compares them with what was measured (config/trade), and fails where another setting costs no more and errs less.
#pragma once

#include "config/scene_config.h"

namespace palp {

// With H = 2.7 dx, where the quartic spline keeps a lattice together that a hand does not feel (smoothing.h), drag,
// waves and vortices are what they are with 3 dx and the quintic one, at 0.73 of the pairs
// (tools/results/felt_remaining.md). Alpha acts as a viscosity of alpha c H / 20: with 0.02 forty times an oil's. With
// H = 2.7 dx the force of tray_fluid errs without it by 32, 24, 18 and 14 % at 30, 25, 20 and 16 mm, with 0.02 by 37,
// 30, 25 and 19 % (two CPU cores, tools/results/trade.md); a towed ball has its drag and a wave its energy. With H = 2
// dx the lattice of particles resists, whatever alpha, and 0.02 errs less than 0.1. Walls of particles feed sound
// without it: a vessel of them never came to rest. Where fluids meet or change state, more is needed: with 0.02 a gas
// beneath water was thrown faster than it could have fallen, and a rod that froze in a hand jumped by 3.4 %. A fluid
// that coheres has the same alpha c at all levels: the front of Martin & Moyce's column is then 6.7 to 6.8 % ahead of
// theirs at most, and 4.5 behind (fast with 0.02 7.5 % ahead; with the alpha of fluids that meet 10 % behind at fast, 8
// at balanced).
struct Level {
  double support_over_spacing;  // H / dx
  double mach;                  // sound speed over the largest expected speed
  double artificial_viscosity;  // alpha of a fluid by itself, among solids that act by their geometry
  double wall_viscosity;        // alpha of one beside elastic bodies or loose particles
  double cohesive_viscosity;    // alpha of one with surface tension or adhesion
  double rough_viscosity;       // alpha where fluids meet, freeze or melt
};

// k of particle shifting (physics/shift.h) in fluids that are deep and viscous enough and have a spline for a kernel.
// With 0, 4 and 10 the vortices of tools/taylor_green.py --decay, 50 across, decay from a lattice at 4.09, 1.09
// and 1.04 of their rate in the first half of a second and at 1.79, 1.07 and 1.04 in the second. With Wendland's kernel
// of 2 dx, whose lattice resists most, particles do not stay even under it: displaced ones made a vortex decay at 1.49
// of its rate in the second half of a second, in place of 1.10.
inline constexpr double kShift = 10;

inline Level level_of(Accuracy accuracy) {
  switch (accuracy) {
    case Accuracy::fast:
      return {2.0, 7.0, 0.02, 0.02, 0.03, 0.1};
    case Accuracy::balanced:
      return {2.7, 10.0, 0, 0.02, 0.02, 0.05};
    case Accuracy::accurate:
      return {2.7, 10.0, 0, 0.02, 0.02, 0.02};
  }
  return {2.7, 10.0, 0, 0.02, 0.02, 0.05};
}

}  // namespace palp
