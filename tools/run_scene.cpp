#include "tools/run_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <nlohmann/json.hpp>

#include "config/error.h"
#include "config/json_file.h"
#include "sim_server/probes/probes.h"
#include "sim_server/trade/choice.h"
#include "tools/run_files.h"

namespace palp {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Writes one file per snapshot, and a list of them with their times.
class SnapshotFiles {
 public:
  SnapshotFiles(const Scene& scene, const std::string& folder)
      : scene_(scene), folder_(folder), list_(folder + "/snapshots.csv", {"snapshot", "time_s"}) {}

  void write(const Snapshot& snapshot) {
    std::vector<std::string> columns{"x", "y", "z", "vx", "vy", "vz", "density", "pressure"};
    const bool warm = !snapshot.temperature.empty();
    if (warm) columns.push_back("temperature");
    const bool changes = !snapshot.body_id.empty();
    if (changes) columns.push_back("body_id");
    columns.push_back("body");
    CsvFile file(fmt::format("{}/particles_{:06}.csv", folder_, count_), columns);
    std::string rows;
    const auto to = std::back_inserter(rows);
    for (std::size_t i = 0; i < scene_.position.size(); ++i) {
      const float *x = &snapshot.position[3 * i], *v = &snapshot.velocity[3 * i];
      fmt::format_to(to, "{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},", x[0], x[1], x[2], v[0], v[1], v[2],
                     snapshot.density[i], snapshot.pressure[i]);
      if (warm) fmt::format_to(to, "{:.9g},", snapshot.temperature[i]);
      if (changes) fmt::format_to(to, "{},", snapshot.body_id[i]);
      fmt::format_to(to, "{}\n", scene_.bodies[scene_.body[i]].name);
      if (rows.size() > (1u << 20)) {
        file.append(rows);
        rows.clear();
      }
    }
    file.append(rows);
    file.close();
    list_.row({static_cast<double>(count_++), snapshot.time});
  }

  void close() { list_.close(); }

 private:
  const Scene& scene_;
  std::string folder_;
  CsvFile list_;
  std::size_t count_ = 0;
};

// Tells on stderr how far the run has come and how long it will still take.
class Progress {
 public:
  Progress(const RunOptions& options, double duration, std::size_t particles)
      : on_(options.progress),
        period_(options.progress_period),
        duration_(duration),
        particles_(static_cast<double>(particles)),
        start_(Clock::now()),
        due_(on_ == ProgressOn::log ? std::min(1.0, period_) : 0) {}
  void show(const StepOutput& output) {
    const double wall = seconds_since(start_);
    if (on_ == ProgressOn::nothing || wall < due_) return;
    const bool terminal = on_ == ProgressOn::terminal;
    due_ = wall + (terminal ? 0.2 : period_);
    const double done = output.time / duration_;
    std::fprintf(stderr, "%s%8.3f of %g s (%3.0f %%), %.2e particle-steps/s, %.0f s left%s", terminal ? "\r" : "",
                 output.time, duration_, 100 * done, static_cast<double>(output.step) * particles_ / wall,
                 wall / done * (1 - done), terminal ? "   " : "\n");
    std::fflush(stderr);
    any_ = terminal;
  }
  ~Progress() {
    if (any_) std::fprintf(stderr, "\n");
  }

