// The output of palp-ctl: one line each for people, or JSON.
#pragma once

#include <string>
#include <vector>

#include "config/json_file.h"
#include "idl/roster.h"

namespace palp {

// Returns name, state, the figures that matter most, how long ago it spoke, and what troubles it.
std::string line_of(const Peer& peer, std::int64_t now_ns);
Json json_of(const Peer& peer, std::int64_t now_ns);

// Parameters as a server lists them in its reply to get_parameter: one a line, name, value, unit and range between
// tabs.
struct ListedParameter {
  std::string name, value, unit, low, high;
};
std::vector<ListedParameter> parse_parameters(const std::string& text);
std::string line_of(const ListedParameter& parameter);
Json json_of(const ListedParameter& parameter);

}  // namespace palp
