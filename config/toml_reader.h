// Strict reading of TOML files. Every value is asked for with what it must be; whatever is wrong is remembered and
// reported all at once: file:line, what was found, what was expected. Keys that nobody asked for are faults too.
//
//   TomlFile file = TomlFile::read("tray.toml");
//   TomlTable scene = file.root().table("scene", Need::required);
//   double rate_hz = scene.number("rate_hz", {"Hz", 1, 1e5}).value_or(1000);
//   file.finish();  // throws ConfigError with all faults
//
// Not for real-time threads. One thread at a time per file.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace palp {

// The unit of a number and the bounds that it must keep. Non-finite numbers are always refused.
struct Range {
  const char* unit = "";  // "kg/m^3"; empty: a pure number
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above = false;  // min itself is refused
};

inline Range positive(const char* unit) { return {unit, 0, std::numeric_limits<double>::infinity(), true}; }
inline Range not_negative(const char* unit) { return {unit, 0, std::numeric_limits<double>::infinity(), false}; }

// Returns whether a number is finite and within the range.
bool is_in(double value, const Range& range);

// Returns words for a range: "a number in m from 1 to 2".
std::string describe(const Range& range);

enum class Need { optional, required };

struct TomlState;

// One table of a file. A copy names the same table. Of a table that is missing, every key is missing and none is a
// fault. Getters give nothing when the key is missing or faulty.
class TomlTable {
 public:
  bool exists() const { return node_ != nullptr; }
  bool has(std::string_view key) const;
  // Names this table in messages from here on: "body 'water'".
  void set_title(const std::string& title) { title_ = title; }
  const std::string& title() const { return title_; }

  std::optional<double> number(std::string_view key, const Range& range, Need need = Need::optional);
  std::optional<long long> integer(std::string_view key, long long min, long long max, Need need = Need::optional);
  std::optional<bool> boolean(std::string_view key, Need need = Need::optional);
  std::optional<std::string> text(std::string_view key, Need need = Need::optional);  // not empty
  std::vector<std::string> texts(std::string_view key);  // one text or an array of them; empty when there is none
  // Index of the text among the choices.
  std::optional<std::size_t> choice(std::string_view key, const std::vector<std::string>& choices,
                                    Need need = Need::optional);
  // An array of exactly `count` numbers.
  std::optional<std::vector<double>> numbers(std::string_view key, std::size_t count, const Range& range,
                                             Need need = Need::optional);
  std::optional<std::array<bool, 3>> booleans3(std::string_view key);
  std::optional<std::array<float, 3>> color(std::string_view key);  // "#rrggbb", as sRGB 0..1
  TomlTable table(std::string_view key, Need need = Need::optional);
  std::vector<TomlTable> tables(std::string_view key);  // [[key]]
  // A key that is either a number or a table.
  bool is_table(std::string_view key) const;

  // A fault at the key's line (an empty key: at the table's own line).
  void fault(std::string_view key, const std::string& text);
  std::string where(std::string_view key = {}) const;  // file:line

 private:
  friend class TomlFile;
  TomlTable(std::shared_ptr<TomlState> state, const void* node, std::string path, std::string title)
      : state_(std::move(state)), node_(node), path_(std::move(path)), title_(std::move(title)) {}
  void wrong(std::string_view key, const std::string& expected, Need need);
  std::string child_path(std::string_view key) const;

  std::shared_ptr<TomlState> state_;
  const void* node_ = nullptr;  // toml::table; void keeps toml++ out of this header
  std::string path_;            // "body.shape"
  std::string title_;
};

class TomlFile {
 public:
  // Throws ConfigError when the file cannot be read or is not TOML.
  static TomlFile read(const std::string& path);
  static TomlFile parse(const std::string& text, const std::string& path);

  // Replaces or adds a value: TABLE.KEY=VALUE, for keys of tables that occur once. It is then read and judged as if it
  // stood in the file, and messages name it as the option --set. Before root().
  void set(const std::string& setting);
  TomlTable root();
  const std::string& text() const;  // as read
  bool faulty() const;              // some fault was found so far
  // Adds a fault at a line, or (0) of the whole file.
  void fault(std::size_t line, const std::string& text);
  // Adds a fault for each key that was never asked for; throws ConfigError when there is any fault, in order of lines.
  void finish();
  // Every key ever asked for, as dotted paths ("body.shape.radius").
  const std::set<std::string>& asked() const;

 private:
  explicit TomlFile(std::shared_ptr<TomlState> state) : state_(std::move(state)) {}
  std::shared_ptr<TomlState> state_;
};

// The name nearest to `word`, when it is near enough to be a slip of the keyboard; else empty.
std::string nearest_name(std::string_view word, const std::vector<std::string>& names);

}  // namespace palp
