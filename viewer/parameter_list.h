// The parameters that a server lists as changeable, as panels show them. Pure.
#pragma once

#include <string>
#include <vector>

namespace palp {

struct ListedParameter {
  std::string name;
  std::vector<double> value;  // one number or three; empty: derived from the accuracy level
  std::string unit;           // empty: none
  double low = 0, high = 0;   // of each number; low < high
  bool operator==(const ListedParameter&) const = default;
};

// Reads the reply to get_parameter (idl/messages.h). Lines that are no numbers with a range are passed over, as are
// lines past the first few hundred: the text comes from the bus.
std::vector<ListedParameter> read_parameter_list(const std::string& text);

// Returns the numbers as set_parameter takes them: "0 0 -9.81".
std::string parameter_text(const std::vector<double>& value);

}  // namespace palp
