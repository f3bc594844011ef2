// Where the handle of a device begins: at the proxy that the server has for it.
#pragma once

#include <optional>

#include "haptic_bridge/bus_link.h"
#include "haptic_bridge/device/driver.h"
#include "haptic_bridge/status_reporter.h"

namespace palp {

// The main thread looks this often at what is not the loop's: signals, peers, the scene, what people are told.
inline constexpr std::int64_t kHousekeepingNs = 100'000'000;

// Waits for the scene that names the home pose, and tells people why it waits. None: stopped before one came.
std::optional<HandleStart> wait_for_start(Bus& bus, BusLink& link, StatusReporter& reporter,
                                          std::uint32_t device_number);

}  // namespace palp
