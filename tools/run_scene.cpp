#include "tools/run_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <nlohmann/json.hpp>

#include "config/data_dir.h"
#include "config/error.h"
#include "config/json_file.h"
#include "idl/convert.h"
#include "sim_server/messages_from_state.h"
#include "sim_server/probes/probes.h"
#include "sim_server/trade/choice.h"
#include "tools/lockstep/hand_in_step.h"
#include "tools/run_files.h"
#include "tools/run_recording.h"

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

// Drives the proxies of a run by paths and hands, and keeps the answers to hands.
class Drive {
 public:
  Drive(const Scene& scene, const RunOptions& options) : scene_(scene), repeat_(options.repeat_paths) {
    for (const auto& [device, path] : options.paths) {
      if (options.hands.contains(device))
        throw ConfigError(
            fmt::format("{}: device {} has a path and a hand, expected one of them", scene.config.path, device));
      paths_[proxy_of(device, "path")] = &path;
    }
    for (const auto& [device, script] : options.hands) {
      const std::size_t p = proxy_of(device, "hand");
      const Body& tool = scene.bodies[scene.proxies[p].body];
      hands_.emplace(p,
                     HandInStep(device, script,
                                at_rest(tool.position + tool.orientation * scene.proxies[p].handle, tool.orientation)));
    }
  }

  const std::map<std::size_t, const std::vector<PathPose>*>& paths() const { return paths_; }

  void set_input(double time, const StepOutput& output, StepInput& input) {
    for (const auto& [p, path] : paths_)
      input[p] = device_on_path(*path, repeat_ ? repeated(*path, time) : time, scene_.proxies[p].limit);
    for (auto& [p, hand] : hands_) input[p] = hand.input(time, 1 / scene_.config.rate_hz, output.proxies[p].state);
  }

  // Returns what a server would answer about each proxy after a step. input: of that step.
  std::vector<ProxySample> answers(const StepOutput& output, const StepInput& input) {
    std::vector<ProxySample> out;
    for (std::size_t p = 0; p < scene_.proxies.size(); ++p) {
      const auto hand = hands_.find(p);
      const bool ok = output.health.ok;
      out.push_back(hand != hands_.end()
                        ? hand->second.answer(output.proxies[p], ok, output.time)
                        : make_proxy_sample(output.proxies[p], scene_.proxies[p].device, {}, input[p].engaged,
                                            ok ? ServerState::running : ServerState::fault, output.time));
    }
    return out;
  }

 private:
  std::size_t proxy_of(unsigned device, const char* what) const {
    const auto proxy = std::find_if(scene_.proxies.begin(), scene_.proxies.end(),
                                    [device](const Proxy& item) { return item.device == device; });
    if (proxy == scene_.proxies.end())
      throw ConfigError(fmt::format("{}: a {} is given, but the scene has no [[proxy]] for device {}",
                                    scene_.config.path, what, device));
    return static_cast<std::size_t>(proxy - scene_.proxies.begin());
  }

  const Scene& scene_;
  bool repeat_;
  std::map<std::size_t, const std::vector<PathPose>*> paths_;  // by the index into Scene::proxies
  std::map<std::size_t, HandInStep> hands_;
};

// The files of a run but its summary and its recording.
class Files {
 public:
  Files(Simulation& simulation, const RunOptions& options, const Drive& drive)
      : simulation_(simulation), options_(options), probes_(simulation.scene(), options.out) {
    const Scene& scene = simulation.scene();
    for (const auto& [p, path] : drive.paths()) {
      const std::uint32_t device = scene.proxies[p].device;
      const std::string number = device == 0 ? "" : fmt::format("_{}", device);
      proxies_.emplace_back(p, ProxyFile(fmt::format("{}/proxy{}.csv", options.out, number)));
    }
    if (options.snapshots_hz > 0) snapshots_.emplace(scene, options.out);
    if (options.totals_hz > 0) totals_.emplace(scene, options.out + "/totals.csv");
  }

  void write(const StepOutput& output) {
    const double rate = simulation_.scene().config.rate_hz;
    const bool particles_due = snapshots_ && rate_due(output.step, options_.snapshots_hz, rate);
    const bool totals_due = totals_ && output.step > 0 && rate_due(output.step, options_.totals_hz, rate);
    if (particles_due || totals_due || probes_.due_with_snapshot(output.step)) simulation_.snapshot(snapshot_);
    if (probes_.due(output.step)) probes_.record(&snapshot_, output);
    if (particles_due) snapshots_->write(snapshot_);
    if (totals_due) totals_->write(snapshot_, output);
    if (output.step == 0) return;
    for (auto& [p, file] : proxies_) file.write(output.time, output.proxies.at(p));
  }

  void close() {
    probes_.close();
    if (snapshots_) snapshots_->close();
    if (totals_) totals_->close();
    for (auto& [p, file] : proxies_) file.close();
  }

 private:
  Simulation& simulation_;
  const RunOptions& options_;
  ProbeRecorder probes_;
  std::vector<std::pair<std::size_t, ProxyFile>> proxies_;  // index into Scene::proxies
  std::optional<SnapshotFiles> snapshots_;
  std::optional<TotalsFile> totals_;
  Snapshot snapshot_;
};

}  // namespace

void add_hands_of_scene(const SceneConfig& scene, RunOptions& options) {
  for (const ProxyConfig& proxy : scene.proxies)
    if (!options.paths.contains(proxy.device))
      options.hands.try_emplace(proxy.device, proxy.hand.empty() ? find_data_file(kHandFiles, "still") : proxy.hand);
}

RunResult run_scene(Simulation& simulation, const RunOptions& options) {
  const Scene& scene = simulation.scene();
  const double duration = options.duration.value_or(scene.config.duration), rate = scene.config.rate_hz;
  const std::uint64_t steps = steps_of(scene, options);
  if (!options.out.empty()) make_folder(options.out);
  Drive drive(scene, options);
  std::optional<Files> files;
  if (!options.out.empty()) files.emplace(simulation, options, drive);
  std::optional<RunRecording> recording;
  if (!options.record.empty()) recording.emplace(simulation, options.record, options.overwrite);
  Progress progress(options, duration, scene.position.size());

  RunResult result;
  Health health;
  simulation.reset();
  if (files) files->write(StepOutput{});
  if (recording) recording->write_state(simulation, simulation.output());
  const Clock::time_point start = Clock::now();
  StepInput input;
  StepTimes times;
  while (result.steps < steps && result.record.worst.ok && result.stopped_by_signal == 0) {
    drive.set_input(static_cast<double>(result.steps) / rate, simulation.output(), input);
    times.measure([&] { simulation.step(input); });
    const StepOutput& output = simulation.output();
    health = output.health;
    result.record.add(health);
    result.steps = output.step;
    result.time = output.time;
    if (files) files->write(output);
    std::vector<ProxySample> answers;
    if (recording || !options.hands.empty()) answers = drive.answers(output, input);
    if (recording) recording->write_state(simulation, output, answers);
    progress.show(output);
    if (options.stop) result.stopped_by_signal = *options.stop;
  }
  result.wall_time = seconds_since(start);
  if (recording) recording->close();
  if (!files) return result;
  files->close();
  Json summary = json_of(simulation, result, health);
  summary.update(times.summary(rate));
  write_json(options.out + "/summary.json", summary);
  return result;
}

}  // namespace palp
