// A value that wins over the one in a file: "numerics.safety=0.4".
#pragma once

#include <cstdint>
#include <string>

#include "config/toml_library.h"

namespace palp {

// Puts the value of a setting TABLE.KEY=VALUE into root, in the place of any value there; tables on the way are made
// where they are missing. VALUE is TOML; a bare word is a text. The key is marked as standing in `line`.
// Returns what is wrong with the setting, or nothing; root is then as it was, but for tables without keys.
std::string insert_setting(toml::table& root, const std::string& setting, std::uint32_t line);

}  // namespace palp
