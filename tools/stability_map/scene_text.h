// The scene of a cell of the stability map, as the file that a user would write.
#pragma once

#include <string>

#include "tools/stability_map/setup.h"

namespace palp::stability {

// The number of haptic steps that the domain leaves room for.
inline constexpr int kMostSteps = 400;

// Writes the scene as FOLDER/NAME.toml, and beside it the particles that it names. Returns the path. Bodies stand in a
// column along z over a tray, if there is one; a tool is on top. Throws std::runtime_error when a file cannot be
// written.
std::string write_scene(const Setup& setup, const std::string& folder, const std::string& name);

}  // namespace palp::stability
