// One line of the table: what was measured where, beside its reference and target.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/json_file.h"
#include "haptic_bridge/log/output_file.h"

namespace palp::bench {

struct Row {
  std::string metric, hand, link, variant;
  double rate_hz = 0;  // of the server
  double result = 0;
  std::string unit, reference, target;
  std::optional<bool> pass;  // unset: nothing to judge, as of a baseline
  std::string note;          // e.g. what failed first
  std::size_t job = 0;       // by which rows of several parts are put in order
};

std::string markdown(const std::vector<Row>& rows, const std::vector<std::string>& preface);
Json json_of(const std::vector<Row>& rows);
// Reads the rows of a file as json_of made it. Throws what the JSON library throws where it is another.
std::vector<Row> rows_from(const Json& list);

// Replaces the file, or leaves it as it was. Throws std::runtime_error with one sentence.
void write_text(const std::string& what, const std::string& path, const std::string& text);

// Reserves room before hours of measuring, to find out whether the results can be written where they are to go. Empty
// paths are skipped. Throws as write_text.
class RoomForResults {
 public:
  explicit RoomForResults(const std::vector<std::string>& paths);

 private:
  std::vector<std::unique_ptr<ReservedRoom>> rooms_;
};

}  // namespace palp::bench
