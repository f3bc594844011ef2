#include "config/toml_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "config/error.h"
#include "config/text_file.h"
#include "config/toml_library.h"
#include "config/toml_setting.h"

namespace palp {

struct TomlState {
  struct Fault {
    std::size_t line;
    std::string text;
  };
  std::string path;
  std::string text;
  toml::table root;
  std::vector<std::string> settings;  // their keys stand in lines from kFirstSetting on
  std::vector<Fault> faults;
  std::map<const void*, std::set<std::string, std::less<>>> used;  // by table: keys asked for
  std::set<std::string> asked;
};

namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{16} << 20;
constexpr std::size_t kFirstSetting = 1u << 30;  // no file that is read has so many lines

// Where a line stands, for messages: in the file, or as an option on the command line.
std::string place_of(const TomlState& state, std::size_t line) {
  if (line >= kFirstSetting) return "--set " + state.settings.at(line - kFirstSetting);
  return line > 0 ? fmt::format("{}:{}", state.path, line) : state.path;
}

const toml::table& as_table(const void* node) { return *static_cast<const toml::table*>(node); }

std::string describe(const toml::node& node) {
  if (const auto* value = node.as_string()) {
    const std::string text = value->get();
    return "\"" + (text.size() > 40 ? text.substr(0, 40) + "..." : text) + "\"";
  }
  if (const auto* value = node.as_integer()) return fmt::format("{}", value->get());
  if (const auto* value = node.as_floating_point()) return fmt::format("{}", value->get());
  if (const auto* value = node.as_boolean()) return value->get() ? "true" : "false";
  if (const auto* value = node.as_array()) return fmt::format("an array of {}", value->size());
  if (node.is_table()) return "a table";
  return "a date or time";
}

}  // namespace

bool is_in(double value, const Range& range) {
  return std::isfinite(value) && value <= range.max && (range.above ? value > range.min : value >= range.min);
}

std::string describe(const Range& range) {
  std::string text = "a number";
  if (range.unit[0] != '\0') text += fmt::format(" in {}", range.unit);
  const bool low = std::isfinite(range.min), high = std::isfinite(range.max);
  if (range.above && high) return text + fmt::format(" above {} and at most {}", range.min, range.max);
  if (range.above) return text + fmt::format(" above {}", range.min);
  if (low && high) return text + fmt::format(" from {} to {}", range.min, range.max);
  if (low) return text + fmt::format(" of at least {}", range.min);
  if (high) return text + fmt::format(" of at most {}", range.max);
  return text;
}

namespace {

std::optional<double> number_in(const toml::node& node, const Range& range) {
  if (!node.is_integer() && !node.is_floating_point()) return {};
  const double value = *node.value<double>();
  if (!is_in(value, range)) return {};
  return value;
}

// Optimal string alignment distance: insertions, deletions, substitutions and swaps of neighbours.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// Reports the keys of `table` that nobody asked for, then looks into the tables below those that were.
void report_unknown(TomlState& state, const toml::table& table, const std::string& path) {
  const auto found = state.used.find(&table);
  if (found == state.used.end()) return;  // never opened: its parent's getter has already found a fault
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (found->second.count(name) == 0) {
      const std::vector<std::string> known(found->second.begin(), found->second.end());
      const std::string near = nearest_name(name, known);
      const std::string in = path.empty() ? "" : fmt::format(" in [{}]", path);
      const std::string hint =
          near.empty() ? fmt::format("expected one of: {}", joined(known)) : fmt::format("did you mean '{}'?", near);
      state.faults.push_back({key.source().begin.line, fmt::format("unknown key '{}'{}, {}", name, in, hint)});
      continue;
    }
    const std::string child = path.empty() ? name : path + "." + name;
    if (const auto* sub = node.as_table()) report_unknown(state, *sub, child);
    if (const auto* array = node.as_array()) {
      for (const toml::node& item : *array) {
        if (const auto* sub = item.as_table()) report_unknown(state, *sub, child);
      }
    }
  }
}

}  // namespace

std::string nearest_name(std::string_view word, const std::vector<std::string>& names) {
  if (word.size() > 64) return {};
  std::string best;
  std::size_t best_distance = word.size() <= 3 ? 2 : 3;  // anything nearer counts
  for (const std::string& name : names) {
    const std::size_t distance = edit_distance(word, name);
    if (distance < best_distance && distance < name.size()) {
      best_distance = distance;
      best = name;
    }
  }
  return best;
}

