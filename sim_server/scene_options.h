// The command-line options that choose a scene and how it is simulated, the same for every program that runs one.
// Header only: the simulation itself does not need CLI11.
#pragma once

#include <CLI/CLI.hpp>

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "sim_server/scene/particle_count.h"
#include "sim_server/scene/scene_files.h"
#include "sim_server/solver/simulation.h"

namespace palp {

struct SceneOptions {
  std::string scene;  // a file, or the name of one of palp's own
  SceneOverrides overrides;
  std::optional<std::size_t> particles;  // of the scene's matter (particle_count.h), which decides the spacing
  Backend backend = Backend::automatic;
};

inline void add_backend_option(CLI::App& app, Backend& backend) {
  const std::map<std::string, Backend> backends{
      {"auto", Backend::automatic}, {"cpu", Backend::cpu}, {"cuda", Backend::cuda}};
  app.add_option("--backend", backend, "what computes (auto: cuda where there is a GPU for it, else cpu)")
      ->transform(CLI::CheckedTransformer(backends).description(""))
      ->type_name("auto|cpu|cuda")
      ->default_str("auto");
}

inline void add_accuracy_option(CLI::App& app, std::optional<Accuracy>& accuracy) {
  const std::map<std::string, Accuracy> accuracies{{to_string(Accuracy::fast), Accuracy::fast},
                                                   {to_string(Accuracy::balanced), Accuracy::balanced},
                                                   {to_string(Accuracy::accurate), Accuracy::accurate}};
  app.add_option("--accuracy", accuracy, "accuracy level, instead of the scene's")
      ->transform(CLI::CheckedTransformer(accuracies).description(""))
      ->type_name("fast|balanced|accurate");
}

// Adds the scene itself, --backend, --method, --accuracy, --spacing and --particles to app; they are stored in options,
// which must outlive the parsing. What is not given stays as the scene file has it.
inline void add_scene_options(CLI::App& app, SceneOptions& options) {
  const std::map<std::string, Method> methods{{to_string(Method::paper), Method::paper},
                                              {to_string(Method::accurate), Method::accurate}};
  app.add_option("scene", options.scene, "scene file, or the name of one in config/scenes")->required();
  add_backend_option(app, options.backend);
  app.add_option("--method", options.overrides.method, "equations of the fluid, instead of the scene's")
      ->transform(CLI::CheckedTransformer(methods).description(""))
      ->type_name("paper|accurate");
  add_accuracy_option(app, options.overrides.accuracy);
  CLI::Option* spacing =
      app.add_option("--spacing", options.overrides.spacing, "particle spacing in metres, instead of the scene's");
  app.add_option(
         "--particles", options.particles,
         "choose the spacing so that fluids, elastic and free rigid bodies (else static ones) have about so many")
      ->check(CLI::Range(1, 100000000))
      ->excludes(spacing);
}

// Reads and samples the scene. Throws ConfigError that lists every fault of the scene.
inline Scene open_scene(const SceneOptions& options) {
  const std::string file = find_scene_file(options.scene);
  return sample_scene(options.particles ? load_scene_with_particles(file, options.overrides, *options.particles)
                                        : load_scene(file, options.overrides),
                      particles_in_memory());
}

// Opens the scene and sets its simulation up. Throws as open_scene, or std::runtime_error when the back end cannot
// serve.
inline std::unique_ptr<Simulation> open_simulation(const SceneOptions& options) {
  return make_simulation(open_scene(options), options.backend);
}

}  // namespace palp
