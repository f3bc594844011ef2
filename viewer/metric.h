// Reads what a process says of itself.
#pragma once

#include <cmath>
#include <optional>
#include <string_view>

#include "idl/messages.h"

namespace palp {

// Returns the metric of that name times a factor, if it is there and finite.
inline std::optional<double> metric(const Status& status, std::string_view name, double factor = 1) {
  for (const Metric& m : status.metrics)
    if (m.name == name && std::isfinite(m.value)) return m.value * factor;
  return std::nullopt;
}

}  // namespace palp
