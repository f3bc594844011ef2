// haptic_bridge: arguments -> device -> bus threads -> loop. Exit status: 0 healthy, 1 a fault on the way, 2 bad input.
#include <atomic>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <thread>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "config/error.h"
#include "haptic_bridge/bus_link.h"
#include "haptic_bridge/device/profile.h"
#include "haptic_bridge/device/replay.h"
#include "haptic_bridge/device/virtuose.h"
#include "haptic_bridge/guard/supervisor.h"
#include "haptic_bridge/log/crash_log.h"
#include "haptic_bridge/log/rerun.h"
#include "haptic_bridge/options.h"
#include "haptic_bridge/peers.h"
#include "haptic_bridge/report.h"
#include "haptic_bridge/status_reporter.h"
#include "idl/clock.h"

namespace palp {
namespace {

constexpr std::int64_t kHousekeepingNs = 100'000'000;
constexpr double kSelfTest = 5;           // before an arm with motors is used [s]
constexpr double kUntrustedForce = 3;     // sent on a machine that is often late [N]
constexpr double kUntrustedTorque = 0.2;  // [N m]
constexpr int kThreadsBelowLoop = 5;      // priority of the bus threads below the loop's

// SIGINT and SIGTERM are blocked in every thread and waited for here. So is SIGCHLD, which only ends a wait early.
class StopSignal {
 public:
  StopSignal() {
    sigemptyset(&set_);
    sigaddset(&set_, SIGINT);
    sigaddset(&set_, SIGTERM);
    std::signal(SIGCHLD, SIG_DFL);  // whoever started this process may have left it ignored
    sigaddset(&set_, SIGCHLD);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
  }
  // True once one of them has come.
  bool wait(std::int64_t timeout_ns) {
    const timespec timeout = to_timespec(timeout_ns);
    const int signal = sigtimedwait(&set_, nullptr, &timeout);
    if (signal == SIGINT || signal == SIGTERM) stopped_ = true;
    return stopped_;
  }