bool TomlTable::has(std::string_view key) const {
  if (!node_) return false;
  const std::string path = child_path(key);
  state_->used[node_].emplace(key);
  state_->asked.insert(path);
  return as_table(node_).contains(key);
}

std::string TomlTable::child_path(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

namespace {

std::size_t line_of(const toml::table& table, std::string_view key) {
  if (!key.empty()) {
    for (const auto& [name, node] : table) {
      if (name.str() == key) return name.source().begin.line;
    }
  }
  return table.source().begin.line;
}

}  // namespace

std::string TomlTable::where(std::string_view key) const {
  if (!node_) return state_->path;
  return place_of(*state_, std::max<std::size_t>(1, line_of(as_table(node_), key)));
}

void TomlTable::fault(std::string_view key, const std::string& text) {
  const std::size_t line = node_ ? line_of(as_table(node_), key) : 0;
  state_->faults.push_back({line, title_.empty() ? text : title_ + ": " + text});
}

// The key is missing, or present and not what was expected.
void TomlTable::wrong(std::string_view key, const std::string& expected, Need need) {
  if (!node_) return;
  const toml::node* node = as_table(node_).get(key);
  if (node) {
    fault(key, fmt::format("{} is {}, expected {}", key, describe(*node), expected));
  } else if (need == Need::required) {
    fault("", fmt::format("{} is missing, expected {}", key, expected));
  }
}

std::optional<double> TomlTable::number(std::string_view key, const Range& range, Need need) {
  if (has(key)) {
    if (const auto value = number_in(*as_table(node_).get(key), range)) return value;
  }
  wrong(key, describe(range), need);
  return {};
}

std::optional<long long> TomlTable::integer(std::string_view key, long long min, long long max, Need need) {
  if (has(key)) {
    const auto* value = as_table(node_).get(key)->as_integer();
    if (value && value->get() >= min && value->get() <= max) return value->get();
  }
  wrong(key, fmt::format("a whole number from {} to {}", min, max), need);
  return {};
}

std::optional<bool> TomlTable::boolean(std::string_view key, Need need) {
  if (has(key)) {
    if (const auto* value = as_table(node_).get(key)->as_boolean()) return value->get();
  }
  wrong(key, "true or false", need);
  return {};
}

std::optional<std::string> TomlTable::text(std::string_view key, Need need) {
  if (has(key)) {
    const auto* value = as_table(node_).get(key)->as_string();
    if (value && !value->get().empty()) return value->get();
  }
  wrong(key, "a text in quotes, not empty", need);
  return {};
}

std::optional<std::size_t> TomlTable::choice(std::string_view key, const std::vector<std::string>& choices, Need need) {
  std::string near;
  if (has(key)) {
    if (const auto* value = as_table(node_).get(key)->as_string()) {
      const auto found = std::find(choices.begin(), choices.end(), value->get());
      if (found != choices.end()) return static_cast<std::size_t>(found - choices.begin());
      near = nearest_name(value->get(), choices);
    }
  }
  wrong(key, fmt::format("one of: {}{}", joined(choices), near.empty() ? "" : "; did you mean '" + near + "'?"), need);
  return {};
}

std::optional<std::vector<double>> TomlTable::numbers(std::string_view key, std::size_t count, const Range& range,
                                                      Need need) {
  const std::string expected = fmt::format("an array of {} numbers, each {}", count, describe(range));
  if (has(key)) {
    const auto* array = as_table(node_).get(key)->as_array();
    if (array && array->size() == count) {
      std::vector<double> values;
      for (std::size_t i = 0; i < count; ++i) {
        const auto value = number_in(*array->get(i), range);
        if (value) {
          values.push_back(*value);
        } else {
          fault(key, fmt::format("{}[{}] is {}, expected {}", key, i, describe(*array->get(i)), describe(range)));
        }
      }
      if (values.size() < count) return {};
      return values;
    }
  }
  wrong(key, expected, need);
  return {};
}

std::vector<std::string> TomlTable::texts(std::string_view key) {
  if (!has(key)) return {};
  const toml::node& node = *as_table(node_).get(key);
  std::vector<std::string> values;
  if (const auto* one = node.as_string()) {
    values.push_back(one->get());
  } else if (const auto* array = node.as_array(); array && array->is_homogeneous<std::string>()) {
    for (const toml::node& item : *array) values.push_back(item.as_string()->get());
  } else {
    wrong(key, "a text or an array of texts", Need::optional);
  }
  return values;
}

std::optional<std::array<bool, 3>> TomlTable::booleans3(std::string_view key) {
  if (has(key)) {
    const auto* array = as_table(node_).get(key)->as_array();
    if (array && array->size() == 3 && array->is_homogeneous<bool>()) {
      return std::array<bool, 3>{*array->get(0)->value<bool>(), *array->get(1)->value<bool>(),
                                 *array->get(2)->value<bool>()};
    }
  }
  wrong(key, "an array of 3 of true or false, for x, y, z", Need::optional);
  return {};
}

std::optional<std::array<float, 3>> TomlTable::color(std::string_view key) {
  if (has(key)) {
    const auto* value = as_table(node_).get(key)->as_string();
    const std::string text = value ? value->get() : "";
    if (text.size() == 7 && text[0] == '#' &&
        text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos) {
      const unsigned long rgb = std::stoul(text.substr(1), nullptr, 16);
      return std::array<float, 3>{static_cast<float>(rgb >> 16 & 255) / 255, static_cast<float>(rgb >> 8 & 255) / 255,
                                  static_cast<float>(rgb & 255) / 255};
    }
  }
  wrong(key, "a colour as \"#rrggbb\"", Need::optional);
  return {};
}

bool TomlTable::is_table(std::string_view key) const { return has(key) && as_table(node_).get(key)->is_table(); }

TomlTable TomlTable::table(std::string_view key, Need need) {
  const std::string path = child_path(key);
  if (has(key)) {
    if (const auto* sub = as_table(node_).get(key)->as_table()) {
      state_->used[sub];
      return {state_, sub, path, title_.empty() ? "[" + path + "]" : title_ + ": [" + path + "]"};
    }
  }
  wrong(key, fmt::format("a table [{}]", path), need);
  return {state_, nullptr, path, "[" + path + "]"};
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) {
  std::vector<TomlTable> out;
  const std::string path = child_path(key);
  if (!has(key)) return out;
  const auto add = [&](const toml::table& item) {
    state_->used[&item];
    const std::string number = fmt::format("{} {}", key, out.size() + 1);
    out.push_back({state_, &item, path, title_.empty() ? number : title_ + ": " + number});
  };
  const toml::node& node = *as_table(node_).get(key);
  const auto* array = node.as_array();
  const bool all = array && std::all_of(array->begin(), array->end(), [](const auto& item) { return item.is_table(); });
  if (!all) wrong(key, fmt::format("tables, each under a line [[{}]]", path), Need::optional);
  // what tables there are is read all the same: their faults are to be heard of, too
  if (const auto* table = node.as_table()) add(*table);
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    if (const auto* table = array->get(i)->as_table()) add(*table);
  }
  return out;
}

