#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "config/data_dir.h"
#include "config/scene_reader.h"
#include "config/text_file.h"

namespace palp {

namespace {

namespace fs = std::filesystem;

bool is_path(const std::string& hand) {
  return hand.find('/') != std::string::npos || fs::path(hand).extension() == ".toml";
}

// Folders of hand scripts, the one that belongs to the scene first.
std::vector<fs::path> hand_folders(const std::string& scene) {
  std::vector<fs::path> folders = data_folders(kHandFiles);
  folders.insert(folders.begin(), resolve_beside(scene, "../hands"));
  return folders;
}

std::string fault_of_name(const std::string& hand, const std::vector<fs::path>& folders) {
  const std::vector<std::string> known = names_in(folders);
  const std::string near = nearest_name(hand, known);
  return fmt::format("hand '{}' is no hand script, expected a path from the scene's folder{}{}{}", hand,
                     known.empty() ? "" : " or one of: ", fmt::join(known, ", "),
                     near.empty() ? "" : "; did you mean '" + near + "'?");
}

}  // namespace

void find_hands(TomlTable& root, SceneConfig& scene) {
  std::error_code ignored;
  std::vector<TomlTable> tables = root.tables("proxy");
  for (std::size_t i = 0; i < tables.size(); ++i) {
    std::string& hand = scene.proxies[i].hand;
    if (hand.empty()) continue;
    if (is_path(hand)) {
      const std::string file = resolve_beside(scene.path, hand);
      if (!fs::is_regular_file(file, ignored)) tables[i].fault("hand", fmt::format("hand '{}': no such file", file));
      hand = file;
      continue;
    }
    const std::vector<fs::path> folders = hand_folders(scene.path);
    const auto found = std::find_if(folders.begin(), folders.end(), [&](const fs::path& folder) {
      return fs::is_regular_file(folder / (hand + ".toml"), ignored);
    });
    if (found == folders.end()) {
      tables[i].fault("hand", fault_of_name(hand, folders));
    } else {
      hand = (*found / (hand + ".toml")).string();
    }
  }
}

}  // namespace palp
