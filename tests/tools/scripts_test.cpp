// The scripts of tools/, as a user meets them. tools/demo runs in a copy of the tree whose programs are stand-ins.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <sstream>
#include <tuple>

#include "tests/support/process.h"

namespace palp::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

const std::string kTools = PALP_SOURCE_DIR "/tools/";
const std::string kTests = PALP_SOURCE_DIR "/tests/tools/";

Outcome call(std::vector<std::string> command) { return run_program(std::move(command), 120s); }

TEST(Scripts, HelpSaysWhatThereIs) {
  for (const char* script : {"demo", "test", "setup", "lint", "plot.py", "validate", "tradeoff", "film"}) {
    const Outcome result = call({kTools + script, "--help"});
    EXPECT_EQ(result.status, 0) << script;
    EXPECT_NE(result.output.find("usage"), std::string::npos) << script << ": " << result.output;
  }
}

TEST(Scripts, WrongOptionsAreOneClearSentence) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"demo", "--colour"}, "unknown option '--colour'"},
      {{"demo", "--seconds"}, "--seconds needs a value"},
      {{"demo", "--seconds", "soon"}, "a number above 0"},
      {{"demo", "--seconds", "0"}, "a number above 0"},
      {{"demo", "--dds", "rti"}, "cyclone or fastdds"},
      {{"demo", "--backend", "metal"}, "auto, cpu or cuda"},
      {{"demo", "--accuracy", "best"}, "fast, balanced or accurate"},
      {{"demo", "--accuracy", "fast", "--budget", "1ms"}, "--budget and --accuracy: expected one of them"},
      {{"demo", "--scene", "no_such_scene"}, "config/scenes has"},
      {{"film"}, "which scene?"},
      {{"film", "no_such_scene"}, "config/scenes has"},
      {{"film", "crepe", "--size", "big"}, "WIDTHxHEIGHT"},
      {{"film", "crepe", "--seconds", "0"}, "a number above 0"},
      {{"film", "crepe", "--from", "/no/such/file.mcap"}, "no such file"},
      {{"film", "crepe", "--out", "film.avi"}, "ends in .mp4"},
      {{"test", "--label", "slow"}, "unit, physics"},
      {{"test", "--preset", "fast"}, "release, debug"},
      {{"setup", "--now"}, "unknown option '--now'"},
      {{"plot.py", "/no/such/file.csv"}, "cannot be read"},
      {{"validate", "--backend", "metal"}, "'cpu', 'double', 'cuda'"},
      {{"validate", "--only", "("}, "a regular expression was expected"},
      {{"validate", "--bin", "/no/such/folder"}, "no test binaries in /no/such/folder"},
      {{"validate", "--render"}, "--render needs --merge"},
      {{"validate", "--render", "--merge", "/no/such/file.json"}, "no results.json"},
  };
  for (auto [command, expected] : cases) {
    command[0] = kTools + command[0];
    const Outcome result = call(command);
    EXPECT_NE(result.status, 0) << result.output;
    EXPECT_NE(result.output.find(expected), std::string::npos) << result.output;
    EXPECT_LE(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
  }
}

TEST(Scripts, EachLabelThatCanBeAskedForHasTests) {
  std::string lists;
  for (const auto& entry : fs::recursive_directory_iterator(PALP_SOURCE_DIR "/tests"))
    if (entry.path().filename() == "CMakeLists.txt" || entry.path().extension() == ".cmake")
      if (entry.path().parent_path() != PALP_SOURCE_DIR "/tests") lists += text_of(entry.path());
  const std::string said = call({kTools + "test", "--label", "none"}).output;
  const std::size_t begin = said.find("--label none: ") + 14, end = said.find(" was expected");
  ASSERT_LT(end, said.size()) << said;
  std::istringstream words(std::regex_replace(said.substr(begin, end - begin), std::regex("[,]| or"), " "));
  for (std::string label; words >> label;) EXPECT_NE(lists.find("LABELS " + label), std::string::npos) << label;
}

