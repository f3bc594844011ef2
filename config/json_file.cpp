#include "config/json_file.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace palp {

std::string json_text(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

void write_json(const std::string& path, const Json& json) {
  std::ofstream out(path);
  out << json_text(json);
  out.close();
  if (!out) throw std::runtime_error(path + ": cannot be written; check the folder and the space on the disk");
}

}  // namespace palp