 private:
  ProgressOn on_;
  bool any_ = false;
  double period_, duration_, particles_;
  Clock::time_point start_;
  double due_;  // [s] since the start
};

Json json_of(const Simulation& simulation, const RunResult& result, const Health& health) {
  const Scene& scene = simulation.scene();
  const double rate =
      result.wall_time > 0 ? static_cast<double>(result.steps * scene.position.size()) / result.wall_time : 0;
  Json out{{"scene", scene.config.name},
           {"scene_file", scene.config.path},
           {"scene_hash", fmt::format("{:016x}", scene.config.hash)},
           {"method", to_string(scene.config.method)},
           {"accuracy", to_string(scene.config.accuracy)},
           {"spacing_m", scene.spacing},
           {"numerics", simulation.numerics()},
           {"chosen", json_of(scene.config.choice)},
           {"backend", simulation.backend_name()},
           {"particles", scene.position.size()},
           {"rate_hz", scene.config.rate_hz},
           {"sub_steps", simulation.sub_steps()},
           {"support_m", simulation.support_radius()},
           {"memory_bytes", simulation.footprint().bytes()},
           {"steps", result.steps},
           {"simulated_time_s", result.time},
           {"wall_time_s", result.wall_time},
           {"particle_steps_per_s", rate},
           {"warnings", simulation.warnings()},
           {"healthy", result.record.healthy()},
           {"cause", result.record.trouble()},
           {"stopped_by_signal", result.stopped_by_signal},
           {"max_speed_m_s", health.max_speed},
           {"max_compression", health.max_compression},
           {"kinetic_energy_J", health.kinetic_energy},
           {"elastic_unsolved", health.unsolved},
           {"particles_outside", health.outside},
           {"particles_gone", health.inactive},
           {"mass_gone_kg", health.inactive_mass},
           {"particles_asleep", health.asleep},
           {"particles_non_finite", health.non_finite}};
  out.update(json_of(result.record));
  return out;
}

// Returns the number of haptic steps of a run.
std::uint64_t steps_of(const Scene& scene, const RunOptions& options) {
  const double rate = scene.config.rate_hz, duration = options.duration.value_or(scene.config.duration);
  if (duration * rate < 1 - 1e-9)
    throw ConfigError(
        fmt::format("{}: a duration of {:g} s is less than a haptic step of {:g} s, expected at least one: "
                    "run for longer, or raise rate_hz",
                    options.duration ? "--duration" : scene.config.path, duration, 1 / rate));
  return static_cast<std::uint64_t>(std::llround(duration * rate));
}

// A proxy that a path drives, and its file.
struct Driven {
  std::size_t proxy;  // index into Scene::proxies
  const std::vector<PathPose>* path;
  ProxyFile file;
};

std::vector<Driven> driven_proxies(const Scene& scene, const RunOptions& options) {
  std::vector<Driven> driven;
  for (const auto& [device, path] : options.paths) {
    const auto proxy = std::find_if(scene.proxies.begin(), scene.proxies.end(),
                                    [number = device](const Proxy& item) { return item.device == number; });
    if (proxy == scene.proxies.end())
      throw ConfigError(
          fmt::format("{}: a path is given, but the scene has no [[proxy]] for device {}", scene.config.path, device));
    const std::string number = device == 0 ? "" : fmt::format("_{}", device);
    driven.push_back({static_cast<std::size_t>(proxy - scene.proxies.begin()), &path,
                      ProxyFile(fmt::format("{}/proxy{}.csv", options.out, number))});
  }
  return driven;
}

}  // namespace

RunResult run_scene(Simulation& simulation, const RunOptions& options) {
  const Scene& scene = simulation.scene();
  const double duration = options.duration.value_or(scene.config.duration), rate = scene.config.rate_hz;
  const std::uint64_t steps = steps_of(scene, options);
  make_folder(options.out);
  std::vector<Driven> driven = driven_proxies(scene, options);
  ProbeRecorder probes(scene, options.out);
  std::optional<SnapshotFiles> snapshots;
  if (options.snapshots_hz > 0) snapshots.emplace(scene, options.out);
  std::optional<TotalsFile> totals;
  if (options.totals_hz > 0) totals.emplace(scene, options.out + "/totals.csv");
  Progress progress(options, duration, scene.position.size());
  Snapshot snapshot;
  const auto record = [&](const StepOutput& output) {
    const bool particles_due = snapshots && rate_due(output.step, options.snapshots_hz, rate);
    const bool totals_due = totals && output.step > 0 && rate_due(output.step, options.totals_hz, rate);
    if (particles_due || totals_due || probes.due_with_snapshot(output.step)) simulation.snapshot(snapshot);
    if (probes.due(output.step)) probes.record(&snapshot, output);
    if (particles_due) snapshots->write(snapshot);
    if (totals_due) totals->write(snapshot, output);
    if (output.step == 0) return;
    for (Driven& d : driven) d.file.write(output.time, output.proxies.at(d.proxy));
  };

  RunResult result;
  Health health;
  simulation.reset();
  record(StepOutput{});
  const Clock::time_point start = Clock::now();
  StepInput input;
  StepTimes times;
  while (result.steps < steps && result.record.worst.ok && result.stopped_by_signal == 0) {
    const double time = static_cast<double>(result.steps) / rate;
    for (const Driven& d : driven) {
      const double on_path = options.repeat_paths ? repeated(*d.path, time) : time;
      input[d.proxy] = device_on_path(*d.path, on_path, scene.proxies[d.proxy].limit);
    }
    times.measure([&] { simulation.step(input); });
    const StepOutput& output = simulation.output();
    health = output.health;
    result.record.add(health);
    result.steps = output.step;
    result.time = output.time;
    record(output);
    progress.show(output);
    if (options.stop) result.stopped_by_signal = *options.stop;
  }
  result.wall_time = seconds_since(start);
  probes.close();
  if (snapshots) snapshots->close();
  if (totals) totals->close();
  for (Driven& d : driven) d.file.close();
  Json summary = json_of(simulation, result, health);
  summary.update(times.summary(rate));
  write_json(options.out + "/summary.json", summary);
  return result;
}

}  // namespace palp
