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

// Writes what the driven proxy feels, step by step.
class ProxyFile {
 public:
  explicit ProxyFile(const std::string& folder)
      : file_(folder + "/proxy.csv", {"time_s",
                                      "x_m",
                                      "y_m",
                                      "z_m",
                                      "qx",
                                      "qy",
                                      "qz",
                                      "qw",
                                      "fx_N",
                                      "fy_N",
                                      "fz_N",
                                      "tx_N_m",
                                      "ty_N_m",
                                      "tz_N_m",
                                      "contact_fx_N",
                                      "contact_fy_N",
                                      "contact_fz_N",
                                      "contact_tx_N_m",
                                      "contact_ty_N_m",
                                      "contact_tz_N_m"}) {}
  void write(double time, const ProxyOutput& proxy) {
    ProbeRow row{time};
    const auto add = [&](const auto& v) {
      for (Eigen::Index a = 0; a < v.size(); ++a) row.push_back(v[a]);
    };
    add(proxy.state.position);
    add(proxy.state.orientation.coeffs());
    add(proxy.force);
    add(proxy.torque);
    add(proxy.contact_force);
    add(proxy.contact_torque);
    file_.row(row);
  }
  void close() { file_.close(); }

 private:
  CsvFile file_;
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
  return {{"scene", scene.config.name},
          {"scene_file", scene.config.path},
          {"scene_hash", fmt::format("{:016x}", scene.config.hash)},
          {"method", to_string(scene.config.method)},
          {"accuracy", to_string(scene.config.accuracy)},
          {"spacing_m", scene.spacing},
          {"numerics", simulation.numerics()},
          {"backend", simulation.backend_name()},
          {"particles", scene.position.size()},
          {"rate_hz", scene.config.rate_hz},
          {"steps", result.steps},
          {"simulated_time_s", result.time},
          {"wall_time_s", result.wall_time},
          {"particle_steps_per_s", rate},
          {"healthy", result.healthy},
          {"cause", result.cause},
          {"stopped_by_signal", result.stopped_by_signal},
          {"max_speed_m_s", health.max_speed},
          {"max_compression", health.max_compression},
          {"kinetic_energy_J", health.kinetic_energy},
          {"elastic_unsolved", health.unsolved},
          {"particles_outside", health.outside},
          {"particles_gone", health.inactive},
          {"mass_gone_kg", health.inactive_mass},
          {"particles_non_finite", health.non_finite}};
}

// Returns the index of the proxy that device 0 drives.
std::optional<std::size_t> driven_proxy(const Scene& scene, const RunOptions& options) {
  if (options.path.empty()) return {};
  for (std::size_t i = 0; i < scene.proxies.size(); ++i) {
    if (scene.proxies[i].device == 0) return i;
  }
  throw ConfigError(scene.config.path + ": a path is given, but the scene has no [[proxy]] for device 0");
}

}  // namespace

RunResult run_scene(Simulation& simulation, const RunOptions& options) {
  const Scene& scene = simulation.scene();
  const double duration = options.duration.value_or(scene.config.duration), rate = scene.config.rate_hz;
  const auto steps = static_cast<std::uint64_t>(std::llround(duration * rate));
  const std::optional<std::size_t> driven = driven_proxy(scene, options);
  make_folder(options.out);
  ProbeRecorder probes(scene, options.out);
  std::optional<SnapshotFiles> snapshots;
  if (options.snapshots_hz > 0) snapshots.emplace(scene, options.out);
  std::optional<ProxyFile> proxy;
  if (driven) proxy.emplace(options.out);
  Progress progress(options, duration, scene.position.size());
  Snapshot snapshot;
  const auto record = [&](const StepOutput& output) {
    const bool particles_due = snapshots && rate_due(output.step, options.snapshots_hz, rate);
    if (particles_due || probes.due_with_snapshot(output.step)) simulation.snapshot(snapshot);
    if (probes.due(output.step)) probes.record(&snapshot, output);
    if (particles_due) snapshots->write(snapshot);
    if (driven && output.step > 0) proxy->write(output.time, output.proxies.at(*driven));
  };

  RunResult result;
  Health health;
  simulation.reset();
  record(StepOutput{});
  const Clock::time_point start = Clock::now();
  StepInput input;
  while (result.steps < steps && result.healthy && result.stopped_by_signal == 0) {
    if (driven) {
      const double time = static_cast<double>(result.steps) / rate;
      input[*driven] = device_on_path(options.path, time, scene.proxies[*driven].limit);
    }
    const StepOutput& output = simulation.step(input);
    health = output.health;
    result.healthy = health.ok;
    result.cause = health.cause;
    result.steps = output.step;
    result.time = output.time;
    record(output);
    progress.show(output);
    if (options.stop) result.stopped_by_signal = *options.stop;
  }
  result.wall_time = seconds_since(start);
  probes.close();
  if (snapshots) snapshots->close();
  if (proxy) proxy->close();
  write_json(options.out + "/summary.json", json_of(simulation, result, health));
  return result;
}

}  // namespace palp
