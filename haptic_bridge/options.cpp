#include "haptic_bridge/options.h"

#include <filesystem>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "config/command_line.h"
#include "config/error.h"
#include "config/number_between.h"
#include "haptic_bridge/device/drivers.h"
#include "idl/bus_options.h"
#include "idl/convert.h"

namespace palp {

namespace {

// The command line as CLI11 stores it, before it is checked and put together.
struct RawOptions {
  BridgeOptions options;
  std::string device = drivers().front().name;
  std::map<std::string, std::string> driver_texts;
  std::map<std::string, bool> driver_flags;
  std::vector<double> home;
};

// One option of the command line for all drivers that have it, each with its own words.
void add_driver_option(CLI::App& app, const DriverOption& option, RawOptions& raw) {
  std::string help;
  for (const Driver& driver : drivers())
    for (const DriverOption& other : driver.options)
      if (std::string(other.name) == option.name)
        help += fmt::format("{}{}: {}", help.empty() ? "" : "; ", driver.name, other.help);
  if (!option.value) {
    app.add_flag(option.name, raw.driver_flags[option.name], help);
    return;
  }
  CLI::Option* added = app.add_option(option.name, raw.driver_texts[option.name], help)->type_name(option.value);
  if (std::string(option.value).find('|') != std::string::npos)
    added->check(CLI::Validator(CLI::IsMember(CLI::detail::split(option.value, '|'))).description(""));
}

void add_device_options(CLI::App& app, RawOptions& raw) {
  BridgeOptions& o = raw.options;
  std::string help, names;
  for (const Driver& d : drivers()) {
    const std::string needs = *d.needs ? fmt::format(" (needs {})", d.needs) : "";
    help += fmt::format("{}{}: {}{}", help.empty() ? "" : "; ", d.name, d.what, needs);
    names += (names.empty() ? "" : "|") + std::string(d.name);
  }
  app.add_option("--device", raw.device, help)->type_name(names)->capture_default_str();
  app.add_option("--device-number", o.device_number, "which proxy of the scene this device moves")
      ->check(CLI::Range(0u, kMaxDevices - 1))
      ->capture_default_str();
  app.add_option("--profile", o.profile,
                 "device profile: limits, coupling gains, arm; a TOML file, or the name of one in config/devices")
      ->type_name("NAME");
  for (const Driver& driver : drivers())
    for (const DriverOption& option : driver.options)
      if (!app.get_option_no_throw(option.name)) add_driver_option(app, option, raw);
  app.add_option(
         "--home", raw.home,
         fmt::format("{}: where the handle begins, X Y Z [QX QY QZ QW] in m, world frame; without it the proxy's "
                     "pose in the scene",
                     drivers_that([](const Driver& d) { return d.starts_in_scene; })))
      ->expected(3, 7)
      ->type_name("NUMBER");
}

void add_loop_options(CLI::App& app, BridgeOptions& o) {
  app.add_option("--rate-hz", o.rate_hz, "ticks per second")
      ->check(number_between(100.0, 4000.0))
      ->capture_default_str();
  app.add_option("--seconds", o.seconds, "stop after so many seconds of ticks; 0: until SIGINT or SIGTERM")
      ->check(number_between(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--log", o.log,
                 "flight log: a file NAME.csv, or a folder (without an ending, or with / at its end) for "
                 "bridge_log.csv; folders are made; beside it go a summary (.json) and the run itself (.ticks, for "
                 "--rerun) [out/bridge_N/bridge_log.csv]")
      ->type_name("PATH");
  app.add_option("--summary", o.summary, "where the summary (JSON) goes instead")->type_name("FILE");
  app.add_option("--log-seconds", o.log_seconds, "how much of the run's end the flight log holds")
      ->check(number_between(1.0, 3600.0))
      ->capture_default_str();
  app.add_option("--rerun", o.rerun,
                 "run a loop again from what it took in (.ticks of an earlier run), without device and bus: says "
                 "whether each wrench is the same, bit for bit, or which tick differs first")
      ->type_name("FILE");
  app.add_option("--priority", o.realtime.priority, "SCHED_FIFO priority of the loop; 0: ordinary scheduling")
      ->check(CLI::Range(0, 98))
      ->capture_default_str();
  app.add_option("--cpu", o.realtime.cpu, "core that the loop stays on; -1: any")
      ->check(CLI::Range(-1, 1023))
      ->capture_default_str();
  app.add_option("--self-test", o.self_test,
                 "measure this machine's lateness for so many seconds before the start; if one tick in a thousand is "
                 "late by more than 0.5 ms, at most 3 N and 0.2 N m are sent [5 where the device has motors, else 0]")
      ->check(number_between(0.0, 600.0));
  app.add_flag("--full-force", o.full_force, "send the profile's force whatever the self-test says");
  app.add_option("--stiffness", o.stiffness, "coupling gain [N/m], instead of the profile's")
      ->check(number_between(0.0, 1e5));
  app.add_option("--damping", o.damping, "coupling gain [N s/m]")->check(number_between(0.0, 1e4));
  app.add_option("--angular-stiffness", o.angular_stiffness, "coupling gain [N m/rad]")
      ->check(number_between(0.0, 1e4));
  app.add_option("--angular-damping", o.angular_damping, "coupling gain [N m s/rad]")->check(number_between(0.0, 1e3));
  app.add_option("--motion-scale", o.motion_scale, "the tool's way over the arm's, instead of the profile's")
      ->check(number_between(0.01, 100.0));
  app.add_option("--force-scale", o.force_scale, "force on the hand over that of the simulation")
      ->check(number_between(0.01, 100.0));
}

void add_options(CLI::App& app, RawOptions& raw) {
  app.description(
      "The 1 kHz process between a haptic device and sim_server: reads the device, renders the virtual coupling, "
      "limits the wrench, sends it to the device.");
  add_device_options(app, raw);
  add_loop_options(app, raw.options);
  add_bus_options(app, raw.options.bus);
}

RigidState to_home(const std::vector<double>& n) {
  if (n.size() != 3 && n.size() != 7)
    throw ConfigError(
        fmt::format("--home: expected 3 numbers (position) or 7 (position and quaternion x y z w), got {}", n.size()));
  RigidState home;
  home.position = {n[0], n[1], n[2]};
  if (n.size() == 7) home.orientation = Eigen::Quaterniond(n[6], n[3], n[4], n[5]);
  if (!is_finite(home.position) || !is_unit(home.orientation))
    throw ConfigError("--home: expected finite metres and a quaternion of length 1 within 0.001");
  home.orientation.normalize();
  return home;
}

// Returns the file of the flight log: NAME.csv as it was given, else bridge_log.csv in the folder that was given, which
// need not be there yet.
std::string to_log_file(const BridgeOptions& o) {
  constexpr const char* kName = "bridge_log.csv";
  if (o.log.empty()) return fmt::format("out/bridge_{}/{}", o.device_number, kName);
  const std::filesystem::path path(o.log);
  std::error_code ignored;
  const bool is_folder = path.extension().empty() || std::filesystem::is_directory(path, ignored);
  if (is_folder) return (path / kName).string();
  if (path.extension() != ".csv")
    throw ConfigError(fmt::format(
        "--log {}: expected a file NAME.csv, or a folder; where this is to be a folder, end it with /", o.log));
  return o.log;
}

// Throws ConfigError with one sentence about what does not go together.
BridgeOptions check_together(RawOptions& raw) {
  BridgeOptions& o = raw.options;
  o.driver = &find_driver(raw.device);
  for (const auto& [name, text] : raw.driver_texts)
    if (!text.empty()) o.driver_options[name] = text;
  for (const auto& [name, given] : raw.driver_flags)
    if (given) o.driver_options[name];
  check_options(*o.driver, o.driver_options);
  if (!raw.home.empty()) {
    if (!o.driver->starts_in_scene)
      throw ConfigError(fmt::format("--home needs --device {}; with --device {} the handle begins where {} has it",
                                    drivers_that([](const Driver& d) { return d.starts_in_scene; }), o.driver->name,
                                    o.driver->what));
    o.home = to_home(raw.home);
  }
  o.log = to_log_file(o);
  if (o.summary.empty()) o.summary = std::filesystem::path(o.log).replace_extension(".json").string();
  return o;
}

}  // namespace

Parsed<BridgeOptions> parse_options(int argc, char** argv) {
  RawOptions raw;
  CLI::App app;
  add_options(app, raw);
  if (const auto status = read_command_line(app, "palp-haptic-bridge", argc, argv)) return {std::nullopt, *status};
  return {check_together(raw), 0};
}

}  // namespace palp
