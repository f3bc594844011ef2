// One line of the table: what was measured where, beside its reference and target.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/json_file.h"

namespace palp::bench {

struct Row {
  std::string metric, hand, link, variant;
  double rate_hz = 0;  // of the server
  double result = 0;
  std::string unit, reference, target;
  std::optional<bool> pass;  // unset: nothing to judge, as of a baseline
  std::string note;          // e.g. what failed first
};

std::string markdown(const std::vector<Row>& rows, const std::vector<std::string>& preface);
Json json_of(const std::vector<Row>& rows);

}  // namespace palp::bench
