// Where scenes are found, and how large one may be here.
#pragma once

#include <cstddef>
#include <string>

namespace palp {

// Returns the file of a scene given by path or by bare name ("dam_break"), as find_data_file (config/data_dir.h) looks
// for it.
std::string find_scene_file(const std::string& name);

// Returns how many particles fit into three quarters of the memory that is free now, host arrays of the CPU back end
// included.
std::size_t particles_in_memory();

}  // namespace palp
