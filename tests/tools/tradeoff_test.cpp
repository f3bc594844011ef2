// tools/tradeoff: its arithmetic, its paths of hands, and a whole comparison on a scene of a few hundred particles.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include <nlohmann/json.hpp>

#include "config/json_file.h"
#include "config/pose_path.h"
#include "haptic_bridge/device/hand_script.h"
#include "tests/support/files.h"
#include "tests/support/process.h"

namespace palp::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

const std::string kTool = PALP_SOURCE_DIR "/tools/tradeoff";

TEST(Tradeoff, ItsArithmeticGivesClosedForms) {
  const Outcome result = run_program({PALP_SOURCE_DIR "/tests/tools/tradeoff_arithmetic.py"}, 60s);
  EXPECT_EQ(result.status, 0) << result.output;
}

// The script that makes paths restates the bridge's curves: both kinds, with turns, looped.
TEST(Tradeoff, PathsAreThoseOfTheSimulatedArm) {
  const ScratchFolder folder;
  for (const std::string name : {"stir", "crepe_cup", "crepe_pan"}) {
    const std::string hand = PALP_SOURCE_DIR "/config/hands/" + name + ".toml";
    const std::string program =
        "import sys, pathlib; sys.dont_write_bytecode = True; sys.path.insert(0, '" PALP_SOURCE_DIR
        "/tools'); from tradeoff_lib import hand; hand.write_path({'body': [{'name': 'tool'}]}, {'body': 'tool'}, "
        "pathlib.Path('" +
        hand + "'), 11, pathlib.Path('" + (folder / "path.csv") + "'), 50)";
    const Outcome result = run_program({"/usr/bin/python3", "-c", program}, 60s);
    ASSERT_EQ(result.status, 0) << result.output;
    const HandScript script = read_hand_script(hand);
    const Trajectory curve(script.keyframes, script.interpolation, script.loop);
    const std::vector<PathPose> path = read_pose_path(folder / "path.csv");
    ASSERT_EQ(path.size(), 551u);
    for (const PathPose& pose : path) {
      const RigidState state = curve.at(pose.time);
      ASSERT_LT((pose.position - state.position).norm(), 1e-7) << name << " at " << pose.time;
      ASSERT_LT(pose.orientation.angularDistance(state.orientation), 1e-7) << name << " at " << pose.time;
    }
  }
}

class TradeoffRun : public testing::Test {
 protected:
  TradeoffRun() {
    write_text(folder_ / "path.csv", "time,x,y,z,qx,qy,qz,qw\n0,0,0,0.4,0,0,0,1\n0.1,0.02,0,0.22,0,0,0,1\n");
  }
  Outcome run(std::vector<std::string> options) const {
    options.insert(options.begin(), {kTool, "--bin", PALP_BIN_DIR, "--out", folder_ / "out"});
    return run_program(options, 300s);
  }
  std::vector<std::string> measured(const std::string& only) const {
    return {std::string(PALP_SOURCE_DIR) + "/tests/process/small_tray.toml",
            "--path",
            folder_ / "path.csv",
            "--duration",
            "0.1",
            "--grid",
            "quick",
            "--reference-seconds",
            "5",
            "--only",
            only,
            "--errors-only",
            "--store",
            folder_ / "store"};
  }
  ScratchFolder folder_;
};

// On a machine that is lent for a time what was measured is kept.
TEST_F(TradeoffRun, LeavesOutPointsThatHadNoTime) {
  std::vector<std::string> options = measured("level|60 mm, H 3");
  options.insert(options.end(), {"--points-seconds", "0.001"});
  const Outcome outcome = run(options);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("were left out after"), std::string::npos) << outcome.output;
  const Json result = Json::parse(text_of(folder_ / "out/small_tray/cpu/results.json"));
  EXPECT_EQ(result["points"].size(), 1u) << "the first is run in any case";
}

