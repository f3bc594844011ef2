// The numbers that an accuracy level expands to where a scene says nothing of its own. Levels are data: levels_test
// compares them with what was measured (config/trade), and fails where another setting costs no more and errs less.
#pragma once

#include "config/scene_config.h"

namespace palp {

// Alpha acts as a viscosity of alpha c H / 20: with 0.02 forty times an oil's. With H = 3 dx the force of tray_fluid
// errs without it by 51, 31, 17, 14 and 12 % at 40, 30, 20, 16 and 12.8 mm, with 0.02 by 53, 35, 21, 17 and 13 %
// (H100, tools/results/trade.md); a towed ball has its drag and a wave its energy. With H = 2 dx the lattice of
// particles resists, whatever alpha, and 0.02 errs less than 0.1. Walls of particles feed sound without it: a vessel of
// them never came to rest. Where fluids meet or change state, more is needed: with 0.02 a gas beneath water was thrown
// faster than it could have fallen, and a rod that froze in a hand jumped by 3.4 %.
struct Level {
  double support_over_spacing;  // H / dx
  double mach;                  // sound speed over the largest expected speed
  double artificial_viscosity;  // alpha of a fluid by itself, among solids that act by their geometry
  double wall_viscosity;        // alpha of one beside elastic bodies or loose particles
  double rough_viscosity;       // alpha where fluids meet, cohere, freeze or melt
};

inline Level level_of(Accuracy accuracy) {
  switch (accuracy) {
    case Accuracy::fast:
      return {2.0, 7.0, 0.02, 0.02, 0.1};
    case Accuracy::balanced:
      return {3.0, 10.0, 0, 0.02, 0.05};
    case Accuracy::accurate:
      return {3.0, 10.0, 0, 0.02, 0.02};
  }
  return {3.0, 10.0, 0, 0.02, 0.05};
}

}  // namespace palp
