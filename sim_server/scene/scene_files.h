// Where scenes are found, and how large one may be here.
#pragma once

#include <cstddef>
#include <string>

namespace palp {

// A path that exists is taken as it is. A bare name ("dam_break", with or without .toml) is looked for in
// ./config/scenes and among palp's own scenes. Throws ConfigError that lists the scenes there are.
std::string find_scene_file(const std::string& name);

// What fits into three quarters of the memory that is free now, host arrays of the CPU back end included.
std::size_t particles_in_memory();

}  // namespace palp
