// The hands that scenes name: they are found, and what is not found is said.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "config/error.h"
#include "config/scene_config.h"
#include "tests/support/files.h"

namespace palp::test::scene_hands_test {
namespace {

namespace fs = std::filesystem;

const fs::path kScenes = PALP_SOURCE_DIR "/config/scenes";

class SceneHands : public ::testing::Test {
 protected:
  SceneHands() { fs::create_directories(folder_ / "scenes"); }

  // A scene with one tool, whose hand is what the text says.
  std::string scene_with(const std::string& hand) {
    const std::string file = folder_ / "scenes/one.toml";
    std::ofstream(file) << "[scene]\n[domain]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n[numerics]\nspacing = 0.1\n"
                           "[[material]]\nname = \"steel\"\ndensity = 7800\n"
                           "[[body]]\nname = \"tool\"\ntype = \"rigid\"\nmaterial = \"steel\"\n"
                           "[[body.shape]]\ntype = \"sphere\"\nradius = 0.2\n[[proxy]]\nbody = \"tool\"\n"  // 18 lines
                        << hand;
    return file;
  }
  std::vector<std::string> faults_of(const std::string& hand) {
    try {
      load_scene(scene_with(hand));
    } catch (const ConfigError& error) {
      return error.faults();
    }
    return {};
  }
  void write(const std::string& name) {
    const fs::path file = folder_ / name;
    fs::create_directories(file.parent_path());
    write_text(file, "[[keyframe]]\ntime = 0\n");
  }
  std::string hand_of(const std::string& text) { return load_scene(scene_with(text)).proxies.at(0).hand; }

  const ScratchFolder folder_;
};

TEST_F(SceneHands, NoneIsNamed) { EXPECT_EQ(hand_of(""), ""); }

TEST_F(SceneHands, ANameIsOneOfPalpsHandsWhereverTheSceneLies) {
  EXPECT_TRUE(fs::equivalent(hand_of("hand = \"crepe_pan\"\n"), PALP_SOURCE_DIR "/config/hands/crepe_pan.toml"));
}

TEST_F(SceneHands, HandsBesideTheScenesFolderComeFirst) {
  write("hands/stir.toml");
  EXPECT_TRUE(fs::equivalent(hand_of("hand = \"stir\"\n"), folder_ / "hands/stir.toml"));
}

TEST_F(SceneHands, APathBeginsAtTheScenesFolder) {
  write("scenes/mine.toml");
  write("scenes/hands/mine.toml");
  EXPECT_TRUE(fs::equivalent(hand_of("hand = \"mine.toml\"\n"), folder_ / "scenes/mine.toml"));
  EXPECT_TRUE(fs::equivalent(hand_of("hand = \"hands/mine.toml\"\n"), folder_ / "scenes/hands/mine.toml"));
}

TEST_F(SceneHands, WhatIsNotThereIsAFaultAtItsLine) {
  std::vector<std::string> faults = faults_of("hand = \"crepe_pam\"\n");
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_NE(faults[0].find("one.toml:19: proxy 1: hand 'crepe_pam' is no hand script"), std::string::npos) << faults[0];
  EXPECT_NE(faults[0].find("did you mean 'crepe_pan'?"), std::string::npos) << faults[0];
  faults = faults_of("hand = \"mine.toml\"\n");
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_NE(faults[0].find("mine.toml': no such file"), std::string::npos) << faults[0];
  EXPECT_EQ(faults_of("hand = 3\n").size(), 1u);
  EXPECT_EQ(faults_of("hand = \"\"\n").size(), 1u);
  EXPECT_EQ(faults_of("hand = \"none.toml\"\ndevice = 9\n").size(), 2u);  // beside other faults
}

// The table at the end of README.md, as scene and the hands of its row.
std::map<std::string, std::set<std::string>> documented_hands() {
  std::ifstream in(kScenes / "README.md");
  std::map<std::string, std::set<std::string>> hands;
  std::string line;
  while (std::getline(in, line) && line != "### Scenes to feel") {
  }
  while (std::getline(in, line)) {
    if (line.rfind("| `", 0) != 0) continue;
    std::istringstream cells(line.substr(1));
    std::vector<std::string> names[2];
    for (auto& cell : names) {
      std::string text;
      std::getline(cells, text, '|');
      for (std::size_t at = text.find('`'); at != std::string::npos;) {
        const std::size_t end = text.find('`', at + 1);
        cell.push_back(text.substr(at + 1, end - at - 1));
        at = text.find('`', end + 1);
      }
    }
    for (const std::string& scene : names[0]) hands[scene].insert(names[1].begin(), names[1].end());
  }
  return hands;
}

TEST(ScenesOfPalp, NameAHandForEachDeviceAsTheReadmeSays) {
  std::map<std::string, std::set<std::string>> documented = documented_hands();
  std::size_t with_tools = 0;
  for (const auto& entry : fs::directory_iterator(kScenes)) {
    if (entry.path().extension() != ".toml") continue;
    const SceneConfig scene = load_scene(entry.path().string());
    if (scene.proxies.empty()) continue;
    ++with_tools;
    const std::string name = entry.path().stem().string();
    for (const ProxyConfig& proxy : scene.proxies) {
      const std::string hand = fs::path(proxy.hand).stem().string();
      EXPECT_EQ(documented[name].count(hand), 1u) << name << " names '" << hand << "'";
    }
  }
  EXPECT_EQ(documented.size(), with_tools);
}

}  // namespace
}  // namespace palp::test::scene_hands_test