TEST(Plot, DrawsABridgeLogAndProbes) {
  const ScratchFolder folder;
  write_text(folder / "bridge.csv",
             "t_ns,state,age_us,lateness_us,force_x,force_y,force_z,torque_x,torque_y,torque_z\n"
             "1000,ready,,3,0,0,0,0,0,0\n2000,engaged,500,3,1,2,3,0,0,0\n3000,stale,900,3,1,2,3,0,0,0\n");
  write_text(folder / "probe.csv", "time_s,wall_pressure_pa,tip_x_m,tip_y_m\n0,1,2,3\n0.1,2,3,4\n");
  const Outcome result = call({kTools + "plot.py", folder / "bridge.csv", folder / "probe.csv"});
  ASSERT_EQ(result.status, 0) << result.output;
  for (const char* name : {"bridge.png", "probe.png"}) {
    const std::string png = text_of(folder / name);
    ASSERT_GT(png.size(), 10'000u);
    EXPECT_EQ(png[1], 'P');
  }
}

TEST(Plot, RefusesWhatItCannotDraw) {
  const ScratchFolder folder;
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "a line of column names"},
      {"time_s,a\n0,1\n0.1\n", "data.csv:3: 1 values"},
      {"a,b\n0,1\n1,2\n", "neither the log of a bridge"},
      {"time_s,a\n0,x\n1,y\n", "no column of numbers"},
  };
  for (const auto& [text, expected] : cases) {
    write_text(folder / "data.csv", text);
    const Outcome result = call({kTools + "plot.py", folder / "data.csv"});
    EXPECT_EQ(result.status, 1);
    EXPECT_NE(result.output.find(expected), std::string::npos) << result.output;
  }
}

TEST(Summary, AMissingOrBrokenPartIsUnhealthy) {
  const ScratchFolder folder;
  fs::create_directories(folder / "logs");
  for (const char* name : {"scene.png", "force.png", "recording.mcap"}) write_text(folder / name, "x");
  const std::string good = R"({"healthy": true, "messages": 5, "rate_hz": 1000.0})";
  for (const char* name : {"palp-sim-server", "palp-haptic-bridge", "palp-viewer", "palp-record"})
    write_text(folder / "logs/" + name + ".json", good);
  const std::vector<std::string> command{kTools + "summary.py", folder / ""};
  const Outcome sound = call(command);
  EXPECT_EQ(sound.status, 0) << sound.output;
  for (const std::string& bad : {std::string("{"), std::string("[]"), std::string(R"({"healthy": "yes"})"),
                                 std::string(R"({"healthy": false, "cause": "it blew up"})")}) {
    write_text(folder / "logs/palp-sim-server.json", bad);
    const Outcome result = call(command);
    EXPECT_EQ(result.status, 1) << bad;
    EXPECT_NE(result.output.find("NOT HEALTHY: palp-sim-server"), std::string::npos) << result.output;
  }
  write_text(folder / "logs/palp-sim-server.json",
             R"({"healthy": true, "step_p50_us": "fast", "real_time_factor": null})");
  EXPECT_EQ(call(command).status, 0);
  fs::remove(folder / "scene.png");
  EXPECT_EQ(call(command).status, 1);
}

