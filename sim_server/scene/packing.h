// Fitting fluids to what stands in them. A fluid's lattice that is cut by a curved wall, or meets another lattice, has
// gaps and crowded places there, which would fall in and push from the first step on.
#pragma once

#include <optional>
#include <vector>

#include "sim_server/geometry/solid.h"
#include "sim_server/scene/scene.h"
#include "sim_server/threads/thread_team.h"

namespace palp {

// Moves fluid particles near solids and other bodies until they are as even as the simulation itself counts: sum V
// gradW by the fluids' kernel, with the shares of solids that act by their geometry (physics/wall_share.h) and the
// particles of all others, vanishes (the particle packing of Zhu, Zhang & Hu 2021). Free surfaces stay where they are.
// Their volumes become a partition of space (V = V0 / sum V W). Where all is even already, as beside walls on their
// lattice, particles keep place and volume to the bit, and so do solids and loose particles from files. The same bits
// whatever the number of threads.
// `solids`: by body, empty for bodies of loose particles.
void pack_fluids(Scene& scene, const std::vector<std::optional<Solid>>& solids, ThreadTeam& team,
                 const LoadingProgress& progress = {});

}  // namespace palp
