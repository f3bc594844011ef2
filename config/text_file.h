// Reading whole files that a user gave, and their rows of numbers.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace palp {

// The whole file. Throws ConfigError when it is missing, not a plain file, or larger than max_bytes.
std::string read_text_file(const std::string& path, std::size_t max_bytes);

// A finite number that fills the text but for blanks around it; else nothing. Does not depend on the locale.
std::optional<double> parse_number(std::string_view text);

// `path` as seen from the folder of `file`; absolute paths stay.
std::string resolve_beside(const std::string& file, const std::string& path);

}  // namespace palp
