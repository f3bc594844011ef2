// The flight log of a bridge as a table: a row for each tick, its columns by their names.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace palp::test {

class FlightTable {
 public:
  explicit FlightTable(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line;
    if (!std::getline(in, line)) throw std::runtime_error("there is no flight log in " + file.string());
    const std::vector<std::string> names = cells_of(line);
    for (const std::string& name : names) columns_[name];
    while (std::getline(in, line)) {
      const std::vector<std::string> cells = cells_of(line);
      if (cells.size() != names.size()) throw std::runtime_error("a tick with another number of columns: " + line);
      for (std::size_t i = 0; i < cells.size(); ++i) columns_[names[i]].push_back(cells[i]);
    }
  }

  std::size_t ticks() const { return columns_.at("tick").size(); }
  const std::string& text(const std::string& column, std::size_t tick) const { return columns_.at(column).at(tick); }
  // Reads a number; std::stod would throw at a force that has faded below the smallest normal number.
  double number(const std::string& column, std::size_t tick) const {
    return std::strtod(text(column, tick).c_str(), nullptr);
  }
  std::int64_t t_ns(std::size_t tick) const { return std::stoll(text("t_ns", tick)); }
  // Returns the length of a vector, whose columns begin with its name.
  double length(const std::string& vector, std::size_t tick) const {
    return std::hypot(number(vector + "_x", tick), number(vector + "_y", tick), number(vector + "_z", tick));
  }
  // Returns force and torque of a tick, their lengths added up.
  double felt(std::size_t tick) const { return length("force", tick) + length("torque", tick); }

 private:
  static std::vector<std::string> cells_of(const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    return cells;
  }

  std::map<std::string, std::vector<std::string>> columns_;
};

}  // namespace palp::test
