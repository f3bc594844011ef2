#include "haptic_bridge/options.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <vector>

#include <CLI/CLI.hpp>

#include "config/error.h"
#include "config/number_between.h"
#include "config/version.h"
#include "haptic_bridge/loop/local_model.h"
#include "idl/bus_options.h"

namespace palp {

namespace {

// What CLI11 stores before it is checked and put together.
struct RawOptions {
  BridgeOptions options;
  std::vector<double> home;
};

void add_device_options(CLI::App& app, RawOptions& raw) {
  BridgeOptions& o = raw.options;
  const std::map<std::string, DeviceKind> kinds{{"simulated", DeviceKind::simulated},
                                                {"replay", DeviceKind::replay},
                                                {"virtuose", DeviceKind::virtuose},
                                                {"spacenav", DeviceKind::spacenav}};
  const std::map<std::string, VirtuoseMode> modes{{"impedance", VirtuoseMode::impedance},
                                                  {"virtmech", VirtuoseMode::mechanism}};
  app.add_option("--device", o.device,
                 "simulated: an arm in a scripted hand; replay: a recorded path; virtuose: an arm by Haption; "
                 "spacenav: a 3D mouse, without force")
      ->transform(CLI::CheckedTransformer(kinds).description(""))
      ->type_name("simulated|replay|virtuose|spacenav")
      ->default_str("simulated");
  app.add_option("--device-number", o.device_number, "which proxy of the scene this device moves")
      ->check(CLI::Range(0u, kMaxDevices - 1))
      ->capture_default_str();
  app.add_option("--profile", o.profile, "device profile (TOML): limits, coupling gains, arm")->type_name("FILE");
  app.add_option("--hand", o.hand, "simulated: what the hand does (TOML); without it the hand holds still")
      ->type_name("FILE");
  app.add_option("--path", o.path, "replay: CSV of time,x,y,z,qx,qy,qz,qw in s and m, world frame")->type_name("FILE");
  app.add_flag("--loop-path", o.loop_path, "replay: begin again at the end (the path must end where it began)");
  app.add_option("--library", o.library,
                 "virtuose: Haption's VirtuoseAPI, or one like it [libVirtuoseAPI.so]; spacenav: [libspnav.so.0]")
      ->type_name("FILE");
  app.add_option("--address", o.address, "virtuose: where its service listens [127.0.0.1#53210]")
      ->type_name("HOST#PORT");
  app.add_option(
         "--virtuose-mode", o.virtuose_mode,
         "impedance: the bridge renders the coupling and sends force; virtmech: the arm's controller does [impedance]")
      ->transform(CLI::CheckedTransformer(modes).description(""))
      ->type_name("impedance|virtmech");
  app.add_option("--home", raw.home,
                 "simulated, virtuose, spacenav: where the handle begins, X Y Z [QX QY QZ QW] in m, world frame; "
                 "without it the "
                 "proxy's pose in the scene")
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
  app.add_option(
         "--log", o.log,
         "flight log (CSV), or a directory for it; beside it go a summary (.json) and the run itself (.ticks, for "
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
                 "late by more than 0.5 ms, at most 3 N and 0.2 N m are sent [virtuose: 5, else 0]")
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
      "limits "
      "the wrench, sends it to the device.");
  app.set_version_flag("--version", version_of("palp-haptic-bridge"));
  add_device_options(app, raw);
  add_loop_options(app, raw.options);
  add_bus_options(app, raw.options.bus);
}

RigidState to_home(const std::vector<double>& n) {
  RigidState home = at_rest({n[0], n[1], n[2]}, Eigen::Quaterniond::Identity());
  if (n.size() == 7) home.orientation = Eigen::Quaterniond(n[6], n[3], n[4], n[5]);
  if (!is_finite(home.position) || !is_unit(home.orientation))
    throw ConfigError("--home: expected finite metres and a quaternion of length 1 within 0.001");
  home.orientation.normalize();
  return home;
}

std::string to_log_file(const BridgeOptions& o) {
  if (o.log.empty()) return "out/bridge_" + std::to_string(o.device_number) + "/bridge_log.csv";
  if (o.log.back() == '/' || std::filesystem::is_directory(o.log))
    return (std::filesystem::path(o.log) / "bridge_log.csv").string();
  return o.log;
}

void check_together(RawOptions& raw) {
  BridgeOptions& o = raw.options;
  const bool replay = o.device == DeviceKind::replay;
  if (replay && o.path.empty()) throw ConfigError("--device replay needs --path FILE, the path to replay");
  if (!replay && (!o.path.empty() || o.loop_path)) throw ConfigError("--path and --loop-path need --device replay");
  if (o.device != DeviceKind::simulated && !o.hand.empty())
    throw ConfigError("--hand needs --device simulated; only a simulated arm has a simulated hand");
  if (replay && !raw.home.empty())
    throw ConfigError("--home needs --device simulated, virtuose or spacenav; a replayed path is in the world frame");
  const bool virtuose = o.device == DeviceKind::virtuose;
  if (!virtuose && o.device != DeviceKind::spacenav && !o.library.empty())
    throw ConfigError("--library needs --device virtuose or spacenav");
  if (!virtuose && (!o.address.empty() || o.virtuose_mode))
    throw ConfigError("--address and --virtuose-mode need --device virtuose");
  if (!raw.home.empty() && raw.home.size() != 3 && raw.home.size() != 7)
    throw ConfigError("--home: expected 3 numbers (position) or 7 (position and quaternion x y z w), got " +
                      std::to_string(raw.home.size()));
  if (!raw.home.empty()) o.home = to_home(raw.home);
  o.log = to_log_file(o);
  if (o.summary.empty()) o.summary = std::filesystem::path(o.log).replace_extension(".json").string();
}

}  // namespace

ParsedOptions parse_options(int argc, char** argv) {
  RawOptions raw;
  CLI::App app("", "palp-haptic-bridge");
  add_options(app, raw);
  try {
    app.parse(argc, argv);
    check_together(raw);
  } catch (const CLI::ParseError& error) {
    return {std::nullopt, app.exit(error) == 0 ? 0 : 2};
  } catch (const ConfigError& error) {
    std::fprintf(stderr, "palp-haptic-bridge: %s\n", error.what());
    return {std::nullopt, 2};
  }
  return {raw.options, 0};
}

}  // namespace palp
