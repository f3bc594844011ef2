// A device profile, read strictly from TOML. The grammar, units and ranges stand in config/devices/README.md.
#pragma once

#include <any>
#include <string>
#include <typeindex>
#include <unordered_map>

#include "config/toml_reader.h"
#include "haptic_bridge/loop/loop.h"

namespace palp {

// The profile of a device. Without a file it has limits that suit any arm.
struct DeviceProfile {
  std::string name = "built-in defaults";
  LoopConfig loop;  // its limits, gains, safety, passivity and workspace

  // Returns what the profile says of one kind of device. The type of that device's setup, which its driver reads, is
  // the key.
  template <class Setup>
  Setup& setup() {
    std::any& slot = setups_[typeid(Setup)];
    if (!slot.has_value()) slot = Setup{};
    return *std::any_cast<Setup>(&slot);
  }
  template <class Setup>
  const Setup& setup() const {
    static const Setup kDefaults{};
    const auto found = setups_.find(typeid(Setup));
    return found == setups_.end() ? kDefaults : *std::any_cast<Setup>(&found->second);
  }

 private:
  std::unordered_map<std::type_index, std::any> setups_;
};

// Throws ConfigError with every fault of the file, file:line each.
DeviceProfile read_device_profile(const std::string& path);

// Fills value with the number under key, if there is a sound one.
void read_number(TomlTable& table, const char* key, const Range& range, double& value);
void read_number(TomlTable& table, const char* key, const Range& range, Eigen::Vector3d& value);

inline constexpr double kDegree = M_PI / 180;

}  // namespace palp
