// How the particles of a body are drawn.
#pragma once

#include "idl/messages.h"

namespace palp {

// beads: spheres. opaque, clear: one smooth surface, lit or looked through.
enum class Medium { beads, opaque, clear };

inline constexpr std::size_t kMediums = 3;

// Returns how the particles of a body usually look. Soft solids are opaque. Liquids are clear unless the body's name
// says otherwise ("batter", "pancake dough"); what is neither is drawn as beads.
Medium usual_medium(const BodyDescription& body);

}  // namespace palp
