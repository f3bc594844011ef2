// Parameters that may change while the simulation runs.
#pragma once

#include <string>

#include "config/scene_config.h"

namespace palp {

// Writes one value, as a scene file would state it, into the configuration. Throws ConfigError and leaves it untouched.
void apply_parameter(SceneConfig& config, const std::string& name, const std::string& value);

}  // namespace palp
