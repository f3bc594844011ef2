// The kind of a scene: the medium that the hand feels in it, and how large the tool is that feels it.
#pragma once

#include <string>

#include "config/scene_config.h"

namespace palp {

// Returns the medium by which tables of the trade group scenes: "changing" where anything has a temperature, else
// "mixed" with fluids and elastic bodies, "fluid", "elastic", or "rigid" with neither. tools/tradeoff has the same
// rule.
std::string medium_of(const SceneConfig& config);

// Returns the length that particles must resolve [m]: of the smallest tool, 6 V / A of its largest shape, which is the
// diameter of a ball. Where the scene has no tool, of its largest body that is not fixed, or else of its largest body.
// matter: as if there were no tool. Throws ConfigError when a mesh is faulty.
double resolved_length(const SceneConfig& config, bool matter = false);

}  // namespace palp
