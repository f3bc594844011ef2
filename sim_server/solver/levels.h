// The numbers that an accuracy level expands to where a scene says nothing of its own. Levels are data: levels_test
// compares them with what was measured (config/trade), and fails where another setting costs no more and errs less.
#pragma once

#include "config/scene_config.h"

namespace palp {

struct Level {
  double support_over_spacing;  // H / dx
  double mach;                  // sound speed over the largest expected speed
  double artificial_viscosity;  // alpha
};

inline Level level_of(Accuracy accuracy) {
  switch (accuracy) {
    case Accuracy::fast:
      return {2.0, 7.0, 0.1};
    case Accuracy::balanced:
      return {3.0, 10.0, 0.05};
    case Accuracy::accurate:
      return {3.0, 10.0, 0.02};
  }
  return {3.0, 10.0, 0.05};
}

}  // namespace palp
