// The one exception for what a user wrote or gave: each fault in one sentence, with file:line where there is a file.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace palp {

class ConfigError : public std::runtime_error {
 public:
  explicit ConfigError(std::vector<std::string> faults)
      : std::runtime_error(join(faults)), faults_(std::move(faults)) {}
  explicit ConfigError(const std::string& fault) : ConfigError(std::vector<std::string>{fault}) {}
  const std::vector<std::string>& faults() const { return faults_; }

 private:
  static std::string join(const std::vector<std::string>& faults) {
    std::string text;
    for (const std::string& fault : faults) text += (text.empty() ? "" : "\n") + fault;
    return text;
  }
  std::vector<std::string> faults_;
};

}  // namespace palp
