// Fitting fluids to the solids in them. A solid's particles lie on a lattice of its own, so that the fluid's lattice
// around it has gaps and crowded places, which would fall in and push from the first step on.
#pragma once

#include <optional>
#include <vector>

#include "sim_server/geometry/solid.h"
#include "sim_server/scene/scene.h"
#include "sim_server/threads/thread_team.h"

namespace palp {

// Moves fluid particles that lie off the lattice of the bodies next to them until all fill the space evenly (the sum
// of V gradW vanishes, as in the particle packing of Zhu, Zhang & Hu 2021), free surfaces staying where they are, and
// makes their volumes a partition of it (V = V0 / sum V W). Particles that lie on one lattice with their surroundings
// keep place and volume to the bit, as do solids and loose particles from files.
// `solids`: by body, empty for bodies of loose particles. The same bits whatever the number of threads.
void pack_fluids(Scene& scene, const std::vector<std::optional<Solid>>& solids, ThreadTeam& team,
                 const LoadingProgress& progress = {});

}  // namespace palp
