// Runs a scene without devices and DDS, as fast as it goes, for studies: probes and particle snapshots as CSV.
// Exit status: 0 done, 1 the run failed, 2 bad input, 3 the simulation turned unhealthy, 128 + signal when stopped.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>

#include "config/csv_file.h"
#include "config/error.h"
#include "config/number_between.h"
#include "config/version.h"
#include "sim_server/backend/thread_waits.h"
#include "sim_server/scene_options.h"
#include "tools/run_scene.h"

namespace {

std::atomic<int> g_stop{0};
static_assert(std::atomic<int>::is_always_lock_free);
// The first signal stops the run between two steps; a second one ends the program at once.
void on_signal(int signal) {
  g_stop = signal;
  std::signal(signal, SIG_DFL);
}

struct Arguments {
  palp::SceneOptions scene;
  std::string path;
  palp::RunOptions run;
};

void declare(CLI::App& app, Arguments& a) {
  palp::add_scene_options(app, a.scene);
  app.add_option("--duration", a.run.duration, "simulated seconds, instead of the scene's")
      ->check(palp::number_between(1e-9, 1e6));
  app.add_option("--out", a.run.out, "folder for the results, made if missing")->required();
  app.add_option("--snapshots-hz", a.run.snapshots_hz, "particle files per simulated second; 0: none")
      ->check(palp::number_between(0.0, 1e6));
  app.add_option("--path", a.path, "CSV time,x,y,z,qx,qy,qz,qw that drives the handle of device 0");
}

int run(Arguments& a) {
  if (!a.path.empty()) a.run.path = palp::read_pose_path(a.path);
  a.scene.scene = palp::find_scene_file(a.scene.scene);
  palp::make_folder(a.run.out);  // before the scene is sampled, which may take long
  const auto simulation = palp::open_simulation(a.scene);
  // until here, which may take long, a signal simply ends the process
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  const palp::Scene& scene = simulation->scene();
  if (a.scene.particles) fmt::print(stderr, "{}\n", palp::particle_choice(scene, *a.scene.particles));
  fmt::print(stderr, "{}: {} particles, {}; {}\n", scene.config.name, scene.position.size(), simulation->backend_name(),
             simulation->numerics());
  a.run.progress = isatty(STDERR_FILENO) != 0 ? palp::ProgressOn::terminal : palp::ProgressOn::log;
  a.run.stop = &g_stop;
  const palp::RunResult result = palp::run_scene(*simulation, a.run);
  fmt::print(stderr, "{} steps, {:g} s simulated in {:.2f} s; results in {}\n", result.steps, result.time,
             result.wall_time, a.run.out);
  if (!result.healthy) {
    fmt::print(stderr, "palp-run: stopped at {:g} s: {}\n", result.time, result.cause);
    return 3;
  }
  return result.stopped_by_signal > 0 ? 128 + result.stopped_by_signal : 0;
}

}  // namespace

int main(int argc, char** argv) {
  palp::wait_asleep(argv);
  CLI::App app("Runs a scene as fast as it goes and writes its probes and particles as CSV.", "palp-run");
  app.set_version_flag("--version", palp::version_of("palp-run"));
  Arguments arguments;
  declare(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return run(arguments);
  } catch (const palp::ConfigError& error) {
    for (const std::string& fault : error.faults()) fmt::print(stderr, "palp-run: {}\n", fault);
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "palp-run: {}\n", error.what());
    return 1;
  }
}
