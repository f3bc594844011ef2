// The summary that a viewer leaves at its end.
#pragma once

#include <exception>
#include <nlohmann/json.hpp>
#include <string>

#include <spdlog/spdlog.h>

#include "config/json_file.h"

namespace palp {

// Returns false if the file cannot be written, and says so. No file: nothing is written.
inline bool write_summary(const std::string& file, const Json& summary) {
  if (file.empty()) return true;
  try {
    write_json(file, summary);
    return true;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return false;
  }
}

}  // namespace palp
