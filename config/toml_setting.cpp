#include "config/toml_setting.h"

#include <fmt/format.h>

#include <memory>
#include <string_view>

namespace palp {

namespace {

constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_-0123456789";

bool is_bare_key(std::string_view word) {
  return !word.empty() && word.find_first_not_of(kLetters) == std::string_view::npos;
}

// Returns a table whose only key, `value`, is what the text means, or an empty one.
toml::table parse_value(const std::string& text) {
  if (text.find_first_of("\r\n") != std::string::npos) return {};
  try {
    return toml::parse("value = " + text);
  } catch (const toml::parse_error&) {
    return is_bare_key(text) ? toml::table{{"value", text}} : toml::table{};
  }
}

}  // namespace

std::string insert_setting(toml::table& root, const std::string& setting, std::uint32_t line) {
  const std::size_t equals = setting.find('=');
  std::string_view path = std::string_view(setting).substr(0, equals);
  if (equals == std::string::npos || path.find('.') == std::string_view::npos)
    return "expected TABLE.KEY=VALUE, such as numerics.safety=0.4";
  toml::table value = parse_value(setting.substr(equals + 1));
  if (value.empty()) return "the value is not valid TOML, expected a number, true, false, a text or an array";

  const toml::source_region here{{line, 1}, {line, 1}, std::make_shared<const std::string>()};
  toml::table* table = &root;
  for (std::size_t dot = path.find('.'); dot != std::string_view::npos; dot = path.find('.')) {
    const std::string_view name = path.substr(0, dot);
    path.remove_prefix(dot + 1);
    if (!is_bare_key(name)) return fmt::format("'{}' is no name of a table", name);
    if (!table->contains(name)) table->insert(toml::key(name, here), toml::table{});
    table = table->get(name)->as_table();
    if (!table) return fmt::format("{} is no table that occurs once in the file, expected a key of one", name);
  }
  if (!is_bare_key(path)) return fmt::format("'{}' is no name of a key", path);
  table->erase(path);  // an assignment would keep the line of the file
  table->insert(toml::key(path, here), std::move(*value.get("value")));
  return {};
}

}  // namespace palp
