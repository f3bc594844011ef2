// Walls that are thick enough for particles, where solids act by theirs.
#pragma once

#include <vector>

#include "config/scene_config.h"

namespace palp {

// Returns the shapes with walls at least `least` [m] thick around what is cut away: boxes and cylinders that are added
// grow outwards there. What is cut away stays as it is, and open where it is open. Walls between shapes that do not
// stand along the same axes stay as they are.
std::vector<ShapeConfig> with_thick_walls(std::vector<ShapeConfig> shapes, double least);

}  // namespace palp
