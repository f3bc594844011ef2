// Numbers on a command line.
#pragma once

#include <sstream>
#include <string>

#include <CLI/CLI.hpp>

namespace palp {

// A finite number from low to high. CLI::Range lets "nan" through: nothing is less than it.
inline CLI::Validator number_between(double low, double high) {
  CLI::Validator validator = CLI::Range(low, high);  // for what --help says
  validator.operation([low, high](std::string& text) {
    double value = 0;
    if (CLI::detail::lexical_cast(text, value) && value >= low && value <= high) return std::string();
    std::ostringstream fault;
    fault << "expected a number from " << low << " to " << high << ", got '" << text << "'";
    return fault.str();
  });
  return validator;
}

}  // namespace palp
