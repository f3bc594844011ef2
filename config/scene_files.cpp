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

// Makes a path of the name of a hand.
void find_hand(TomlTable& table, const std::string& scene, std::string& hand) {
  std::error_code ignored;
  if (hand.empty()) return;
  if (is_path(hand)) {
    hand = resolve_beside(scene, hand);
    if (!fs::is_regular_file(hand, ignored)) table.fault("hand", fmt::format("hand '{}': no such file", hand));
    return;
  }
  const std::vector<fs::path> folders = hand_folders(scene);
  const auto found = std::find_if(folders.begin(), folders.end(), [&](const fs::path& folder) {
    return fs::is_regular_file(folder / (hand + ".toml"), ignored);
  });
  if (found == folders.end()) {
    table.fault("hand", fault_of_name(hand, folders));
  } else {
    hand = (*found / (hand + ".toml")).string();
  }
}

// Sampling reads the files of shapes; that one is missing is said already with the faults of the scene.
void check_shapes(TomlTable& table, const BodyConfig& body) {
  std::error_code ignored;
  if (!body.name.empty()) table.set_title(fmt::format("body '{}'", body.name));
  std::vector<TomlTable> shapes = table.tables("shape");
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    const std::string& file = body.shapes[s].file;
    if (!file.empty() && !fs::exists(file, ignored)) shapes[s].fault("file", fmt::format("{}: no such file", file));
  }
}

}  // namespace

void find_files(TomlTable& root, SceneConfig& scene) {
  std::vector<TomlTable> bodies = root.tables("body"), proxies = root.tables("proxy");
  for (std::size_t b = 0; b < bodies.size(); ++b) check_shapes(bodies[b], scene.bodies[b]);
  for (std::size_t i = 0; i < proxies.size(); ++i) find_hand(proxies[i], scene.path, scene.proxies[i].hand);
}

}  // namespace palp
