// Describes what a recording contains, for people.
#pragma once

#include <string>

namespace palp {

// Returns a few lines: duration, counts, drops, one line per topic. Throws McapError for a file that has no index or is
// none.
std::string describe_recording(const std::string& path);

}  // namespace palp