// tools/validate over a test binary that is a stand-in: what it reports decides the status and stands in the table.
TEST(Validate, JudgesWhatTestsReport) {
  const ScratchFolder folder;
  const std::string binary = folder / "validation_test";
  const auto row = [](const std::string& more) {
    return R"(, "validation_0": "{\"case\": \"a ball\", \"method\": \"paper\", \"back_end\": \"cpu\", )"
           R"(\"reference\": \"1 m\", \"result\": \"1.1 m\", \"of\": \"of it\", \"numerics\": \"n\", )" +
           more + R"(}")";
  };
  const std::string holds = row(R"(\"error\": 0.1, \"tolerance\": 0.2)"),
                    fails = row(R"(\"error\": 0.3, \"tolerance\": 0.2)"),
                    off = row(R"(\"error\": 0.3, \"tolerance\": 0.2, \"known\": \"it is half\")"),
                    no_number = row(R"(\"error\": -1, \"tolerance\": 0.2)"), none;
  const std::vector<std::tuple<std::string, int, int, std::string>> cases{
      {holds, 0, 0, "1.1 m; error 0.1; holds"}, {off, 0, 0, "error 0.3; *off* [1]"},
      {fails, 0, 1, "error 0.3; **FAILS**"},    {no_number, 0, 1, "error no number; **FAILS**"},
      {holds, 1, 1, "ended with status 1"},     {none, 0, 1, "reported no validation case"},
  };
  for (const auto& [properties, status, expected, text] : cases) {
    write_text(binary,
               "#!/bin/bash\nif [ $1 = --gtest_list_tests ]; then echo Cradle.; echo '  One'; exit; fi\n"
               "for a; do case $a in --gtest_output=json:*) out=${a#*json:};; esac; done\ncat >$out <<'END'\n"
               R"({"testsuites": [{"testsuite": [{"name": "One", "result": "COMPLETED")" +
                   properties + "}]}]}\nEND\nexit " + std::to_string(status) + "\n");
    fs::permissions(binary, fs::perms::owner_all);
    const Outcome result =
        call({kTools + "validate", "--bin", folder / "", "--backend", "cpu", "--out", folder / "out"});
    EXPECT_EQ(result.status, expected) << result.output;
    EXPECT_NE(text_of(folder / "out/table.md").find(text), std::string::npos) << result.output << text;
  }
  write_text(binary,
             "#!/bin/bash\nif [ $1 = --gtest_list_tests ]; then echo Cradle.; echo '  One'; exit; fi\nkill -9 $$\n");
  const Outcome crashed = call({kTools + "validate", "--bin", folder / "", "--out", folder / "out"});
  EXPECT_EQ(crashed.status, 1);
  EXPECT_NE(crashed.output.find("no result"), std::string::npos) << crashed.output;
}

// A copy of what tools/demo needs; cmake and ninja find nothing to do.
class Demo : public testing::Test {
 protected:
  Demo() {
    fs::create_directories(folder_ / "tree/tools");
    for (const char* name : {"demo", "lib.sh", "plot.py", "scene_hands.py", "summary.py"})
      fs::copy(kTools + name, folder_ / "tree/tools/" + name);
    fs::create_directories(folder_ / "tree/config/scenes");
    fs::create_directories(folder_ / "tree/config/hands");
    write_text(folder_ / "tree/config/scenes/tray_fluid.toml", "[[proxy]]\nhand = \"stir\"\n");
    for (const char* hand : {"stir", "pan", "still"}) write_text(folder_ / "tree/config/hands/" + hand + ".toml", "");
    fs::create_directories(folder_ / "tree/build/release/bin");
    for (const char* name : {"palp-sim-server", "palp-haptic-bridge", "palp-viewer", "palp-record"})
      fs::copy(kTests + "fake_program.sh", folder_ / "tree/build/release/bin/" + name);
    fs::create_directories(folder_ / "path");
    script("tree/tools/setup", "exit 0");
    script("path/cmake", "echo '-- CUDA back end: not built (test)'");
    script("path/ninja", "echo 'ninja: no work to do.'");
  }

  void script(const std::string& name, const std::string& body) {
    write_text(folder_ / name, "#!/bin/bash\n" + body + "\n");
    fs::permissions(folder_ / name, fs::perms::owner_all);
  }
  std::vector<std::string> command(const std::vector<std::string>& environment = {},
                                   const std::vector<std::string>& options = {"--seconds", "1"}) const {
    std::vector<std::string> out{"/usr/bin/env",
                                 "PATH=" + (folder_ / "path") + ":/usr/bin:/bin",
                                 "FAKE_PIDS=" + (folder_ / "pids"),
                                 "FAKE_CALLS=" + (folder_ / "calls"),
                                 "DISPLAY=",
                                 "WAYLAND_DISPLAY="};
    out.insert(out.end(), environment.begin(), environment.end());
    out.push_back(folder_ / "tree/tools/demo");
    out.insert(out.end(), options.begin(), options.end());
    return out;
  }
  // Waits for them: a process that was just killed may take a moment to go.
  bool nothing_left() const {
    for (int i = 0; i < 100; ++i) {
      std::ifstream pids(folder_ / "pids");
      bool any = false;
      for (pid_t pid = 0; pids >> pid;) any = any || kill(pid, 0) == 0;
      if (!any) return true;
      std::this_thread::sleep_for(20ms);
    }
    return false;
  }

