// The one exception for what a user wrote or gave: each fault in one sentence, with file:line where there is a file.
#pragma once

#include <cstddef>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace palp {

// The number of bytes of the UTF-8 letter that the text begins with; 0 for a control character or what is no UTF-8.
inline std::size_t letter_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  if (byte(0) < 0x80) return byte(0) >= 0x20 && byte(0) != 0x7f ? 1 : 0;
  const std::size_t length = byte(0) >= 0xf5 ? 0 : byte(0) >= 0xf0 ? 4 : byte(0) >= 0xe0 ? 3 : byte(0) >= 0xc2 ? 2 : 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  return byte(0) == 0xc2 && byte(1) < 0xa0 ? 0 : length;
}

// The text as a terminal may show it: what is no letter stands as \xNN, its byte in hexadecimal.
inline std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = letter_length(text);
    if (length > 0) {
      out.append(text.substr(0, length));
    } else {
      char code[5];
      std::snprintf(code, sizeof code, "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(text[0])));
      out.append(code);
    }
    text.remove_prefix(length > 0 ? length : 1);
  }
  return out;
}

class ConfigError : public std::runtime_error {
 public:
  // Quoted parts of a file may hold any byte; the faults are printable.
  explicit ConfigError(const std::vector<std::string>& faults)
      : std::runtime_error(join(shown(faults))), faults_(shown(faults)) {}
  explicit ConfigError(const std::string& fault) : ConfigError(std::vector<std::string>{fault}) {}
  const std::vector<std::string>& faults() const { return faults_; }

 private:
  static std::vector<std::string> shown(const std::vector<std::string>& faults) {
    std::vector<std::string> out;
    out.reserve(faults.size());
    for (const std::string& fault : faults) out.push_back(printable(fault));
    return out;
  }
  static std::string join(const std::vector<std::string>& faults) {
    std::string text;
    for (const std::string& fault : faults) text += (text.empty() ? "" : "\n") + fault;
    return text;
  }
  std::vector<std::string> faults_;
};

}  // namespace palp
