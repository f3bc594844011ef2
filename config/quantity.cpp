#include "config/quantity.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>

#include "config/error.h"
#include "config/text_file.h"

namespace palp {

namespace {

struct Unit {
  const char* name;
  double size;
};
// The longer names come first: "us" ends with "s".
constexpr Unit kTimes[] = {{"us", 1e-6}, {"\xc2\xb5s", 1e-6}, {"ms", 1e-3}, {"s", 1}};

// Returns the number before the unit, or nothing where the text does not end with the unit.
std::optional<double> number_before(std::string_view text, std::string_view unit) {
  if (text.size() <= unit.size() || text.substr(text.size() - unit.size()) != unit) return std::nullopt;
  return parse_number(text.substr(0, text.size() - unit.size()));
}

}  // namespace

double parse_duration(const std::string& text) {
  for (const Unit& unit : kTimes) {
    const std::optional<double> number = number_before(text, unit.name);
    if (!number) continue;
    const double seconds = *number * unit.size;
    if (seconds >= 1e-6 && seconds <= 100) return seconds;
    throw ConfigError(fmt::format("expected a time from 1us to 100s, got '{}'", text));
  }
  throw ConfigError(fmt::format("expected a time with its unit, such as 500us, 0.5ms or 1e-3s, got '{}'", text));
}

double parse_share(const std::string& text) {
  const std::optional<double> percent = number_before(text, "%"), plain = parse_number(text);
  const double share = percent ? *percent / 100 : plain.value_or(-1);
  if (share > 0 && share <= 1) return share;
  throw ConfigError(
      fmt::format("expected a share of the force above 0 and up to 100%, such as 5% or 0.05, got '{}'", text));
}

std::string duration_text(double seconds) {
  if (seconds < 1e-3) return fmt::format("{:.3g} us", 1e6 * seconds);
  return seconds < 1 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} s", seconds);
}

std::string share_text(double share) { return fmt::format("{:.2g} %", 100 * share); }

}  // namespace palp
