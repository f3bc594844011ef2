// sim_server: simulates a scene and serves it over DDS.
// Exit status: 0 done, 1 the run failed, 2 bad input, 3 the simulation turned unhealthy.
#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <fstream>
#include <map>

#include "config/error.h"
#include "idl/bus_options.h"
#include "sim_server/scene_files.h"
#include "sim_server/server.h"

namespace {

std::atomic<int> g_stop{0};
void on_signal(int signal) { g_stop = signal; }

struct Arguments {
  std::string scene, summary;
  palp::SceneOverrides overrides;
  palp::Backend backend = palp::Backend::automatic;
  palp::BusOptions bus;
  palp::ServerOptions server;
};

void declare(CLI::App& app, Arguments& a) {
  static const std::map<std::string, palp::Backend> backends{
      {"auto", palp::Backend::automatic}, {"cpu", palp::Backend::cpu}, {"cuda", palp::Backend::cuda}};
  static const std::map<std::string, palp::Method> methods{{"paper", palp::Method::paper},
                                                           {"accurate", palp::Method::accurate}};
  static const std::map<std::string, palp::Accuracy> accuracies{
      {"fast", palp::Accuracy::fast}, {"balanced", palp::Accuracy::balanced}, {"accurate", palp::Accuracy::accurate}};
  app.add_option("scene", a.scene, "Scene file, or the name of one in config/scenes")->required();
  app.add_option("--backend", a.backend, "auto, cpu or cuda (default: auto)")
      ->transform(CLI::CheckedTransformer(backends));
  app.add_option("--method", a.overrides.method, "paper or accurate (default: the scene's)")
      ->transform(CLI::CheckedTransformer(methods));
  app.add_option("--accuracy", a.overrides.accuracy, "fast, balanced or accurate (default: the scene's)")
      ->transform(CLI::CheckedTransformer(accuracies));
  app.add_option("--spacing", a.overrides.spacing, "Particle spacing in metres (default: the scene's)");
  app.add_option("--seconds", a.server.seconds, "Stop after this wall time (default: never)")
      ->check(CLI::Range(0.0, 1e9));
  app.add_flag("--paused", a.server.start_paused, "Wait for a resume command");
  app.add_option("--summary", a.summary, "Write a JSON summary to this file at the end");
  palp::add_bus_options(app, a.bus);
}

int run(const Arguments& a) {
  const palp::SceneConfig config = palp::load_scene(palp::find_scene_file(a.scene), a.overrides);
  const palp::Scene scene = palp::sample_scene(config, palp::particles_in_memory());
  const auto simulation = palp::make_simulation(scene, a.backend);
  spdlog::info("{}: {}", simulation->backend_name(), simulation->numerics());
  const auto bus = palp::open_bus(a.bus);
  spdlog::info("serving '{}' over {} in domain {}", config.name, palp::to_string(a.bus.vendor), a.bus.domain);
  const palp::ServerSummary summary = palp::serve(*simulation, *bus, a.server, g_stop);
  spdlog::info("{} steps, real-time factor {:.3f}, step p50 {:.0f} us, p99 {:.0f} us", summary.steps,
               summary.real_time_factor(), summary.step_p50_us, summary.step_p99_us);
  if (!a.summary.empty()) {
    std::ofstream out(a.summary);
    out << palp::to_json(summary, *simulation);
    out.close();
    if (!out)
      throw std::runtime_error(
          fmt::format("{}: the summary could not be written; expected a writable file", a.summary));
  }
  return summary.healthy ? 0 : 3;
}

}  // namespace

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("sim_server"));
  CLI::App app("Simulates a scene and serves it over DDS.");
  Arguments arguments;
  declare(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  try {
    return run(arguments);
  } catch (const palp::ConfigError& error) {
    for (const std::string& fault : error.faults()) spdlog::error("{}", fault);
    return 2;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return 1;
  }
}
