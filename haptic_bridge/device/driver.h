// Describes to the bridge a kind of device before one is open: its name, what it needs, its options, how it is opened
// and how its power is taken off. Each driver fills in one of these descriptions; drivers.h has the table of them.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "haptic_bridge/device/profile.h"
#include "haptic_bridge/loop/haptic_device.h"

namespace palp {

// An option of the command line that some drivers have. Several drivers may share one.
struct DriverOption {
  const char* name;   // "--library"
  const char* value;  // what --help calls its value; "one|another": those are all; null: a flag
  const char* help;
};

// The options that were given, by name; a flag's text is empty.
using DriverOptions = std::map<std::string, std::string>;

// The request that a device is opened with. The loop in its profile has the limits, gains and period that the bridge
// will run with.
struct DeviceRequest {
  DeviceProfile profile;
  std::string profile_file;  // empty: the built-in defaults
  DriverOptions options;

  // Returns the text of an option, or what stands in for it where it was not given.
  std::string option(const char* name, const std::string& otherwise = {}) const {
    const auto found = options.find(name);
    return found == options.end() ? otherwise : found->second;
  }
};

// The place where a handle without one of its own begins, world frame.
struct HandleStart {
  RigidState home;  // the pose of the proxy in the scene, or the one that --home gave
  RigidState at;    // where the server holds the proxy now
};

struct Driver {
  const char* name;   // as --device has it
  const char* what;   // one phrase for --help
  const char* needs;  // what must be there besides palp, one phrase; empty: nothing
  std::vector<DriverOption> options;
  bool starts_in_scene;  // open is told where the handle begins, which may have to be heard from the server

  // Takes what the profile says of this kind of device out of its tables. Null: nothing.
  void (*read_profile)(TomlTable& root, DeviceProfile& profile);
  // Puts options and profile together and looks for what is needed, before anything is opened or waited for. Throws
  // ConfigError or std::runtime_error with one sentence. Null: there is nothing to do.
  void (*prepare)(DeviceRequest& request);
  // start: only for those that start in the scene.
  std::unique_ptr<HapticDevice> (*open)(const DeviceRequest& request, const HandleStart& start);
  // Takes the power off a device whose bridge has died, from another process. Null: it has no motors, so that it can
  // hurt nobody.
  void (*power_off)(const DeviceRequest& request);

  bool has_motors() const { return power_off != nullptr; }
};

}  // namespace palp