 private:
  sigset_t set_;
  bool stopped_ = false;
};

DeviceProfile profile_from(const BridgeOptions& o) {
  DeviceProfile profile = o.profile.empty() ? DeviceProfile{} : read_device_profile(o.profile);
  profile.loop.gains.stiffness = o.stiffness.value_or(profile.loop.gains.stiffness);
  profile.loop.gains.damping = o.damping.value_or(profile.loop.gains.damping);
  profile.loop.gains.angular_stiffness = o.angular_stiffness.value_or(profile.loop.gains.angular_stiffness);
  profile.loop.gains.angular_damping = o.angular_damping.value_or(profile.loop.gains.angular_damping);
  profile.loop.workspace.motion_scale = o.motion_scale.value_or(profile.loop.workspace.motion_scale);
  profile.loop.workspace.force_scale = o.force_scale.value_or(profile.loop.workspace.force_scale);
  // an arm without motors harms nobody when this machine is busy
  if (o.profile.empty() && o.device != DeviceKind::virtuose)
    profile.loop.safety.overrun_ns = profile.loop.safety.late_ticks = 0;
  // wherever the arm stands, its handle begins at the tool
  if (o.profile.empty() && o.device == DeviceKind::virtuose) profile.loop.workspace.relative = true;
  if (o.device == DeviceKind::virtuose && !o.profile.empty() && !profile.for_virtuose)
    throw ConfigError(
        fmt::format("{}: it has no table [virtuose], so its limits are not for this arm: give one of "
                    "config/devices/virtuose_*.toml",
                    o.profile));
  VirtuoseSetup& arm = profile.virtuose;
  if (!o.library.empty()) arm.library = profile.spacenav.library = o.library;
  if (!o.address.empty()) arm.address = o.address;
  arm.mode = o.virtuose_mode.value_or(arm.mode);
  arm.limits = profile.loop.limits;
  arm.gains = profile.loop.gains;
  arm.period = 1 / o.rate_hz;
  return profile;
}

LoopConfig loop_config(const BridgeOptions& o, const DeviceProfile& profile, const Bus& bus) {
  LoopConfig config = profile.loop;
  config.period_ns = std::llround(1e9 / o.rate_hz);
  config.device = o.device_number;
  config.own_session = bus.session();
  return config;
}

// The log and the loop's configuration, where another process sees them.
struct Kept {
  FlightLog log;
  SharedArray<LoopConfig> config{1};
};

// If this process dies, an arm with motors is powered off from outside, and the log is written there.
std::unique_ptr<Supervisor> supervise(const BridgeOptions& o, const DeviceProfile& profile, const Kept& kept) {
  std::function<void()> off;
  if (o.device == DeviceKind::virtuose) off = [setup = profile.virtuose] { power_off(setup); };
  return std::make_unique<Supervisor>(off, [&kept, path = o.log]() -> std::string {
    if (kept.log.is_written()) return "the flight log is in " + path;
    if (kept.log.size() == 0) return "there is no flight log, for no tick was done";
    write_log_and_run(kept.log, kept.config[0], path);
    return fmt::format("the flight log was written to {} ({} ticks)", path, kept.log.size());
  });
}

// On a machine that is often late the arm gets little force. What was found, as one phrase.
std::string test_machine(const BridgeOptions& o, LoopConfig& config) {
  const double seconds = o.self_test.value_or(o.device == DeviceKind::virtuose ? kSelfTest : 0);
  if (seconds <= 0) return "lateness not tested";
  const Lateness l = measure_lateness(o.realtime, config.period_ns, seconds);
  const bool trusted = l.p999_us <= kTrustedLateness;
  if (!trusted && !o.full_force) {
    config.limits.force = std::min(config.limits.force, kUntrustedForce);
    config.limits.torque = std::min(config.limits.torque, kUntrustedTorque);
  }
  return fmt::format("late in {:.0f} s of test by {:.0f} us (median), {:.0f} us (99.9 %), {:.0f} us (worst): {}",
                     l.seconds, l.p50_us, l.p999_us, l.max_us,
                     trusted        ? "full force"
                     : o.full_force ? "too late for an arm, full force all the same"
                                    : fmt::format("too late for an arm, at most {} N and {} N m", config.limits.force,
                                                  config.limits.torque));
}

// Where the simulated handle starts: the home pose, or wherever the server holds the proxy now.
struct Start {
  RigidState home;
  RigidState at;
};

// Returns the newest scene of that server, or of any where it is not known which one answers; null: none has come.
const SceneDescription* scene_of(std::uint64_t server, std::vector<Received<SceneDescription>>& scenes) {
  constexpr std::size_t kMost = 8;  // whoever sends more replaces the oldest
  if (scenes.size() > kMost) scenes.erase(scenes.begin(), scenes.end() - kMost);
  for (std::size_t i = scenes.size(); i-- > 0;)
    if (server == 0 || scenes[i].message.header.session == server) return &scenes[i].message;
  return nullptr;
}

// Waits for the scene that names the home pose. None: stopped before one came.
std::optional<Start> find_start(const BridgeOptions& o, Bus& bus, BusLink& link, Herald& herald, StopSignal& stop) {
  if (o.home) return Start{*o.home, *o.home};
  const auto reader = bus.reader<SceneDescription>();
  std::vector<Received<SceneDescription>> scenes;
  std::optional<RigidState> home;
  std::uint64_t home_of = 0;  // the server whose scene that is
  std::int64_t t_home_ns = 0;
  while (!stop.wait(home ? kHousekeepingNs / 5 : kHousekeepingNs)) {
    reader->take_all(scenes);
    ProxySample proxy;
    const bool moves = link.newest_proxy(proxy);
    const SceneDescription* scene = scene_of(link.server_session(), scenes);
    if (!scene) {
      home.reset();
      home_of = 0;
    } else if (scene->header.session != home_of) {
      home = herald.home_in(*scene, o.device_number);
      home_of = scene->header.session;
      t_home_ns = now_ns();
    }
    if (home && moves) return Start{*home, to_state(proxy.proxy_pose, TwistD{})};
    // a server that stands still says nothing: its proxy is where the scene put it
    if (home && now_ns() - t_home_ns > 3 * kHousekeepingNs) return Start{*home, *home};
    herald.tell_waiting(*reader, link);
  }
  return std::nullopt;
}

// None: stopped while it waited for the scene.
std::unique_ptr<HapticDevice> open_device(const BridgeOptions& o, const DeviceProfile& profile,
                                          const HandScript& script, Bus& bus, BusLink& link, Herald& herald,
                                          StopSignal& stop) {
  if (o.device == DeviceKind::replay) return std::make_unique<ReplayDevice>(o.path, o.loop_path);
  const std::optional<Start> start = find_start(o, bus, link, herald, stop);
  if (!start) return nullptr;
  if (o.device == DeviceKind::virtuose) return std::make_unique<VirtuoseDevice>(profile.virtuose, start->at);
  if (o.device == DeviceKind::spacenav) return std::make_unique<SpacenavDevice>(profile.spacenav, start->at);
  return std::make_unique<SimulatedDevice>(profile.arm, script, start->home, start->at);
}

// The loop in a thread of its own, told of by the calling thread until it ends. guard: of the arm; null: it needs none.
// Returns what went wrong, or empty.
std::string run_bridge(const BridgeOptions& o, HapticLoop& loop, LoopPorts& ports, Supervisor* guard, BusLink& link,
                       BridgePeers& peers, FlightLog& log, Herald& herald, StopSignal& stop,
                       RealtimeReport& scheduling) {
  const CrashLog crash_log(log, loop.config(), o.log);
  std::atomic<bool> stop_loop{false}, ended{false};
  std::atomic<bool> prepared{false}, begin{false};
  std::thread thread([&] {
    make_realtime(o.realtime, scheduling);
    prepared.store(true, std::memory_order_release);
    begin.wait(false, std::memory_order_acquire);
    RealClock clock;
    run_loop(loop, clock, ports, log, stop_loop, static_cast<std::uint64_t>(o.seconds * o.rate_hz));
    ended.store(true, std::memory_order_release);
  });
  std::string failure;
  try {
    link.start();
    while (!prepared.load(std::memory_order_acquire)) std::this_thread::yield();
    herald.tell_started(scheduling.line());
    // threads are started and memory is taken by now: nothing of that stops the first ticks
    begin.store(true, std::memory_order_release);
    begin.notify_one();
    while (!ended.load(std::memory_order_acquire) && !link.failed()) {
      ports.unguarded = guard != nullptr && !guard->alive();
      if (stop.wait(kHousekeepingNs)) break;
      peers.look();
      failure = peers.refusal(link);
      if (!failure.empty()) break;
      herald.tell_running(ports, link, peers);
    }
  } catch (const std::exception& error) {
    failure = error.what();
  }
  stop_loop = true;
  begin = true;
  begin.notify_one();
  thread.join();
  link.stop();
  if (link.failed()) failure = "the bus failed: " + link.failure();
  if (failure.empty()) failure = to_string(loop.report().fault);
  return failure;
}

std::string write_log(const FlightLog& log, const LoopConfig& config, const std::string& path, std::string& failure) {
  try {
    write_log_and_run(log, config, path);
    return fmt::format("{} ({} ticks)", path, log.size());
  } catch (const std::exception& error) {
    if (failure.empty()) failure = error.what();
    return error.what();
  }
}

// 0: the same wrenches; 1: others.
int rerun(const std::string& path) {
  const Rerun result = run_again(read_ticks(path));
  fmt::print("{}: {}\n", path, to_text(result));
  return result.differs_at == 0 ? 0 : 1;
}

// What DDS receives goes through threads of its own: on a busy machine samples would be old before ours see them.
std::unique_ptr<Bus> bus_at(int priority, const BusOptions& options) {
  const PriorityHere its_threads(priority);
  return open_bus(options);
}

std::size_t logged_ticks(const BridgeOptions& o) { return static_cast<std::size_t>(o.log_seconds * o.rate_hz); }

// What cannot be written is told before the run, not at its end.
std::unique_ptr<LogRoom> room_for_files(const BridgeOptions& o) {
  std::unique_ptr<LogRoom> room;
  try {
    room = std::make_unique<LogRoom>(o.log, logged_ticks(o));
  } catch (const std::exception& error) {
    throw ConfigError(error.what());
  }
  std::error_code ignored;
  const bool was_there = std::filesystem::exists(o.summary, ignored);
  if (!std::ofstream(o.summary, std::ios::app))
    throw ConfigError(fmt::format("summary {}: it cannot be written; give another file with --summary", o.summary));
  if (!was_there) std::filesystem::remove(o.summary, ignored);
  return room;
}

int run(const BridgeOptions& o) {
  // everything the user gave is read before anything is opened
  DeviceProfile profile = profile_from(o);
  if (o.device == DeviceKind::virtuose) VirtuoseApi(profile.virtuose.library);  // a wrong one is told at once
  const HandScript script = o.hand.empty() ? HandScript{} : read_hand_script(o.hand);
  const std::unique_ptr<LogRoom> room = room_for_files(o);
  const std::string process = fmt::format("haptic_bridge {}", o.device_number);
  StopSignal stop;
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is told as a full disk is
  Kept kept{FlightLog(logged_ticks(o))};
  FlightLog& log = kept.log;
  // before there is any thread
  const std::unique_ptr<Supervisor> supervisor = supervise(o, profile, kept);
  RealtimeOptions bus_threads = o.realtime;
  bus_threads.priority = std::max(0, o.realtime.priority - kThreadsBelowLoop);
  const std::unique_ptr<Bus> bus = bus_at(bus_threads.priority, o.bus);
  LoopPorts ports;
  // an arm without motors harms nobody
  Supervisor* const guard = o.device == DeviceKind::virtuose ? supervisor.get() : nullptr;
  if (guard) ports.heartbeat = &guard->heartbeat();
  BusLink link(*bus, o.device_number, bus_threads, ports);
  BridgePeers peers(*bus, o.device_number);
  Herald herald(*bus, process, fmt::format("{}, domain {}", to_string(o.bus.vendor), o.bus.domain));

  // before the arm is opened: its controller drops whoever is silent for two seconds
  LoopConfig config = loop_config(o, profile, *bus);
  const std::string tested = test_machine(o, config);
  profile.virtuose.limits = config.limits;
  spdlog::info("{}: {}", process, tested);
  RealtimeReport scheduling;
  lock_memory(o.realtime, scheduling);
  const std::unique_ptr<HapticDevice> device = open_device(o, profile, script, *bus, link, herald, stop);
  if (!device) {
    herald.tell_stopped("stopped", "stopped before a server was heard");
    return 0;
  }
  HapticLoop loop(config, *device);
  kept.config[0] = loop.config();
  std::string failure = run_bridge(o, loop, ports, guard, link, peers, log, herald, stop, scheduling);
  Summary summary = herald.summary(loop.report(), ports, link);
  const LoopFault fault = loop.report().fault;
  const bool of_device =
      fault != LoopFault::none && fault != LoopFault::taken_for_dead && fault != LoopFault::unguarded;
  if (of_device && !device->trouble().empty()) failure = device->trouble();
  summary.device = fmt::format("{} ({})", device->info().name, profile.name);
  summary.scheduling = scheduling.line() + ", " + tested;
  summary.log = write_log(log, loop.config(), o.log, failure);
  summary.trouble = failure;
  if (!failure.empty()) summary.state = "fault";
  herald.finish(summary, o.summary);
  return failure.empty() ? 0 : 1;
}

}  // namespace
}  // namespace palp

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("haptic_bridge"));
  try {
    const palp::ParsedOptions parsed = palp::parse_options(argc, argv);
    if (!parsed.options) return parsed.exit_status;
    return parsed.options->rerun.empty() ? palp::run(*parsed.options) : palp::rerun(parsed.options->rerun);
  } catch (const palp::ConfigError& error) {
    fmt::print(stderr, "palp-haptic-bridge: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "palp-haptic-bridge: {}\n", error.what());
    return 1;
  }
}
