// The checks that a sampled scene must pass. Each gives one sentence per fault, beginning with file:line of the body.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim_server/geometry/solid.h"
#include "sim_server/scene/scene.h"
#include "sim_server/threads/thread_team.h"

namespace palp {

// Wraps fluid particles into the domain on periodic axes, then reports particles that are outside.
void check_inside_domain(Scene& scene, std::vector<std::string>& faults);

// Particles inside the solid of another body; one fault for each pair of bodies. `solids`: by body, empty for bodies of
// loose particles.
void check_apart(const Scene& scene, const std::vector<std::optional<Solid>>& solids, ThreadTeam& team,
                 std::vector<std::string>& faults);

// Particles of two bodies, or of one elastic body, nearer than half a spacing, and particles of any other body on top
// of each other. One fault for each pair of bodies.
void check_distances(const Scene& scene, ThreadTeam& team, std::vector<std::string>& faults);

}  // namespace palp