  ScratchFolder folder_;
};

TEST_F(Demo, RunsStopsSumsUpAndIsHealthy) {
  const Outcome result = call(command());
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_NE(result.output.find("all healthy"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("2.50 N"), std::string::npos) << result.output;
  for (const char* name : {"scene.png", "force.png", "recording.mcap"})
    EXPECT_TRUE(fs::exists(folder_ / "tree/out/demo/" + name)) << name;
  EXPECT_TRUE(nothing_left());
  const std::string calls = text_of(folder_ / "calls");
  EXPECT_NE(calls.find("palp-sim-server config/scenes/tray_fluid.toml --backend auto"), std::string::npos) << calls;
  EXPECT_NE(calls.find("--headless"), std::string::npos) << calls;
}

TEST_F(Demo, OnACpuTheServerChoosesForABudget) {
  const auto server_calls = [&] {
    std::istringstream calls(text_of(folder_ / "calls"));
    std::string found;
    for (std::string line; std::getline(calls, line);)
      if (line.rfind("palp-sim-server", 0) == 0) found += line.substr(0, line.find(" --summary")) + "\n";
    fs::remove(folder_ / "calls");
    return found;
  };
  const std::string with = "palp-sim-server config/scenes/tray_fluid.toml --backend cpu ";
  EXPECT_EQ(call(command({}, {"--seconds", "1", "--backend", "cpu"})).status, 0);
  EXPECT_EQ(server_calls(), with + "--budget 500us\n");
  EXPECT_EQ(call(command({}, {"--seconds", "1", "--backend", "cpu", "--error", "5%"})).status, 0);
  EXPECT_EQ(server_calls(), with + "--error 5%\n");
  const std::vector<std::string> no_curve{"FAKE_HAS_NO_CURVE=palp-sim-server"};
  const Outcome coarse = call(command(no_curve, {"--seconds", "1", "--backend", "cpu"}));
  EXPECT_EQ(coarse.status, 0) << coarse.output;
  EXPECT_NE(coarse.output.find("there is no curve; so it is --accuracy fast"), std::string::npos) << coarse.output;
  EXPECT_EQ(server_calls(), with + "--budget 500us\n" + with + "--accuracy fast\n");
  // who asks for a budget is told that there is none
  EXPECT_EQ(call(command(no_curve, {"--seconds", "1", "--backend", "cpu", "--budget", "1ms"})).status, 1);
  EXPECT_EQ(server_calls(), with + "--budget 1ms\n");
  EXPECT_TRUE(nothing_left());
}

TEST_F(Demo, AProcessThatDiesOrIsSickMakesItFail) {
  const Outcome dead = call(command({"FAKE_DIES=palp-sim-server"}, {"--seconds", "60"}));
  EXPECT_EQ(dead.status, 1) << dead.output;
  EXPECT_NE(dead.output.find("palp-sim-server ended too early"), std::string::npos) << dead.output;
  EXPECT_NE(dead.output.find("no such scene"), std::string::npos) << dead.output;
  EXPECT_TRUE(nothing_left());
  const Outcome sick = call(command({"FAKE_SICK=palp-viewer"}));
  EXPECT_EQ(sick.status, 1) << sick.output;
  EXPECT_NE(sick.output.find("NOT HEALTHY: palp-viewer"), std::string::npos) << sick.output;
}

TEST_F(Demo, StartsABridgeWithItsHandForEachDevice) {
  write_text(folder_ / "tree/config/scenes/two.toml",
             "[[proxy]]\nhand = \"stir\"\n[[proxy]]\ndevice = 1\nhand = \"pan\"\n");
  const Outcome both = call(command({}, {"--seconds", "1", "--scene", "two"}));
  EXPECT_EQ(both.status, 0) << both.output;
  EXPECT_NE(both.output.find("force_0.png, force_1.png"), std::string::npos) << both.output;
  for (const char* name : {"force_0.png", "force_1.png"}) EXPECT_TRUE(fs::exists(folder_ / "tree/out/demo/" + name));
  EXPECT_TRUE(nothing_left());
  const auto moved_by = [&](const std::string& device, const std::string& hand) {
    std::istringstream calls(text_of(folder_ / "calls"));
    for (std::string line; std::getline(calls, line);)
      if (line.find("--device-number " + device) != std::string::npos)
        return line.find("hands/" + hand + ".toml") != std::string::npos;
    return false;
  };
  EXPECT_TRUE(moved_by("0", "stir") && moved_by("1", "pan")) << text_of(folder_ / "calls");
  fs::remove(folder_ / "calls");
  const Outcome other = call(command({}, {"--seconds", "1", "--scene", "two", "--hand", "1=still"}));
  EXPECT_EQ(other.status, 0) << other.output;
  EXPECT_TRUE(moved_by("0", "stir") && moved_by("1", "still")) << text_of(folder_ / "calls");
  const Outcome none = call(command({}, {"--scene", "two", "--hand", "2=still"}));
  EXPECT_EQ(none.status, 1);
  EXPECT_NE(none.output.find("no tool for that device (it has: 0 1)"), std::string::npos) << none.output;
}

TEST_F(Demo, ASceneWithoutAToolNeedsNoBridge) {
  write_text(folder_ / "tree/config/scenes/dam.toml", "");
  const Outcome result = call(command({}, {"--seconds", "1", "--scene", "dam"}));
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_NE(result.output.find("no bridge was started"), std::string::npos) << result.output;
  EXPECT_EQ(text_of(folder_ / "calls").find("palp-haptic-bridge"), std::string::npos);
}

TEST_F(Demo, AProcessThatHadToBeKilledIsTheOneVerdict) {
  const Outcome result = call(command({"FAKE_STAYS=palp-viewer"}));
  EXPECT_EQ(result.status, 1) << result.output;
  EXPECT_NE(result.output.find("NOT HEALTHY: palp-viewer did not end within 10 s"), std::string::npos) << result.output;
  EXPECT_EQ(result.output.find("all healthy"), std::string::npos) << result.output;
  EXPECT_TRUE(nothing_left());
}

TEST_F(Demo, ClosingTheWindowEndsItWell) {
  const Outcome closed = call(command({"DISPLAY=:0", "FAKE_LEAVES=palp-viewer"}, {"--forever"}));
  EXPECT_EQ(closed.status, 0) << closed.output;
  for (const char* name : {"scene.png", "force.png", "recording.mcap"})
    EXPECT_TRUE(fs::exists(folder_ / "tree/out/demo/" + name)) << name;
  EXPECT_EQ(text_of(folder_ / "calls").find("--headless"), std::string::npos);
  EXPECT_TRUE(nothing_left());
  const Outcome left = call(command({"DISPLAY=:0", "FAKE_LEAVES=palp-haptic-bridge"}, {"--forever"}));
  EXPECT_EQ(left.status, 1) << left.output;
  EXPECT_NE(left.output.find("palp-haptic-bridge ended too early"), std::string::npos) << left.output;
}

TEST_F(Demo, AnInterruptLeavesNothingRunning) {
  ChildProcess demo(command({}, {"--forever"}), folder_ / "output.txt");
  const auto started = [&] { return text_of(folder_ / "pids"); };
  for (int i = 0; i < 600 && std::ranges::count(started(), '\n') < 4; ++i) std::this_thread::sleep_for(50ms);
  EXPECT_EQ(std::ranges::count(started(), '\n'), 4) << demo.output();
  demo.send_signal(SIGINT);
  EXPECT_EQ(demo.wait(), 0) << demo.output();
  EXPECT_TRUE(nothing_left());
}

}  // namespace
}  // namespace palp::test
