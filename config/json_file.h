// The JSON in which programs tell of themselves: summaries and results.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace palp {

using Json = nlohmann::ordered_json;  // its fields stay in the order they were given

// Returns the value as indented lines. Bytes that are no UTF-8 become U+FFFD, numbers that are not finite become null.
std::string json_text(const Json& json);

// Writes json_text to a file, which it replaces. Throws std::runtime_error when it cannot.
void write_json(const std::string& path, const Json& json);

}  // namespace palp
