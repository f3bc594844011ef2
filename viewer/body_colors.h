// Colours for bodies to which the scene gives none.
#pragma once

#include <memory>

#include "idl/messages.h"

namespace palp {

// Returns the scene itself if all of its bodies have colours, else a copy in which those without one can be told apart:
// every material without a colour has the same one on the bus.
std::shared_ptr<const SceneDescription> with_distinct_colors(std::shared_ptr<const SceneDescription> scene);

}  // namespace palp
