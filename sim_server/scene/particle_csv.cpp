#include "sim_server/scene/particle_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "config/error.h"
#include "config/text_file.h"

namespace palp {

namespace {

constexpr std::size_t kMaxCsvBytes = std::size_t{4} << 30;
constexpr std::array<std::string_view, 8> kColumns{"x", "y", "z", "vx", "vy", "vz", "temperature", "volume"};
constexpr std::size_t kAbsent = 1000;
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // that spreadsheets put before UTF-8

struct ColumnRange {
  double low, high;
};

// Which numbers a column may have. A particle of quite another size than the rest has no neighbours to speak of.
ColumnRange range_of(std::size_t column, double default_volume) {
  if (column == 6) return {0, 1e5};
  if (column == 7) return {1e-3 * default_volume, 1e3 * default_volume};
  return {-1e9, 1e9};
}

std::string expected_of(std::size_t column, double default_volume) {
  const auto [low, high] = range_of(column, default_volume);
  if (column == 6) return fmt::format("a number in K from {:g} to {:g}", low, high);
  if (column == 7) {
    return fmt::format("a number in m^3 from {:g} to {:g}, a thousandth to a thousand times the spacing cubed", low,
                       high);
  }
  return fmt::format("a number from {:g} to {:g}", low, high);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    std::string_view cell = line.substr(0, comma);
    const std::size_t first = std::min(cell.find_first_not_of(" \t\r"), cell.size());
    cell.remove_prefix(first);
    cell = cell.substr(0, cell.find_last_not_of(" \t\r") + 1);
    cells.push_back(cell);
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

// Where each of kColumns stands in a row.
std::array<std::size_t, 8> read_header(std::string_view line, const std::string& where) {
  std::array<std::size_t, 8> column;
  column.fill(kAbsent);
  const auto names = split(line);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = std::find(kColumns.begin(), kColumns.end(), names[i]);
    if (found == kColumns.end()) {
      throw ConfigError(
          fmt::format("{}: unknown column '{}', expected columns x,y,z and if wanted vx,vy,vz,temperature,volume",
                      where, names[i].substr(0, 40)));
    }
    std::size_t& at = column[static_cast<std::size_t>(found - kColumns.begin())];
    if (at != kAbsent) throw ConfigError(fmt::format("{}: column '{}' stands twice", where, names[i]));
    at = i;
  }
  const auto has = [&](std::size_t c) { return column[c] != kAbsent; };
  if (!has(0) || !has(1) || !has(2)) throw ConfigError(where + ": columns x, y and z are needed");
  if (has(3) != has(4) || has(4) != has(5)) throw ConfigError(where + ": expected all of vx, vy and vz, or none");
  return column;
}

}  // namespace

Particles parse_particle_csv(std::string_view text, const std::string& path, double default_volume,
                             std::size_t max_particles) {
  Particles out;
  std::array<std::size_t, 8> column{};
  std::size_t columns = 0;
  if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) text.remove_prefix(kByteOrderMark.size());
  for (std::size_t line_number = 1; !text.empty(); ++line_number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.find_first_not_of(" \t\r") == std::string_view::npos || line[0] == '#') continue;
    const auto where = [&] { return fmt::format("{}:{}", path, line_number); };
    if (columns == 0) {
      column = read_header(line, where());
      columns = split(line).size();
      continue;
    }
    const auto cells = split(line);
    if (cells.size() != columns) {
      throw ConfigError(
          fmt::format("{}: the row has {} cells, expected {} as in the header", where(), cells.size(), columns));
    }
    std::array<double, 8> value{};
    for (std::size_t c = 0; c < kColumns.size(); ++c) {
      if (column[c] == kAbsent) continue;
      const auto number = parse_number(cells[column[c]]);
      const auto [low, high] = range_of(c, default_volume);
      if (!number || *number < low || *number > high) {
        throw ConfigError(fmt::format("{}: {} is '{}', expected {}", where(), kColumns[c],
                                      cells[column[c]].substr(0, 40), expected_of(c, default_volume)));
      }
      value[c] = *number;
    }
    if (out.position.size() == max_particles) {
      throw ConfigError(
          fmt::format("{}: more than {} particles, which is what memory here allows", where(), max_particles));
    }
    out.position.emplace_back(value[0], value[1], value[2]);
    if (column[3] != kAbsent) out.velocity.emplace_back(value[3], value[4], value[5]);
    if (column[6] != kAbsent) out.temperature.push_back(value[6]);
    out.volume.push_back(column[7] != kAbsent ? value[7] : default_volume);
  }
  if (columns == 0) throw ConfigError(path + ": the file is empty, expected a header x,y,z,... and rows of numbers");
  if (out.position.empty()) throw ConfigError(path + ": no particle after the header");
  return out;
}

Particles read_particle_csv(const std::string& path, double default_volume, std::size_t max_particles) {
  return parse_particle_csv(read_text_file(path, kMaxCsvBytes), path, default_volume, max_particles);
}

}  // namespace palp
