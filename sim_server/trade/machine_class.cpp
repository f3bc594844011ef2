#include "sim_server/trade/machine_class.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>

#include "config/data_dir.h"
#include "config/error.h"
#include "sim_server/solver/make_simulation.h"
#include "sim_server/threads/thread_team.h"

namespace palp {

namespace {

namespace fs = std::filesystem;

// Returns the number of processors of a class "cpu-N"; nothing of a GPU's.
std::optional<int> processors_of(const std::string& machine) {
  const std::string kind = "cpu-";
  int count = 0;
  if (machine.rfind(kind, 0) != 0) return std::nullopt;
  const char* end = machine.data() + machine.size();
  const auto [stop, error] = std::from_chars(machine.data() + kind.size(), end, count);
  return error == std::errc() && stop == end && count > 0 ? std::optional<int>(count) : std::nullopt;
}

// How unlike two classes are: nothing for the same, most for those of other kinds.
double distance(const std::string& a, const std::string& b) {
  if (a == b) return 0;
  const std::optional<int> of_a = processors_of(a), of_b = processors_of(b);
  if (of_a && of_b) return 1e-3 + std::abs(std::log(static_cast<double>(*of_a) / *of_b));
  return of_a.has_value() == of_b.has_value() ? 100 : 1000;
}

}  // namespace

std::string short_gpu_name(const std::string& name) {
  std::istringstream words(name);
  std::string text;
  for (std::string word; words >> word;) {
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
    if (word == "nvidia" || word == "geforce" || word == "tesla" || word == "quadro") continue;
    const std::string model = word.substr(0, word.find('-'));  // "a100-sxm4-80gb"
    text += (text.empty() ? "" : "-") + model;
    if (std::any_of(model.begin(), model.end(), [](unsigned char c) { return std::isdigit(c) != 0; })) break;
  }
  return text.empty() ? "gpu" : text;
}

std::string machine_class(Backend backend) {
  const bool gpu = backend == Backend::cuda || (backend == Backend::automatic && cuda_unavailable().empty());
  return gpu ? short_gpu_name(cuda_device_name()) : fmt::format("cpu-{}", usable_processors());
}

std::string nearest_class(const std::string& machine, const std::vector<std::string>& classes) {
  const auto nearest = std::min_element(classes.begin(), classes.end(), [&](const auto& a, const auto& b) {
    return distance(machine, a) < distance(machine, b);
  });
  return nearest == classes.end() ? "" : *nearest;
}

std::string find_trade_table(const std::string& machine) {
  std::map<std::string, std::string> files;  // by class; those of the folder that one is in come before palp's own
  for (const fs::path& folder : data_folders(kTradeTables)) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored))
      if (entry.path().extension() == ".json") files.emplace(entry.path().stem().string(), entry.path().string());
  }
  std::vector<std::string> classes;
  for (const auto& [name, file] : files) classes.push_back(name);
  const std::string nearest = nearest_class(machine, classes);
  if (nearest.empty())
    throw ConfigError(
        "there is no table of what numerics cost and err (config/trade/CLASS.json): give --accuracy or --spacing "
        "instead, or measure one with tools/tradeoff --all");
  return files.at(nearest);
}

}  // namespace palp
