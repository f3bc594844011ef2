// The palp-run binary: exit status, messages and files.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include "tests/support/files.h"
#include "tests/support/process.h"

namespace palp::test::palp_run_test {
namespace {

const std::string kProgram = PALP_BIN_DIR "/palp-run";

class PalpRun : public testing::Test {
 protected:
  static Outcome run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), kProgram);
    return run_program(arguments);
  }
  ScratchFolder folder_;
  const std::string out_ = folder_ / "out";  // is made by the program
};

TEST_F(PalpRun, RunsASceneByItsName) {
  const Outcome outcome = run({"poiseuille", "--accuracy", "fast", "--backend", "cpu", "--duration", "0.002",
                               "--snapshots-hz", "1000", "--out", out_});
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  for (const char* file :
       {"summary.json", "profile.csv", "extremes.csv", "particles_000000.csv", "particles_000002.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(out_ + "/" + file)) << file;
  }
  EXPECT_EQ(outcome.output.find('\r'), std::string::npos) << "a progress line although there is no terminal";
}

// timeout(1) sends its signal twice, to the process and to its group; that is no impatience. A later one is.
TEST_F(PalpRun, LosesNothingThatASignalStops) {
  ChildProcess program(
      {kProgram, "tray_fluid", "--accuracy", "fast", "--backend", "cpu", "--duration", "1000", "--out", out_},
      folder_ / "log");
  const auto runs = [&] {
    const std::string probe = out_ + "/energy.csv";
    return std::filesystem::exists(probe) && std::filesystem::file_size(probe) > 0;
  };
  for (int k = 0; k < 3000 && !runs(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_TRUE(runs()) << program.output();
  program.send_signal(SIGINT);
  program.send_signal(SIGINT);
  EXPECT_EQ(program.wait(), 128 + SIGINT) << program.output();
  EXPECT_NE(text_of(out_ + "/summary.json").find("\"stopped_by_signal\": 2"), std::string::npos);
}

TEST_F(PalpRun, RefusesBadInputWithOneMessage) {
  struct Row {
    std::vector<std::string> arguments;
    std::string message;
  };
  const std::string bad = folder_ / "bad.toml";
  write_text(bad, "[scene]\nrate_hz = -1\n");
  const std::string open = folder_ / "open.csv";
  write_text(open, "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n1,0,0,0.5,0,0,0,1\n");
  const Row rows[] = {
      {{}, "scene is required"},
      {{"poiseuille"}, "--out is required"},
      {{"poiseuile", "--out", out_}, "palp-run: poiseuile: no such scene file"},
      {{"poiseuile", "--out", out_}, "did you mean 'poiseuille'?"},
      {{"poiseuille", "--backend", "gpu", "--out", out_}, "--backend"},
      {{"poiseuille", "--accuracy", "best", "--out", out_}, "--accuracy"},
      {{"poiseuille", "--backend", "cpu", "--duration", "1e-8", "--out", out_}, "is less than a haptic step"},
      {{"poiseuille"}, "--out is required"},
      {{"poiseuille", "--explain=yes"}, "'yes' is no form of a bill"},
      {{"poiseuille", "--duration", "-1", "--out", out_}, "--duration"},
      {{"poiseuille", "--spacing", "nan", "--out", out_}, "spacing on the command line is nan"},
      {{"poiseuille", "--spacing", "2e-7", "--out", out_}, "memory here allows"},
      {{"poiseuille", "--path", "/nowhere.csv", "--out", out_}, "palp-run: /nowhere.csv: no such file"},
      {{"poiseuille", "--path", "1=/nowhere.csv", "--out", out_}, "palp-run: /nowhere.csv: no such file"},
      {{"poiseuille", "--path", open, "--repeat-paths", "--out", out_},
       "open.csv:3: the last pose is 0.5 m and 0 rad from the first one"},
      {{"poiseuille", "--set", "numerics.safety=2", "--out", out_},
       "palp-run: --set numerics.safety=2: numerics: safety is 2, expected a number from 0.05 to 1"},
      {{bad, "--out", out_}, "bad.toml:2: [scene]: rate_hz is -1, expected a number in Hz from 1 to 1000000"},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.message);
    const Outcome outcome = run(row.arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.output;
    EXPECT_NE(outcome.output.find(row.message), std::string::npos) << outcome.output;
  }
}

TEST_F(PalpRun, EndsByWhatWasChecked) {
  const Outcome outcome =
      run({"poiseuille", "--accuracy", "fast", "--backend", "cpu", "--duration", "0.002", "--out", out_});
  const std::size_t last = outcome.output.find("\nhealthy: finite, speeds to ");
  ASSERT_NE(last, std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find('\n', last + 1), outcome.output.size() - 1) << "one line, and the last one";
}

TEST_F(PalpRun, ExplainsASceneWithoutRunningIt) {
  const std::string file = folder_ / "bill.json";
  const Outcome outcome = run({"poiseuille", "--accuracy", "fast", "--backend", "cpu", "--explain=" + file});
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const std::string text = text_of(file);
  for (const char* key : {"\"bodies\"", "\"modules\"", "\"limits\"", "\"stages\"", "\"share\"", "\"hints\""})
    EXPECT_NE(text.find(key), std::string::npos) << key << " in " << text;
  EXPECT_FALSE(std::filesystem::exists(out_));
}

TEST_F(PalpRun, SaysWhenItCannotWrite) {
  const Outcome outcome =
      run({"poiseuille", "--accuracy", "fast", "--backend", "cpu", "--duration", "0.001", "--out", "/proc/nowhere"});
  EXPECT_EQ(outcome.status, 1) << outcome.output;
  EXPECT_NE(outcome.output.find("/proc/nowhere: cannot make the folder"), std::string::npos) << outcome.output;
}

}  // namespace
}  // namespace palp::test::palp_run_test