TomlFile TomlFile::read(const std::string& path) { return parse(read_text_file(path, kMaxFileBytes), path); }

TomlFile TomlFile::parse(const std::string& text, const std::string& path) {
  auto state = std::make_shared<TomlState>();
  state->path = path;
  state->text = text;
  try {
    state->root = toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    throw ConfigError(fmt::format("{}:{}: not valid TOML: {} (column {})", path, error.source().begin.line,
                                  error.description(), error.source().begin.column));
  }
  return TomlFile(std::move(state));
}

void TomlFile::set(const std::string& setting) {
  const std::size_t line = kFirstSetting + state_->settings.size();
  state_->settings.push_back(setting);
  const std::string wrong = insert_setting(state_->root, setting, static_cast<std::uint32_t>(line));
  if (!wrong.empty()) fault(line, wrong);
}

TomlTable TomlFile::root() {
  state_->used[&state_->root];
  return {state_, &state_->root, "", ""};
}

const std::string& TomlFile::text() const { return state_->text; }
bool TomlFile::faulty() const { return !state_->faults.empty(); }
const std::set<std::string>& TomlFile::asked() const { return state_->asked; }

void TomlFile::fault(std::size_t line, const std::string& text) { state_->faults.push_back({line, text}); }

void TomlFile::finish() {
  report_unknown(*state_, state_->root, "");
  if (state_->faults.empty()) return;
  std::stable_sort(state_->faults.begin(), state_->faults.end(),
                   [](const auto& a, const auto& b) { return a.line < b.line; });
  // a table that is read twice is wrong once
  std::set<std::pair<std::size_t, std::string>> told;
  std::vector<std::string> texts;
  for (const auto& [line, text] : state_->faults) {
    if (!told.emplace(line, text).second) continue;
    texts.push_back(fmt::format("{}: {}", place_of(*state_, line), text));
  }
  throw ConfigError(texts);
}

}  // namespace palp
