// sim_server: simulates a scene and serves it over DDS.
// Exit status: 0 done, 1 the run failed, 2 bad input, 3 the simulation turned unhealthy.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>

#include "config/command_line.h"
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
  app.add_option("--summary", a.summary, "write a summary (JSON) to this file at the end");
  palp::add_bus_options(app, a.bus);
}

int run(const Arguments& a) {
  const auto simulation = palp::open_simulation(a.scene);
  for (const std::string& warning : simulation->warnings()) spdlog::warn("{}", warning);
  if (!a.scene.explain.empty()) {
    palp::explain(*simulation, a.scene.explain);
    return 0;
  }
  palp::catch_stop_signals();  // until here, which may take long, a signal simply ends the process
  if (a.scene.particles) spdlog::info("{}", palp::particle_choice(simulation->scene(), *a.scene.particles));
  if (const auto& choice = simulation->scene().config.choice) spdlog::info("{}", palp::told(*choice));
  spdlog::info("{}: {}", simulation->backend_name(), simulation->numerics());
  const auto bus = palp::open_bus(a.bus);
  spdlog::info("serving '{}' over {} in domain {}", simulation->scene().config.name, palp::to_string(a.bus.vendor),
               a.bus.domain);
  const palp::ServerSummary summary = palp::serve(*simulation, *bus, a.server, palp::stop_signal());
  spdlog::info("{} steps, real-time factor {:.3f}, step p50 {:.0f} us, p99 {:.0f} us", summary.steps,
               summary.real_time_factor(), summary.step_p50_us, summary.step_p99_us);
  spdlog::info("{}: {}", summary.record.healthy() ? "healthy" : "not healthy", palp::describe(summary.record));
  if (!a.summary.empty()) palp::write_json(a.summary, palp::json_of(summary, *simulation));
  return summary.record.healthy() ? 0 : 3;
}

}  // namespace

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("sim_server"));
  CLI::App app("Simulates a scene and serves it over DDS.");
  Arguments arguments;
  declare(app, arguments);
  return palp::run_program("palp-sim-server", app, argc, argv, [&] { return run(arguments); });
}