TEST_F(TradeoffRun, MeasuresStoresAndGoesOnWhereItWas) {
  const Outcome first = run(measured("level|60 mm, H 3"));
  ASSERT_EQ(first.status, 0) << first.output;
  const std::string at = folder_ / "out/small_tray/cpu/";
  const Json result = Json::parse(text_of(at + "results.json"));
  ASSERT_FALSE(result["points"].empty());
  EXPECT_EQ(result["medium"], "fluid");
  EXPECT_FALSE(result["quiet"]);
  EXPECT_FALSE(result["reference"]["spacings"].empty());
  std::size_t front = 0;
  for (const Json& point : result["points"]) {
    EXPECT_EQ(point["status"], "done") << point["said"];
    EXPECT_GT(point["summary"]["reached_rate_hz"], 0);
    EXPECT_GE(point["errors"]["force"]["rms"], 0);
    EXPECT_TRUE(point["errors"]["wave_speed"].is_null());
    front += point["dominated_by"].is_null();
  }
  EXPECT_GE(front, 1u);
  EXPECT_NE(text_of(at + "table.md").find("**front**"), std::string::npos);
  EXPECT_EQ(text_of(at + "front.png").substr(1, 3), "PNG");

  const std::string kept = folder_ / ("store/" + result["class"].get<std::string>() + ".json");
  const Json stored = Json::parse(text_of(kept))["scenes"]["small_tray"];
  EXPECT_EQ(stored["points"].size(), front);
  for (const char* key : {"spacing_m", "set", "particles", "sub_steps", "step_mean_s", "step_p99_s", "calm_step_s",
                          "rest_drift_spacings", "error", "noise_N", "memory_bytes"})
    EXPECT_TRUE(stored["points"][0].contains(key)) << key;

  const auto runs = [&] {
    std::map<fs::path, fs::file_time_type> times;
    for (const auto& entry : fs::directory_iterator(at + "runs")) times[entry.path()] = fs::last_write_time(entry);
    return times;
  };
  const auto before = runs();
  EXPECT_EQ(run(measured("level|60 mm, H 3")).status, 0);
  EXPECT_EQ(runs(), before);
  EXPECT_EQ(run(measured("method paper")).status, 0);
  EXPECT_EQ(runs().size(), before.size() + 1);

  std::vector<std::string> elsewhere = measured("level fast");
  elsewhere.insert(elsewhere.end(),
                   {"--reference", at + "reference.npz", "--out", folder_ / "other", "--grid", "full"});
  const Outcome by_another = run(elsewhere);
  ASSERT_EQ(by_another.status, 0) << by_another.output;
  const Json judged = Json::parse(text_of(folder_ / "other/small_tray/cpu/results.json"));
  EXPECT_EQ(judged["points"][0]["errors"]["force"], result["points"][0]["errors"]["force"]);
  EXPECT_EQ(judged["reference"], result["reference"]);
  const double wave_speed = judged["points"][0]["errors"]["wave_speed"];
  EXPECT_GT(wave_speed, 0);
  EXPECT_LT(wave_speed, 0.3);  // a lattice with H = 2 dx is that stiff
  std::vector<std::string> without = elsewhere;
  without.insert(without.end(), {"--no-waves", "--out", folder_ / "still"});
  ASSERT_EQ(run(without).status, 0);
  EXPECT_TRUE(Json::parse(text_of(folder_ / "still/small_tray/cpu/results.json"))["points"][0]["errors"]["wave_speed"]
                  .is_null());
  elsewhere.insert(elsewhere.end(), {"--duration", "0.05"});
  EXPECT_NE(run(elsewhere).output.find("another scene, path or duration"), std::string::npos);
}

TEST_F(TradeoffRun, ThePageHasEachSceneAndMachine) {
  ASSERT_EQ(run(measured("level")).status, 0);
  Json other = Json::parse(text_of(folder_ / "out/small_tray/cpu/results.json"));
  other["class"] = "h200";
  write_text(folder_ / "other.json", other.dump());
  const Outcome page = run({"--all", "--render", "--merge", folder_ / "other.json", "--page", folder_ / "page",
                            "--store", folder_ / "store"});
  ASSERT_EQ(page.status, 0) << page.output;
  const std::string text = text_of(folder_ / "page/trade.md");
  EXPECT_NE(text.find("## Fluid: small_tray on cpu-"), std::string::npos) << text;
  EXPECT_NE(text.find("## Fluid: small_tray on h200"), std::string::npos) << text;
  EXPECT_NE(text.find("- Level fast: "), std::string::npos) << text;
  EXPECT_TRUE(fs::exists(folder_ / "page/trade_small_tray_h200.png"));
  EXPECT_EQ(Json::parse(text_of(folder_ / "store/h200.json"))["class"], "h200");
}

TEST_F(TradeoffRun, RefusesWithOneSentence) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{}, "a scene or --all was expected"},
      {{"tray_fluid", "--all"}, "one of the two"},
      {{"no_such_scene"}, "no_such_scene: no such scene"},
      {{"dam_break"}, "has no [[proxy]], expected one"},
      {{"tray_fluid", "--grid", "huge"}, "'quick', 'full'"},
      {{"tray_fluid", "--only", "("}, "a regular expression was expected"},
      {{"tray_fluid", "--only", "no such point"}, "no point of the grid matches"},
      {{"tray_fluid", "--path", "/no/such.csv"}, "a CSV file that exists"},
      {{"tray_fluid", "--duration", "-1"}, "a number of seconds above 0"},
      {{"tray_fluid", "--bin", "/no/such/folder"}, "has no palp-run"},
      {{"--all", "--render", "--merge", "/no/such.json"}, "is no results.json"},
  };
  for (const auto& [options, expected] : cases) {
    const Outcome result = run(options);
    EXPECT_EQ(result.status, 2) << result.output;
    EXPECT_NE(result.output.find(expected), std::string::npos) << result.output;
  }
}

TEST_F(TradeoffRun, ListsItsPointsWithoutRunning) {
  const Outcome result = run({"tray_fluid", "--list"});
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_NE(result.output.find("level accurate: scene.accuracy=accurate"), std::string::npos) << result.output;
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST(LongRun, TellsWhatDriftsAndThatItRepeats) {
  const ScratchFolder folder;
  const std::string sources = PALP_SOURCE_DIR;
  const Outcome outcome =
      run_program({sources + "/tools/long_run", sources + "/tests/process/small_tray.toml", "--seconds", "1",
                   "--stretches", "4", "--bin", PALP_BIN_DIR, "--out", folder / "out"},
                  300s);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Json result = Json::parse(text_of(folder / "out/small_tray/cpu/result.json"));
  EXPECT_EQ(result["runs"], 2);
  EXPECT_TRUE(result["same_bits"]);
  EXPECT_EQ(result["edges_s"], Json({0.0, 0.25, 0.5, 0.75, 1.0}));
  std::map<std::string, std::vector<double>> values;
  for (const Json& one : result["quantities"]) values[one["name"]] = one["values"].get<std::vector<double>>();
  for (const char* name : {"force, rms", "kinetic energy", "potential energy", "volume"})
    EXPECT_EQ(values[name].size(), 4u) << name;
  EXPECT_GT(values["kinetic energy"][3], 0);
}

}  // namespace
}  // namespace palp::test
