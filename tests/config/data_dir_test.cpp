// Where scenes, hands and profiles are found: out of a build tree, installed, and where PALP_DATA_DIR says.
#include "config/data_dir.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "config/error.h"
#include "tests/support/files.h"
#include "tests/support/process.h"

namespace palp::test::data_dir_test {
namespace {

namespace fs = std::filesystem;

class DataDir : public testing::Test {
 protected:
  DataDir() : before_(fs::current_path()) {
    fs::current_path(folder_.path());
    unsetenv("PALP_DATA_DIR");
    setenv("XDG_DATA_DIRS", (folder_ / "nowhere").c_str(), 1);
  }
  ~DataDir() override {
    fs::current_path(before_);
    unsetenv("PALP_DATA_DIR");
    unsetenv("XDG_DATA_DIRS");
  }
  void write(const std::string& name) {
    const fs::path file = folder_ / name;
    fs::create_directories(file.parent_path());
    write_text(file, "duration = 1\n");
  }
  std::string refusal(const DataKind& kind, const std::string& name) {
    try {
      return "found " + find_data_file(kind, name);
    } catch (const ConfigError& error) {
      return error.what();
    }
  }

  const ScratchFolder folder_;
  const fs::path before_;
};

TEST_F(DataDir, ABuildTreeFindsItsSourceTreeFromAnyFolder) {
  for (const auto& [kind, name] :
       {std::pair{kSceneFiles, "tray_fluid"}, {kHandFiles, "stir"}, {kDeviceProfiles, "simulated"}}) {
    const fs::path file = find_data_file(kind, name);
    EXPECT_TRUE(
        fs::equivalent(file, fs::path(PALP_SOURCE_DIR) / "config" / kind.folder / (name + std::string(".toml"))));
  }
}

// The test itself, where a package would put it.
TEST_F(DataDir, AnInstalledProgramFindsWhatIsBesideIt) {
  if (std::getenv("PALP_SAY_DATA_DIR")) {
    std::printf("data: %s\n", data_dir().c_str());
    return;
  }
  write("usr/share/palp/scenes/pond.toml");
  fs::create_directories(folder_ / "usr/bin");
  const fs::path program = folder_ / "usr/bin/data_dir_test";
  fs::copy_file(fs::read_symlink("/proc/self/exe"), program);
  const Outcome installed = run_program({"env", "PALP_SAY_DATA_DIR=1", program.string(), "--gtest_filter=*BesideIt"});
  EXPECT_EQ(installed.status, 0);
  EXPECT_NE(installed.output.find("data: " + (folder_ / "usr/share/palp") + "\n"), std::string::npos)
      << installed.output;
}

TEST_F(DataDir, TheEnvironmentDecides) {
  write("mine/scenes/pond.toml");
  setenv("PALP_DATA_DIR", (folder_ / "mine").c_str(), 1);
  EXPECT_EQ(find_data_file(kSceneFiles, "pond"), folder_ / "mine/scenes/pond.toml");
  EXPECT_EQ(refusal(kSceneFiles, "pnd"),
            "pnd: no such scene file, expected a path or one of: pond; did you mean 'pond'?");
  setenv("PALP_DATA_DIR", "/no/such/folder", 1);
  EXPECT_EQ(refusal(kSceneFiles, "pond"),
            "PALP_DATA_DIR=/no/such/folder: no such folder; it must hold scenes, hands and devices");
}

TEST_F(DataDir, PathsAndTheFolderOnesselfIsInComeFirst) {
  write("config/hands/stir.toml");
  EXPECT_EQ(find_data_file(kHandFiles, "stir"), "config/hands/stir.toml");
  EXPECT_EQ(find_data_file(kHandFiles, "config/hands/stir.toml"), "config/hands/stir.toml");
  EXPECT_EQ(refusal(kHandFiles, "./stir"), "./stir: no such hand script");
}

}  // namespace
}  // namespace palp::test::data_dir_test
