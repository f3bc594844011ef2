// Runs a scene without devices and DDS, as fast as it goes, for studies and films: probes and particle snapshots as
// CSV, a recording as palp-record writes them. Exit status: 0 done, 1 the run failed, 2 bad input, 3 the simulation
// turned unhealthy, 128 + signal when stopped.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "config/command_line.h"
#include "config/csv_file.h"
#include "config/data_dir.h"
#include "config/error.h"
#include "config/number_between.h"
#include "config/stop_signal.h"
#include "idl/messages.h"
#include "sim_server/explain.h"
#include "sim_server/scene_options.h"
#include "tools/run_scene.h"

namespace {

struct Arguments {
  palp::SceneOptions scene;
  std::vector<std::string> paths, hands;
  bool scene_hands = false;
  palp::RunOptions run;
};

void declare(CLI::App& app, Arguments& a) {
  palp::add_scene_options(app, a.scene);
  palp::add_explain_option(app, a.scene);
  app.add_option("--duration", a.run.duration, "simulated seconds, instead of the scene's")
      ->check(palp::number_between(1e-9, 1e6));
  app.add_option("--out", a.run.out,
                 "folder for the results, made if missing (required, but with --record or --explain)");
  app.add_option("--snapshots-hz", a.run.snapshots_hz, "particle files per simulated second; 0: none")
      ->check(palp::number_between(0.0, 1e6));
  app.add_option("--totals-hz", a.run.totals_hz,
                 "rows of totals.csv per simulated second: energy, momentum, volume, heat, penetration; 0: none")
      ->check(palp::number_between(0.0, 1e6));
  app.add_option("--path", a.paths,
                 "CSV time,x,y,z,qx,qy,qz,qw that drives the handle of a device, 0 without a number; may be repeated")
      ->type_name("[DEVICE=]FILE")
      ->allow_extra_args(false);
  app.add_flag("--repeat-paths", a.run.repeat_paths,
               "begin each path anew where it ends, which must be where it begins");
  auto* record =
      app.add_option("--record", a.run.record,
                     "write a recording (MCAP) as palp-record does, in simulated time: frames at the scene's "
                     "particle_rate_hz, poses, and what the tools' hands feel")
          ->type_name("FILE");
  app.add_flag("--overwrite", a.run.overwrite, "replace an existing recording")->needs(record);
  app.add_flag(
      "--hands", a.scene_hands,
      "let a simulated arm in the hand that the scene names move each tool that has no --path, in lock step with "
      "the simulation (with --record: always)");
  app.add_option("--hand", a.hands, "another hand for a device, the first one without a number; may be repeated")
      ->type_name("[DEVICE=]NAME")
      ->allow_extra_args(false);
  app.callback([&a] {
    if (a.run.out.empty() && a.run.record.empty() && a.scene.explain.empty()) throw CLI::RequiredError("--out");
  });
}

// Throws ConfigError for a path that would leap where it begins anew.
void check_closed(const std::vector<palp::PathPose>& path, const std::string& file) {
  const palp::PathPose &first = path.front(), &last = path.back();
  const double apart = (last.position - first.position).norm(),
               turn = last.orientation.angularDistance(first.orientation);
  if (apart > 1e-6 || turn > 1e-6)
    throw palp::ConfigError(
        fmt::format("{}:{}: the last pose is {:.3g} m and {:.3g} rad from the first one, expected the "
                    "same for --repeat-paths: lead the path back, or leave that option out",
                    file, last.line, apart, turn));
}

// Takes "[DEVICE=]REST" apart; the first device is meant where none is named.
std::pair<unsigned, std::string> device_and_rest(const std::string& text, unsigned first) {
  const std::size_t digits = text.find_first_not_of("0123456789");
  const bool numbered = digits > 0 && digits < 4 && text[digits] == '=';
  return {numbered ? static_cast<unsigned>(std::stoul(text.substr(0, digits))) : first,
          numbered ? text.substr(digits + 1) : text};
}

// Reads "[DEVICE=]FILE" into a path of its device. Throws ConfigError.
void read_path(const std::string& text, palp::RunOptions& run) {
  const auto [device, file] = device_and_rest(text, 0);
  const std::vector<palp::PathPose> path = palp::read_pose_path(file);
  if (run.repeat_paths) check_closed(path, file);
  if (!run.paths.emplace(device, path).second)
    throw palp::ConfigError(
        fmt::format("--path {}: device {} has a path already, expected one for each", text, device));
}

// Chooses the hands of the scene's tools. Throws ConfigError.
void choose_hands(const palp::SceneConfig& scene, Arguments& a) {
  if (!a.scene_hands && a.hands.empty() && a.run.record.empty()) return;
  unsigned first = palp::kMaxDevices;
  for (const palp::ProxyConfig& proxy : scene.proxies) first = std::min(first, static_cast<unsigned>(proxy.device));
  for (const std::string& text : a.hands) {
    const auto [device, name] = device_and_rest(text, first);
    a.run.hands[device] = palp::find_data_file(palp::kHandFiles, name);
  }
  palp::add_hands_of_scene(scene, a.run);
}

void warn(const palp::Simulation& simulation) {
  for (const std::string& warning : simulation.warnings()) fmt::print(stderr, "palp-run: warning: {}\n", warning);
}

// Prints the scene's bill in place of a run.
int explain(const Arguments& a) {
  const auto simulation = palp::open_simulation(a.scene);
  warn(*simulation);
  palp::explain(*simulation, a.scene.explain);
  return 0;
}

int run(Arguments& a) {
  if (!a.scene.explain.empty()) return explain(a);
  for (const std::string& path : a.paths) read_path(path, a.run);
  a.scene.scene = palp::find_scene_file(a.scene.scene);
  if (!a.run.out.empty()) palp::make_folder(a.run.out);  // before the scene is sampled, which may take long
  const auto simulation = palp::open_simulation(a.scene);
  // until here, which may take long, a signal simply ends the process; now it stops the run between two steps
  palp::catch_stop_signals(palp::SecondSignal::ends_at_once);
  const palp::Scene& scene = simulation->scene();
  if (a.scene.particles) fmt::print(stderr, "{}\n", palp::particle_choice(scene, *a.scene.particles));
  if (scene.config.choice) fmt::print(stderr, "{}\n", palp::told(*scene.config.choice));
  fmt::print(stderr, "{}: {} particles, {}; {}\n", scene.config.name, scene.position.size(), simulation->backend_name(),
             simulation->numerics());
  warn(*simulation);
  choose_hands(scene.config, a);
  a.run.progress = isatty(STDERR_FILENO) != 0 ? palp::ProgressOn::terminal : palp::ProgressOn::log;
  a.run.stop = &palp::stop_signal();
  const palp::RunResult result = palp::run_scene(*simulation, a.run);
  fmt::print(stderr, "{} steps, {:g} s simulated in {:.2f} s; results in {}\n", result.steps, result.time,
             result.wall_time, a.run.out.empty() ? a.run.record : a.run.out);
  const palp::HealthRecord& record = result.record;
  if (!record.worst.ok) fmt::print(stderr, "palp-run: stopped at {:g} s: {}\n", result.time, record.trouble());
  if (record.worst.ok && !record.healthy())
    fmt::print(stderr, "palp-run: the answer is spoilt: {}\n", record.trouble());
  if (!record.worst.notice.empty()) fmt::print(stderr, "palp-run: warning: {}\n", record.worst.notice);
  fmt::print(stderr, "{}: {}\n", record.healthy() ? "healthy" : "not healthy", palp::describe(record));
  if (!record.healthy()) return 3;
  return result.stopped_by_signal > 0 ? 128 + result.stopped_by_signal : 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Runs a scene as fast as it goes and writes its probes and particles as CSV.");
  Arguments arguments;
  declare(app, arguments);
  return palp::run_program("palp-run", app, argc, argv, [&] { return run(arguments); });
}
