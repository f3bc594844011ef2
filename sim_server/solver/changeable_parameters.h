// Parameters that may change while the simulation runs.
#pragma once

#include <string>
#include <vector>

#include "config/scene_config.h"

namespace palp {

// Writes one value, as a scene file would state it, into the configuration. Throws ConfigError and leaves it untouched.
void apply_parameter(SceneConfig& config, const std::string& name, const std::string& value);

// A parameter as it is now.
struct Parameter {
  std::string name;
  std::string value;         // as a scene file would state it; empty: derived from the accuracy level
  std::string unit;          // empty: none
  double low = 0, high = 0;  // of each number
};
std::vector<Parameter> parameters_of(const SceneConfig& config);

}  // namespace palp
