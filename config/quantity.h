// Quantities with a unit, as people type them on a command line: times and shares.
#pragma once

#include <string>

namespace palp {

// Returns the time in seconds that "500us", "0.5ms" or "1e-3s" says, from 1 us to 100 s. Throws ConfigError with one
// sentence that says what was expected.
double parse_duration(const std::string& text);

// Returns the share that "5%" or "0.05" says, above 0 and up to 1. Throws ConfigError likewise.
double parse_share(const std::string& text);

// Return a time in the unit that suits it, "462 us", and a share in percent, "4.6 %".
std::string duration_text(double seconds);
std::string share_text(double share);

}  // namespace palp
