#include "viewer/parameter_list.h"

#include <array>
#include <optional>
#include <sstream>

#include <fmt/format.h>

#include "config/text_file.h"

namespace palp {
namespace {

constexpr std::size_t kMostParameters = 300, kMostNumbers = 3;

// Returns the parameter of a line, if it is one.
std::optional<ListedParameter> read_line(const std::string& line) {
  std::istringstream cells(line);
  std::array<std::string, 5> cell;
  for (std::string& c : cell) std::getline(cells, c, '\t');
  ListedParameter p;
  p.name = cell[0];
  p.unit = cell[2];
  const auto low = parse_number(cell[3]), high = parse_number(cell[4]);
  if (p.name.empty() || !low || !high || !(*low < *high)) return std::nullopt;
  p.low = *low;
  p.high = *high;
  std::istringstream words(cell[1]);
  for (std::string word; words >> word;) {
    const auto number = parse_number(word);
    if (!number || p.value.size() == kMostNumbers) return std::nullopt;
    p.value.push_back(*number);
  }
  return p;
}

}  // namespace

std::vector<ListedParameter> read_parameter_list(const std::string& text) {
  std::vector<ListedParameter> all;
  std::istringstream lines(text);
  for (std::string line; all.size() < kMostParameters && std::getline(lines, line);)
    if (auto parameter = read_line(line)) all.push_back(std::move(*parameter));
  return all;
}

std::string parameter_text(const std::vector<double>& value) {
  std::string text;
  for (const double number : value) text += fmt::format("{}{:.10g}", text.empty() ? "" : " ", number);
  return text;
}

}  // namespace palp
