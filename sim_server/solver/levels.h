// The numbers that an accuracy level expands to where a scene says nothing of its own. Levels are data: levels_test
// compares them with what was measured (config/trade), and fails where another setting costs no more and errs less.
#pragma once

#include "config/scene_config.h"

namespace palp {

// Alpha, measured on two CPU cores with tray_fluid along its stirring path at 40, 35, 30, 25, 20 and 16 mm, at one
// cost: the force erred by 79, 55, 49, 46, 40 and 39 % with 0.02 at H = 3 dx, and by 94, 71, 70, 68, 59 and 58 % with
// 0.05; at H = 2 dx by 103, 64, 61, 63, 58 and 50 % with 0.02, and by 148, 104, 113, 110, 98 and 93 % with 0.1
// (tools/results/trade.md). It acts as a viscosity of alpha c H / 20, a hundred times an oil's with 0.05. But with 0.02
// a gas beneath water was thrown faster than it could have fallen, and a rod that froze in a hand jumped by 3.4 %.
struct Level {
  double support_over_spacing;  // H / dx
  double mach;                  // sound speed over the largest expected speed
  double artificial_viscosity;  // alpha of a fluid by itself
  double rough_viscosity;       // alpha where fluids meet, cohere, freeze or melt
};

inline Level level_of(Accuracy accuracy) {
  switch (accuracy) {
    case Accuracy::fast:
      return {2.0, 7.0, 0.02, 0.1};
    case Accuracy::balanced:
      return {3.0, 10.0, 0.02, 0.05};
    case Accuracy::accurate:
      return {3.0, 10.0, 0.02, 0.02};
  }
  return {3.0, 10.0, 0.02, 0.05};
}

}  // namespace palp
