// The look at what is around particles, by which those are found that are shifted (physics/shift.h). B is a back end.
#pragma once

#include "sim_server/physics/shift.h"
#include "sim_server/solver/step_views.h"

namespace palp {

// Finds which particles are to be shifted, and what of the slopes around them is no disorder. Positions are those at
// the end of a haptic step, sums and neighbours those of its last sub-step.
template <class B>
void look_stages(B& back_end, const StepViews& v) {
  back_end.for_each_team("look around", v.particles,
                         LookAround{v.state, v.sorted, v.grid, v.medium, v.fluid.shift_sums, v.fluid.walls.slope});
  back_end.for_each("look around", v.particles, KeepLook{v.state, v.sorted});
}

}  // namespace palp
