// haptic_bridge: arguments -> device -> bus threads -> loop. Exit status: 0 healthy, 1 a fault on the way, 2 bad input.
#include <atomic>
#include <csignal>
#include <memory>
#include <thread>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "config/program.h"
#include "config/stop_signal.h"
#include "haptic_bridge/bus_link.h"
#include "haptic_bridge/peers.h"
#include "haptic_bridge/preparation.h"
#include "haptic_bridge/scene_start.h"
#include "haptic_bridge/status_reporter.h"

namespace palp {
namespace {

constexpr int kThreadsBelowLoop = 5;  // priority of the bus threads below the loop's

// Runs the loop in a thread of its own, told of by the calling thread until it ends. guard: of a device with motors;
// null: it needs none. Returns what went wrong, or empty.
std::string run_bridge(const BridgeOptions& o, HapticLoop& loop, LoopPorts& ports, Supervisor* guard, BusLink& link,
                       BridgePeers& peers, FlightLog& log, StatusReporter& reporter, RealtimeReport& scheduling) {
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
    reporter.tell_started(scheduling.line());
    // threads are started and memory is taken by now: nothing of that stops the first ticks
    begin.store(true, std::memory_order_release);
    begin.notify_one();
    while (!ended.load(std::memory_order_acquire) && !link.failed()) {
      ports.unguarded = guard != nullptr && !guard->alive();
      if (wait_for_stop(kHousekeepingNs)) break;
      peers.look();
      failure = peers.refusal(link);
      if (!failure.empty()) break;
      reporter.tell_running(ports, link, peers);
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

// Returns where the log is, or why it is not; that is then the failure, where there was none.
std::string write_log(const FlightLog& log, const LoopConfig& config, const std::string& path, std::string& failure) {
  try {
    write_log_and_run(log, config, path);
    return fmt::format("{} ({} ticks)", path, log.size());
  } catch (const std::exception& error) {
    if (failure.empty()) failure = error.what();
    return error.what();
  }
}

// Returns 0 where a run that was kept gives the same wrenches again, else 1.
int rerun(const std::string& path) {
  const Rerun result = run_again(read_ticks(path));
  fmt::print("{}: {}\n", path, to_text(result));
  return result.differs_at == 0 ? 0 : kExitFailed;
}

// Opens the bus with its threads at this priority: DDS receives in threads of its own, and on a busy machine samples
// would be old before ours see them.
std::unique_ptr<Bus> bus_at(int priority, const BusOptions& options) {
  const PriorityHere its_threads(priority);
  return open_bus(options);
}

// Returns null where it was stopped while it waited for the scene.
std::unique_ptr<HapticDevice> open_device(const BridgeOptions& o, const DeviceRequest& request, Bus& bus, BusLink& link,
                                          StatusReporter& reporter) {
  std::optional<HandleStart> start;
  if (o.home) start = HandleStart{*o.home, *o.home};
  if (!o.driver->starts_in_scene) start = HandleStart{};
  if (!start) start = wait_for_start(bus, link, reporter, o.device_number);
  return start ? o.driver->open(request, *start) : nullptr;
}

// Adds to the summary what the device and the log have to say of the run. failure: of the run, or empty.
void complete(Summary& summary, const BridgeOptions& o, const DeviceRequest& request, const HapticDevice& device,
              const HapticLoop& loop, const FlightLog& log, std::string failure) {
  const LoopFault fault = loop.report().fault;
  const bool of_device =
      fault != LoopFault::none && fault != LoopFault::taken_for_dead && fault != LoopFault::unguarded;
  if (of_device && !device.trouble().empty()) failure = device.trouble();
  summary.device = fmt::format("{} ({})", device.info().name, request.profile.name);
  summary.log = write_log(log, loop.config(), o.log, failure);
  summary.trouble = failure;
  if (!failure.empty()) summary.state = "fault";
}

int run(const BridgeOptions& o) {
  DeviceRequest request = make_request(o);
  const std::unique_ptr<LogRoom> room = room_for_files(o);
  catch_stop_signals();
  take_stop_signals_in_wait();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is told as a full disk is
  SharedLog shared{FlightLog(logged_ticks(o))};
  const std::unique_ptr<Supervisor> supervisor = supervise(o, request, shared);

  RealtimeOptions bus_threads = o.realtime;
  bus_threads.priority = std::max(0, o.realtime.priority - kThreadsBelowLoop);
  const std::unique_ptr<Bus> bus = bus_at(bus_threads.priority, o.bus);
  LoopConfig& config = request.profile.loop;
  config.own_session = bus->session();
  LoopPorts ports;
  Supervisor* const guard = o.driver->has_motors() ? supervisor.get() : nullptr;
  if (guard) ports.heartbeat = &guard->heartbeat();
  BusLink link(*bus, o.device_number, bus_threads, ports);
  BridgePeers peers(*bus, o.device_number);
  const std::string process = fmt::format("haptic_bridge {}", o.device_number);
  StatusReporter reporter(*bus, process, fmt::format("{}, domain {}", to_string(o.bus.vendor), o.bus.domain));

  // before the arm is opened: its controller drops whoever is silent for two seconds
  const std::string tested = test_machine(o, config);
  spdlog::info("{}: {}", process, tested);
  RealtimeReport scheduling;
  lock_memory(o.realtime, scheduling);
  const std::unique_ptr<HapticDevice> device = open_device(o, request, *bus, link, reporter);
  if (!device) {
    reporter.tell_stopped("stopped", "stopped before a server was heard");
    return 0;
  }
  HapticLoop loop(config, *device);
  shared.config[0] = loop.config();
  const std::string failure = run_bridge(o, loop, ports, guard, link, peers, shared.log, reporter, scheduling);
  Summary summary = reporter.summary(loop.report(), ports, link);
  summary.scheduling = scheduling.line() + ", " + tested;
  complete(summary, o, request, *device, loop, shared.log, failure);
  reporter.finish(summary, o.summary);
  return summary.trouble.empty() ? 0 : kExitFailed;
}

}  // namespace
}  // namespace palp

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("haptic_bridge"));
  return palp::run_program("palp-haptic-bridge", [&] {
    const palp::Parsed<palp::BridgeOptions> parsed = palp::parse_options(argc, argv);
    if (!parsed.options) return parsed.exit_status;
    return parsed.options->rerun.empty() ? palp::run(*parsed.options) : palp::rerun(parsed.options->rerun);
  });
}
