#include "tools/haptic_bench/results.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace palp::bench {

std::string markdown(const std::vector<Row>& rows, const std::vector<std::string>& preface) {
  std::string text;
  for (const std::string& line : preface) text += line + "\n\n";
  text += "| metric | hand | server | link | rendered | result | reference | target | | note |\n";
  text += "|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Row& r : rows)
    text += fmt::format("| {} | {} | {:.0f} Hz | {} | {} | {:.3g} {} | {} | {} | {} | {} |\n", r.metric, r.hand,
                        r.rate_hz, r.link, r.variant, r.result, r.unit, r.reference, r.target,
                        r.pass ? (*r.pass ? "pass" : "**FAIL**") : "", r.note);
  return text;
}

Json json_of(const std::vector<Row>& rows) {
  Json list = Json::array();
  for (const Row& r : rows) {
    Json row{{"metric", r.metric},   {"hand", r.hand},     {"rate_hz", r.rate_hz}, {"link", r.link},
             {"variant", r.variant}, {"result", r.result}, {"unit", r.unit},       {"reference", r.reference},
             {"target", r.target},   {"note", r.note},     {"job", r.job}};
    if (r.pass) row["pass"] = *r.pass;
    list.push_back(row);
  }
  return list;
}

std::vector<Row> rows_from(const Json& list) {
  std::vector<Row> rows;
  for (const Json& j : list) {
    Row r;
    for (const auto& [key, text] : {std::pair{"metric", &r.metric},
                                    {"hand", &r.hand},
                                    {"link", &r.link},
                                    {"variant", &r.variant},
                                    {"unit", &r.unit},
                                    {"reference", &r.reference},
                                    {"target", &r.target},
                                    {"note", &r.note}})
      *text = j.at(key).get<std::string>();
    r.rate_hz = j.at("rate_hz").get<double>();
    const Json& result = j.at("result");
    r.result = result.is_null() ? std::numeric_limits<double>::quiet_NaN() : result.get<double>();
    r.job = j.at("job").get<std::size_t>();
    if (j.contains("pass")) r.pass = j.at("pass").get<bool>();
    rows.push_back(r);
  }
  return rows;
}

void write_text(const std::string& what, const std::string& path, const std::string& text) {
  write_whole_file(what, path, [&](OutputFile& file) {
    fmt::memory_buffer bytes;
    bytes.append(text);
    file.write(bytes);
  });
}

RoomForResults::RoomForResults(const std::vector<std::string>& paths) {
  constexpr std::size_t kMostBytes = std::size_t{4} << 20;
  for (const std::string& path : paths)
    if (!path.empty()) rooms_.push_back(std::make_unique<ReservedRoom>("results", path, kMostBytes));
}

}  // namespace palp::bench
