// The room that the fluids of a scene can get to.
#pragma once

#include <vector>

#include "sim_server/solver/plan.h"

namespace palp {

// Returns true for a body whose matter flows, all the time or at times.
inline bool flows(const Scene& scene, const Plan& plan, std::size_t body) {
  return scene.bodies[body].type == BodyKind::fluid || plan.changes[body];
}

// Returns true for a body that acts on fluids by its particles.
inline bool is_wall_of_particles(const Scene& scene, const Plan& plan, std::size_t body) {
  const Body& b = scene.bodies[body];
  return plan.fluid && b.count > 0 && !flows(scene, plan, body) && !(plan.geometry && b.contact != nullptr);
}

// Returns the middles of the cells, a spacing wide, that fluid can get to at the start's places of the static bodies
// while it stays within the bounds of these and of its own start. None where that would be too many cells to look at.
std::vector<Eigen::Vector3d> fluid_room(const Scene& scene, const Plan& plan);

}  // namespace palp
