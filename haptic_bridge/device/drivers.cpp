#include "haptic_bridge/device/drivers.h"

#include <algorithm>

#include <fmt/format.h>

#include "config/error.h"
#include "haptic_bridge/device/replay.h"
#include "haptic_bridge/device/simulated.h"
#include "haptic_bridge/device/spacenav.h"
#include "haptic_bridge/device/virtuose.h"

namespace palp {

const std::vector<Driver>& drivers() {
  static const std::vector<Driver> kDrivers{simulated_driver(), replay_driver(), virtuose_driver(), spacenav_driver()};
  return kDrivers;
}

const Driver& find_driver(const std::string& name) {
  for (const Driver& d : drivers())
    if (name == d.name) return d;
  throw ConfigError(fmt::format("--device {}: there is no such device, expected {}", name,
                                drivers_that([](const Driver&) { return true; })));
}

namespace {

bool has_option(const Driver& driver, const std::string& name) {
  return std::any_of(driver.options.begin(), driver.options.end(),
                     [&](const DriverOption& option) { return name == option.name; });
}

}  // namespace

void check_options(const Driver& driver, const DriverOptions& given) {
  for (const auto& [name, text] : given) {
    if (has_option(driver, name)) continue;
    throw ConfigError(fmt::format("{} needs --device {}, and this is --device {}", name,
                                  drivers_that([&name = name](const Driver& d) { return has_option(d, name); }),
                                  driver.name));
  }
}

}  // namespace palp
