#include "sim_server/scene/scene_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <vector>

#include "config/error.h"
#include "config/toml_reader.h"

namespace palp {

namespace {

// An estimate, on the safe side: the scene, the state of the CPU back end and a snapshot, of one particle.
// cells.
constexpr std::size_t kBytesPerParticle = 600;

}  // namespace

std::string find_scene_file(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (fs::is_regular_file(name, ignored)) return name;
  std::vector<std::string> known;
  if (name.find('/') == std::string::npos) {
    for (const fs::path& folder : {fs::path("config") / "scenes", fs::path(PALP_SOURCE_DIR) / "config" / "scenes"}) {
      for (const std::string& file : {name, name + ".toml"}) {
        if (fs::is_regular_file(folder / file, ignored)) return (folder / file).string();
      }
      for (const auto& entry : fs::directory_iterator(folder, ignored)) {
        const bool scene = entry.path().extension() == ".toml";
        const std::string stem = entry.path().stem().string();
        if (scene && std::find(known.begin(), known.end(), stem) == known.end()) known.push_back(stem);
      }
    }
  }
  std::sort(known.begin(), known.end());
  std::string list;
  for (const std::string& scene : known) list += (list.empty() ? "" : ", ") + scene;
  const std::string near = nearest_name(name, known);
  throw ConfigError(fmt::format("{}: no such scene file{}{}", name,
                                list.empty() ? "" : ", expected a path or one of: " + list,
                                near.empty() ? "" : "; did you mean '" + near + "'?"));
}

std::size_t particles_in_memory() {
  std::ifstream info("/proc/meminfo");
  std::string key;
  std::size_t kilobytes = 0;
  while (info >> key) {
    if (key == "MemAvailable:" && info >> kilobytes) break;
    info.ignore(1000, '\n');
  }
  constexpr std::size_t kUnknown = std::size_t{4} << 20;  // 4 GiB, in kB, where the system does not say
  return (kilobytes > 0 ? kilobytes : kUnknown) * 1024 / 4 * 3 / kBytesPerParticle;
}

}  // namespace palp
