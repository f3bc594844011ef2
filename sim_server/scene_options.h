// The command-line options that choose a scene and how it is simulated, the same for every program that runs one.
// Header only: the simulation itself does not need CLI11.
#pragma once

#include <CLI/CLI.hpp>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/error.h"
#include "config/quantity.h"
#include "sim_server/loading_line.h"
#include "sim_server/scene/particle_count.h"
#include "sim_server/scene/scene_files.h"
#include "sim_server/solver/simulation.h"
#include "sim_server/trade/choice.h"

namespace palp {

struct SceneOptions {
  std::string scene;  // a file, or the name of one of palp's own
  SceneOverrides overrides;
  std::optional<std::size_t> particles;  // of the scene's matter (particle_count.h), which decides the spacing
  ChoiceRequest choice;                  // asked: of it follow spacing and numerics
  Backend backend = Backend::automatic;
  std::string
      explain;  // print the scene's bill instead of running it (explain.h): "text", "json" or a file; empty: run
};

inline void add_backend_option(CLI::App& app, Backend& backend) {
  const std::map<std::string, Backend> backends{
      {"auto", Backend::automatic}, {"cpu", Backend::cpu}, {"cuda", Backend::cuda}};
  app.add_option("--backend", backend, "what computes (auto: cuda where there is a GPU for it, else cpu)")
      ->transform(CLI::CheckedTransformer(backends).description(""))
      ->type_name("auto|cpu|cuda")
      ->default_str("auto");
}

inline CLI::Option* add_accuracy_option(CLI::App& app, std::optional<Accuracy>& accuracy) {
  const std::map<std::string, Accuracy> accuracies{{to_string(Accuracy::fast), Accuracy::fast},
                                                   {to_string(Accuracy::balanced), Accuracy::balanced},
                                                   {to_string(Accuracy::accurate), Accuracy::accurate}};
  return app.add_option("--accuracy", accuracy, "accuracy level, instead of the scene's")
      ->transform(CLI::CheckedTransformer(accuracies).description(""))
      ->type_name("fast|balanced|accurate");
}

// Adds an option whose text `parse` turns into the number; what that throws is what CLI11 tells of the option.
inline CLI::Option* add_quantity_option(CLI::App& app, const std::string& name, std::optional<double>& value,
                                        double (*parse)(const std::string&), const std::string& description) {
  return app.add_option_function<std::string>(
      name,
      [&value, parse, name](const std::string& text) {
        try {
          value = parse(text);
        } catch (const ConfigError& error) {
          throw CLI::ValidationError(name, error.what());
        }
      },
      description);
}

// Adds --budget and --error, of which one may be given, and none of `others` with it.
inline void add_choice_options(CLI::App& app, ChoiceRequest& request, const std::vector<CLI::Option*>& others) {
  CLI::Option* budget = add_quantity_option(app, "--budget", request.budget, parse_duration,
                                            "choose spacing and numerics with the least error whose step, on the "
                                            "mean, takes so long on this machine: 500us, 0.5ms");
  CLI::Option* error = add_quantity_option(app, "--error", request.error, parse_share,
                                           "choose the cheapest spacing and numerics whose force is expected to err "
                                           "by no more than this share: 5%, 0.05");
  budget->type_name("TIME")->excludes(error);
  error->type_name("SHARE");
  for (CLI::Option* other : others) {
    budget->excludes(other);
    error->excludes(other);
  }
}

inline void add_set_option(CLI::App& app, SceneOverrides& overrides) {
  app.add_option("--set", overrides.settings,
                 "a value of the scene, instead of the file's, such as numerics.safety=0.4; may be repeated")
      ->type_name("TABLE.KEY=VALUE")
      ->allow_extra_args(false);
}

// Adds the scene itself, --backend, --method, --accuracy, --spacing, --particles, --budget, --error and --set to
// app; they are stored in options, which must outlive the parsing. What is not given stays as the scene file has it.
inline void add_scene_options(CLI::App& app, SceneOptions& options) {
  const std::map<std::string, Method> methods{{to_string(Method::paper), Method::paper},
                                              {to_string(Method::accurate), Method::accurate}};
  app.add_option("scene", options.scene, "scene file, or the name of one in config/scenes")->required();
  add_backend_option(app, options.backend);
  app.add_option("--method", options.overrides.method, "equations of the fluid, instead of the scene's")
      ->transform(CLI::CheckedTransformer(methods).description(""))
      ->type_name("paper|accurate");
  CLI::Option* accuracy = add_accuracy_option(app, options.overrides.accuracy);
  CLI::Option* spacing =
      app.add_option("--spacing", options.overrides.spacing, "particle spacing in metres, instead of the scene's");
  CLI::Option* particles =
      app.add_option(
             "--particles", options.particles,
             "choose the spacing so that fluids, elastic and free rigid bodies (else static ones) have about so many")
          ->check(CLI::Range(1, 100000000))
          ->excludes(spacing);
  add_choice_options(app, options.choice, {accuracy, spacing, particles});
  add_set_option(app, options.overrides);
  app.add_flag("--solid-particles", options.overrides.solid_particles,
               "give rigid and static bodies particles even where nothing needs them");
}

// Adds --explain to app, for programs that run one scene.
inline void add_explain_option(CLI::App& app, SceneOptions& options) {
  app.add_flag("--explain{text}", options.explain,
               "print what the scene is charged for and why, measured for a second, and end; --explain=json prints "
               "JSON, --explain=FILE.json writes it")
      ->check([](const std::string& form) {
        const bool known = form == "text" || form == "json" || (form.size() > 5 && form.ends_with(".json"));
        return known ? ""
                     : "'" + form + "' is no form of a bill; expected --explain, --explain=json or --explain=FILE.json";
      });
}

// Reads and samples the scene; a choice is made and timed first. Throws ConfigError that lists every fault of the
// scene.
inline Scene open_scene(const SceneOptions& options, const LoadingProgress& progress = {}) {
  const std::string file = find_scene_file(options.scene);
  if (options.choice.asked())
    return choose_simulation(file, options.overrides, options.backend, options.choice)->scene();
  return sample_scene(options.particles ? load_scene_with_particles(file, options.overrides, *options.particles)
                                        : load_scene(file, options.overrides),
                      particles_in_memory(), progress);
}

// Opens the scene and sets its simulation up; says on standard error what it does when that takes long. Throws as
// open_scene, or std::runtime_error when the back end cannot serve.
inline std::unique_ptr<Simulation> open_simulation(const SceneOptions& options) {
  if (options.choice.asked())
    return choose_simulation(find_scene_file(options.scene), options.overrides, options.backend, options.choice);
  LoadingLine line;
  const Scene scene = open_scene(options, [&](const char* doing, double share) { line.tell(doing, share); });
  line.tell("setting up the simulation", 0);
  return make_simulation(scene, options.backend);
}

}  // namespace palp
