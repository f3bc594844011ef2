// The table of device drivers. A new device is a driver of its own (two files), its row here and its tests.
#pragma once

#include <string>
#include <vector>

#include "haptic_bridge/device/driver.h"

namespace palp {

// The first one is used unless --device says otherwise.
const std::vector<Driver>& drivers();

// Throws ConfigError that names those there are.
const Driver& find_driver(const std::string& name);

// Returns the names of the drivers for which it holds, as in "simulated, virtuose or spacenav".
template <class Holds>
std::string drivers_that(Holds&& holds) {
  std::vector<std::string> names;
  for (const Driver& d : drivers())
    if (holds(d)) names.emplace_back(d.name);
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return text;
}

// Throws ConfigError where an option was given that this driver does not have.
void check_options(const Driver& driver, const DriverOptions& given);

}  // namespace palp
