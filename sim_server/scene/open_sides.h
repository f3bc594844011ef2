// Tells whether the fluids of a scene begin with nothing beside or beneath them: the sides by which a dam breaks.
#pragma once

#include <optional>
#include <vector>

#include "sim_server/geometry/solid.h"
#include "sim_server/scene/scene.h"
#include "sim_server/threads/thread_team.h"

namespace palp {

// Returns whether gravity will make a fluid run off or fall: where two spacings or more of it lie above, there is
// nothing for two spacings to a side or beneath. A lone row does not count: packed particles leave gaps along edges of
// solids. solids: of each body, where it has shapes.
bool runs_off(const Scene& scene, const std::vector<std::optional<Solid>>& solids, ThreadTeam& team);

}  // namespace palp
