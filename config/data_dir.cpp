#include "config/data_dir.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "config/error.h"
#include "config/toml_reader.h"

namespace palp {

namespace {

namespace fs = std::filesystem;

// The folder that the running program's bin lies in; empty where the system does not say.
fs::path program_prefix() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program.parent_path().parent_path();
}

std::string environment_value(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

// Prefixes whose share/ holds data of programs that lie elsewhere, by the XDG base directory specification.
std::vector<fs::path> shared_data() {
  const std::string listed = environment_value("XDG_DATA_DIRS");
  std::istringstream in(listed.empty() ? "/usr/local/share:/usr/share" : listed);
  std::vector<fs::path> folders;
  for (std::string folder; std::getline(in, folder, ':');) folders.push_back(fs::path(folder) / "palp");
  return folders;
}

bool holds_data(const fs::path& folder) {
  std::error_code ignored;
  return folder.is_absolute() && fs::is_directory(folder / kSceneFiles.folder, ignored);
}

}  // namespace

fs::path data_dir() {
  if (const std::string given = environment_value("PALP_DATA_DIR"); !given.empty()) {
    std::error_code ignored;
    if (!fs::is_directory(given, ignored))
      throw ConfigError(fmt::format("PALP_DATA_DIR={}: no such folder; it must hold scenes, hands and devices", given));
    return given;
  }
  const fs::path prefix = program_prefix();
  // a build folder lies two below the source tree: build/release/bin
  std::vector<fs::path> folders{prefix / "share/palp", prefix.parent_path().parent_path() / "config"};
  for (const fs::path& folder : shared_data()) folders.push_back(folder);
  const auto found = std::find_if(folders.begin(), folders.end(), holds_data);
  return found == folders.end() ? fs::path() : *found;
}

std::vector<fs::path> data_folders(const DataKind& kind) {
  std::vector<fs::path> folders{fs::path("config") / kind.folder};
  if (const fs::path own = data_dir(); !own.empty()) folders.push_back(own / kind.folder);
  return folders;
}

std::vector<std::string> names_in(const std::vector<fs::path>& folders) {
  std::error_code ignored;
  std::vector<std::string> names;
  for (const fs::path& folder : folders) {
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

std::string find_data_file(const DataKind& kind, const std::string& name) {
  std::error_code ignored;
  if (fs::is_regular_file(name, ignored)) return name;
  std::vector<std::string> known;
  if (name.find('/') == std::string::npos) {
    const std::vector<fs::path> folders = data_folders(kind);
    for (const fs::path& folder : folders) {
      for (const std::string& file : {name, name + ".toml"}) {
        if (fs::is_regular_file(folder / file, ignored)) return (folder / file).string();
      }
    }
    known = names_in(folders);
  }
  const std::string near = nearest_name(name, known);
  throw ConfigError(fmt::format("{}: no such {}{}{}{}", name, kind.noun,
                                known.empty() ? "" : ", expected a path or one of: ", fmt::join(known, ", "),
                                near.empty() ? "" : "; did you mean '" + near + "'?"));
}

std::string find_own_library(const std::string& file) {
  std::error_code ignored;
  const fs::path prefix = program_prefix();
  for (const fs::path& folder : {prefix / "lib/palp", prefix / "lib"}) {
    if (fs::is_regular_file(folder / file, ignored)) return (folder / file).string();
  }
  return file;
}

}  // namespace palp
