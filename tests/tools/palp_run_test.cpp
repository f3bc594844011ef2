// The palp-run binary: exit status, messages and files.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace {

struct Outcome {
  int status = -1;
  std::string text;  // stdout and stderr
};

Outcome run(const std::string& arguments) {
  const std::string command = "timeout 60 " PALP_BIN_DIR "/palp-run " + arguments + " 2>&1";
  Outcome outcome;
  std::FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 4096> buffer;
  while (std::fgets(buffer.data(), buffer.size(), pipe)) outcome.text += buffer.data();
  const int status = pclose(pipe);
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

class PalpRun : public testing::Test {
 protected:
  ~PalpRun() override { std::filesystem::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ + "/" + name) << text;
    return folder_ + "/" + name;
  }
  std::string folder_ =
      (std::filesystem::temp_directory_path() / ("palp_run_process_" + std::to_string(getpid()))).string();
};

TEST_F(PalpRun, RunsASceneByItsName) {
  const Outcome outcome =
      run("poiseuille --accuracy fast --backend cpu --duration 0.002 --snapshots-hz 1000 --out " + folder_);
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  for (const char* file :
       {"summary.json", "profile.csv", "extremes.csv", "particles_000000.csv", "particles_000002.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ + "/" + file)) << file;
  }
  EXPECT_EQ(outcome.text.find('\r'), std::string::npos) << "a progress line although there is no terminal";
}

TEST_F(PalpRun, RefusesBadInputWithOneMessage) {
  struct Row {
    std::string arguments, message;
  };
  const std::string bad = write("bad.toml", "[scene]\nrate_hz = -1\n");
  const Row rows[] = {
      {"", "scene is required"},
      {"poiseuille", "--out is required"},
      {"poiseuile --out " + folder_, "palp-run: poiseuile: no such scene file"},
      {"poiseuile --out " + folder_, "did you mean 'poiseuille'?"},
      {"poiseuille --backend gpu --out " + folder_, "--backend"},
      {"poiseuille --accuracy best --out " + folder_, "--accuracy"},
      {"poiseuille --duration -1 --out " + folder_, "--duration"},
      {"poiseuille --spacing nan --out " + folder_, "spacing on the command line is nan"},
      {"poiseuille --spacing 2e-7 --out " + folder_, "memory here allows"},
      {"poiseuille --path /nowhere.csv --out " + folder_, "palp-run: /nowhere.csv: no such file"},
      {bad + " --out " + folder_, "bad.toml:2: [scene]: rate_hz is -1, expected a number in Hz from 1 to 1000000"},
  };
  for (const Row& row : rows) {
    const Outcome outcome = run(row.arguments);
    EXPECT_EQ(outcome.status, 2) << row.arguments << "\n" << outcome.text;
    EXPECT_NE(outcome.text.find(row.message), std::string::npos) << row.arguments << "\n" << outcome.text;
  }
}

TEST_F(PalpRun, SaysWhenItCannotWrite) {
  const Outcome outcome = run("poiseuille --accuracy fast --backend cpu --duration 0.001 --out /proc/nowhere");
  EXPECT_EQ(outcome.status, 1) << outcome.text;
  EXPECT_NE(outcome.text.find("/proc/nowhere: cannot make the folder"), std::string::npos) << outcome.text;
}

}  // namespace
