// Particles from a CSV file: a header that names the columns x,y,z[,vx,vy,vz][,temperature][,volume] in any order, then
// one particle a row. SI units. Empty lines and lines that begin with # are skipped.
#pragma once

#include <string>

#include "sim_server/scene/sampling.h"

namespace palp {

// `default_volume` where the file has no volume column. Stops with an error past max_particles. Throws ConfigError with
// one sentence that begins with file:line.
Particles read_particle_csv(const std::string& path, double default_volume, std::size_t max_particles);
Particles parse_particle_csv(std::string_view text, const std::string& path, double default_volume,
                             std::size_t max_particles);

}  // namespace palp
