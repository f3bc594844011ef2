// A scene with as many particles as wanted: the spacing that its matter needs for that.
#pragma once

#include <cstddef>
#include <string>

#include "sim_server/scene/scene.h"

namespace palp {

// The matter of a scene is what its fluids, elastic bodies and free rigid bodies are made of; in a scene that has none
// of these, its static bodies. Tools do not count, nor do the static bodies that hold the rest.
// Particles of a sampled scene's matter.
std::size_t matter_particles(const Scene& scene);

// The spacing [m] at which the matter of config has about `wanted` particles, at least 1: the closest number among
// lattices up to 8 % finer or coarser than its volume says, so that a cuboid of 1,000 has it within a tenth, one of
// 10,000 within a twentieth. Throws ConfigError where the matter's particles are read from a file, or a mesh is faulty.
double matter_spacing(const SceneConfig& config, std::size_t wanted);

// Reads a scene at the spacing that gives its matter about `wanted` particles; overrides.spacing must be unset. Throws
// ConfigError.
SceneConfig load_scene_with_particles(const std::string& path, SceneOverrides overrides, std::size_t wanted);

// One sentence: what was wanted and chosen.
std::string particle_choice(const Scene& scene, std::size_t wanted);

}  // namespace palp
