// The version of palp that a program belongs to, as --version says it.
#pragma once

#include <string>

namespace palp {

// "0.2.0"
std::string version();
// "palp-run 0.2.0"
std::string version_of(const std::string& program);

}  // namespace palp
