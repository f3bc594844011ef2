// One table of the numbers of a scene that may be anything within a range: what the file and a command at run time may
// say is the same. No knowledge of who uses a number.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/toml_reader.h"

namespace palp {

struct ParameterRow {
  const char* key;  // "numerics.safety"; that of a material is "material.viscosity" for all of them
  Range range;      // of each number
  int count;        // of numbers: 1, or 3 of a vector
  bool while_running;
  const char* reason;  // for the bounds
};

// Returns all rows, in the order of a scene file.
const std::vector<ParameterRow>& parameter_rows();

// Returns the row of a key as the table has it. Throws std::logic_error when there is none.
const ParameterRow& parameter_row(std::string_view key);
inline const Range& range_of(std::string_view key) { return parameter_row(key).range; }

// A parameter that can be changed while a simulation runs, as commands name it: "material.NAME.viscosity" for each
// material.
struct ChangeableParameter {
  std::string name;
  const ParameterRow* row;
};
std::vector<ChangeableParameter> changeable_parameters(const std::vector<std::string>& materials);

// Returns the numbers of a command's value, which blanks separate. Throws ConfigError when they are not as many as the
// row says or one is out of range.
std::vector<double> parse_parameter(const ParameterRow& row, const std::string& name, const std::string& value);

}  // namespace palp
