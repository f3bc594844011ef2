// The scenes of config/scenes, as a user runs them with accuracy "fast" unless a test says otherwise.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "sim_server/solver/simulation.h"

namespace palp::test {

// A file of the source tree, or of the one that PALP_SOURCE_DIR names where the tests run elsewhere than they were
// built.
inline std::string source_file(const std::string& name) {
  const char* folder = std::getenv("PALP_SOURCE_DIR");
  return std::string(folder != nullptr ? folder : PALP_SOURCE_DIR) + "/" + name;
}

// solid_particles: true gives solids particles even where nothing needs them, for tests that look at these.
inline Scene scene_file(const std::string& name, Accuracy accuracy = Accuracy::fast, bool solid_particles = false) {
  SceneOverrides overrides;
  overrides.accuracy = accuracy;
  overrides.solid_particles = solid_particles;
  return sample_scene(load_scene(source_file("config/scenes/" + name + ".toml"), overrides), 1000000);
}

inline const Body& body_named(const Scene& scene, const std::string& name) {
  return *std::find_if(scene.bodies.begin(), scene.bodies.end(), [&](const Body& b) { return b.name == name; });
}

inline void run_until(Simulation& simulation, double time) {
  while (simulation.output().time < time - 1e-9) {
    const Health& health = simulation.step({}).health;
    ASSERT_TRUE(health.ok) << health.cause;
  }
}

}  // namespace palp::test
