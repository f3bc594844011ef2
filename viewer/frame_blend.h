// Interpolates between two recorded states of a scene.
#pragma once

#include "idl/particle_frame.h"

namespace palp {

// Returns the frame at `sim_time` [s], which lies between those of a and b, two frames of the same particles: positions
// and scalars straight between theirs. A particle that has come further than any moves, or whose place is not finite,
// stays where a has it, as do the scalars where the two hold different fields.
ParticleFrame between(const ParticleFrame& a, const ParticleFrame& b, double sim_time);

// Returns the poses at `sim_time` [s]: straight between those of a and b, and turning evenly. Bodies of which b knows
// no pose stay where a has them.
BodyPoses between(const BodyPoses& a, const BodyPoses& b, double sim_time);

}  // namespace palp
