// Runs a scene without devices and DDS, as fast as it goes, for studies: probes and particle snapshots as CSV.
// Exit status: 0 done, 1 the run failed, 2 bad input, 3 the simulation turned unhealthy, 128 + signal when stopped.
#include <fmt/format.h>
#include <unistd.h>

#include "config/command_line.h"
#include "config/csv_file.h"
#include "config/number_between.h"
#include "config/stop_signal.h"
#include "sim_server/backend/thread_waits.h"
#include "sim_server/scene_options.h"
#include "tools/run_scene.h"

namespace {

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
  // until here, which may take long, a signal simply ends the process; now it stops the run between two steps
  palp::catch_stop_signals(palp::SecondSignal::ends_at_once);
  const palp::Scene& scene = simulation->scene();
  if (a.scene.particles) fmt::print(stderr, "{}\n", palp::particle_choice(scene, *a.scene.particles));
  fmt::print(stderr, "{}: {} particles, {}; {}\n", scene.config.name, scene.position.size(), simulation->backend_name(),
             simulation->numerics());
  a.run.progress = isatty(STDERR_FILENO) != 0 ? palp::ProgressOn::terminal : palp::ProgressOn::log;
  a.run.stop = &palp::stop_signal();
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
  CLI::App app("Runs a scene as fast as it goes and writes its probes and particles as CSV.");
  Arguments arguments;
  declare(app, arguments);
  return palp::run_program("palp-run", app, argc, argv, [&] { return run(arguments); });
}
