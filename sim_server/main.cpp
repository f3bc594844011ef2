// sim_server: simulates a scene and serves it over DDS.
// Exit status: 0 done, 1 the run failed, 2 bad input, 3 the simulation turned unhealthy.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "config/command_line.h"
#include "config/data_dir.h"
#include "config/json_file.h"
#include "config/number_between.h"
#include "config/stop_signal.h"
#include "idl/bus_options.h"
#include "sim_server/explain.h"
#include "sim_server/scene_options.h"
#include "sim_server/server.h"

namespace {

struct Arguments {
  palp::SceneOptions scene;
  palp::BusOptions bus;
  palp::ServerOptions server;
  std::string summary;
};

void declare(CLI::App& app, Arguments& a) {
  palp::add_scene_options(app, a.scene);
  palp::add_explain_option(app, a.scene);
  app.add_option("--seconds", a.server.seconds, "stop after this wall time; 0: never")
      ->check(palp::number_between(0.0, 1e9));
  app.add_flag("--paused", a.server.start_paused, "wait for a resume command");
  app.add_option("--summary", a.summary, "write a summary (JSON) of the last scene to this file at the end");
  palp::add_bus_options(app, a.bus);
}

namespace fs = std::filesystem;

// Returns the file of a scene in the first of these folders that has one; empty where none has. Other files that end
// like scenes may lie beside them, as those of hands.
fs::path scene_in(const std::vector<fs::path>& folders, const std::string& name) {
  for (const fs::path& folder : folders) {
    const fs::path file = folder / (name + ".toml");
    std::ifstream in(file);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (text.find("[scene]") != std::string::npos) return file;
  }
  return {};
}

// Returns the scenes that commands may load: those beside the one that is served, and palp's own. One that is opened
// becomes `current`, of whose options what is of one scene alone, as its spacing, does not hold for another.
palp::SceneChoice scenes_beside(palp::SceneOptions& current) {
  std::vector<fs::path> folders = palp::data_folders(palp::kSceneFiles);
  const fs::path own = fs::path(palp::find_scene_file(current.scene)).parent_path();
  folders.insert(folders.begin(), own.empty() ? "." : own);
  std::vector<std::string> names = palp::names_in(folders);
  std::erase_if(names, [&](const std::string& name) { return scene_in(folders, name).empty(); });
  const auto open = [&current, folders](const std::string& name) {
    palp::SceneOptions options = current;
    if (!name.empty()) {
      options.scene = scene_in(folders, name).string();
      if (options.scene.empty()) throw palp::ConfigError("the file of scene '" + name + "' is no longer there");
      options.particles.reset();
      options.overrides.spacing.reset();
      options.overrides.settings.clear();
    }
    auto simulation = palp::open_simulation(options);
    current = options;
    return simulation;
  };
  return {std::move(names), open};
}

void tell(const palp::Simulation& simulation, const palp::SceneOptions& options) {
  for (const std::string& warning : simulation.warnings()) spdlog::warn("{}", warning);
  if (options.particles) spdlog::info("{}", palp::particle_choice(simulation.scene(), *options.particles));
  if (const auto& choice = simulation.scene().config.choice) spdlog::info("{}", palp::told(*choice));
  spdlog::info("{}: {}", simulation.backend_name(), simulation.numerics());
}

void tell(const palp::ServerSummary& summary) {
  spdlog::info("{} steps, real-time factor {:.3f}, step p50 {:.0f} us, p99 {:.0f} us", summary.steps,
               summary.real_time_factor(), summary.step_p50_us, summary.step_p99_us);
  spdlog::info("{}: {}", summary.record.healthy() ? "healthy" : "not healthy", palp::describe(summary.record));
}

int run(Arguments& a) {
  auto simulation = palp::open_simulation(a.scene);
  if (!a.scene.explain.empty()) {
    for (const std::string& warning : simulation->warnings()) spdlog::warn("{}", warning);
    palp::explain(*simulation, a.scene.explain);
    return 0;
  }
  palp::catch_stop_signals();  // until here, which may take long, a signal simply ends the process
  const palp::SceneChoice scenes = scenes_beside(a.scene);
  const auto begin = std::chrono::steady_clock::now();
  const double seconds = a.server.seconds;
  bool healthy = true;
  while (true) {
    tell(*simulation, a.scene);
    // another scene is served as by another server: whoever listens finds it as after a restart
    const auto bus = palp::open_bus(a.bus);
    spdlog::info("serving '{}' over {} in domain {}", simulation->scene().config.name, palp::to_string(a.bus.vendor),
                 a.bus.domain);
    palp::Served served = palp::serve(*simulation, *bus, a.server, scenes, palp::stop_signal());
    tell(served.summary);
    healthy = healthy && served.summary.record.healthy();
    if (!served.next) {
      if (!a.summary.empty()) palp::write_json(a.summary, palp::json_of(served.summary, *simulation));
      return healthy ? 0 : 3;
    }
    simulation = std::move(served.next);
    a.server.start_paused = served.paused;
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - begin;
    if (seconds > 0) a.server.seconds = std::max(seconds - gone.count(), 1e-3);
  }
}

}  // namespace

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("sim_server"));
  CLI::App app("Simulates a scene and serves it over DDS.");
  Arguments arguments;
  declare(app, arguments);
  return palp::run_program("palp-sim-server", app, argc, argv, [&] { return run(arguments); });
}
