// The real haptic_bridge binary against a scripted server on the loopback interface.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <thread>

#include "idl/bus.h"
#include "tests/haptic_bridge/log/small_disk.h"
#include "tests/haptic_bridge/pushing_server.h"
#include "tests/support/eventually.h"
#include "tests/support/files.h"
#include "tests/support/flight_table.h"
#include "tests/support/process.h"

namespace palp::test {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

class BridgeProcess : public testing::Test {
 protected:
  BridgeProcess() { options_.domain = 100 + getpid() % 100; }

  std::vector<std::string> command(std::vector<std::string> more = {}) const {
    std::vector<std::string> all{PALP_BIN_DIR "/palp-haptic-bridge", "--domain", std::to_string(options_.domain)};
    if (std::find(more.begin(), more.end(), "--log") == more.end())
      more.insert(more.end(), {"--log", folder_ / "bridge_log.csv"});
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  std::string output() const { return folder_ / "output.txt"; }
  std::string said() const { return text_of(output()); }
  int run_to_end(const std::vector<std::string>& more) {
    ChildProcess bridge(command(more), output());
    return bridge.wait(10s);
  }
  bool says(const std::string& text) const { return said().find(text) != std::string::npos; }
  bool begins() const {
    return eventually([&] { return says("the loop runs"); });
  }
  // Waits until the newest Status of the bridge is in the state.
  static bool reaches(Reader<Status>& reader, const std::string& state, std::chrono::milliseconds timeout,
                      Status* found = nullptr) {
    std::vector<Received<Status>> all;
    for (auto left = timeout; left > 0ms; left -= 50ms) {
      all.clear();
      reader.take_all(all);
      for (const auto& s : all) {
        if (s.message.process != "haptic_bridge 0" || s.message.state != state) continue;
        if (found) *found = s.message;
        return true;
      }
      std::this_thread::sleep_for(50ms);
    }
    return false;
  }

  ScratchFolder folder_;
  BusOptions options_;
};

TEST_F(BridgeProcess, FeelsAServerLosesItAndFindsTheNextOne) {
  const auto watcher = open_bus(options_);
  const auto status = watcher->reader<Status>();
  ChildProcess bridge(command({"--hand", PALP_SOURCE_DIR "/config/hands/still.toml"}), output());
  ASSERT_TRUE(reaches(*status, "waiting", 10s)) << said();

  std::int64_t t_dead_ns = 0;
  {
    PushingServer server(options_);
    ASSERT_TRUE(reaches(*status, "engaged", 10s)) << said();
    std::this_thread::sleep_for(800ms);
    EXPECT_GT(server.heard(), 500u);
    t_dead_ns = server.t_last_sent_ns();
  }
  ASSERT_TRUE(reaches(*status, "stale", 5s)) << said();
  {
    PushingServer server(options_);
    ASSERT_TRUE(reaches(*status, "engaged", 10s)) << said();
    std::this_thread::sleep_for(800ms);
    bridge.send_signal(SIGTERM);
    EXPECT_EQ(bridge.wait(10s), 0) << said();
  }

  const FlightTable log(folder_ / "bridge_log.csv");
  ASSERT_GT(log.ticks(), 2000u);
  double peak_before = 0, peak_dead = 0, peak_after = 0;
  for (std::size_t i = 0; i < log.ticks(); ++i) {
    const double since_death = log.number("t_ns", i) * 1e-9 - static_cast<double>(t_dead_ns) * 1e-9;
    const double force = log.number("force_z", i);
    if (since_death < 0) peak_before = std::max(peak_before, force);
    if (since_death > 0.13 && since_death < 0.3) peak_dead = std::max(peak_dead, std::abs(force));
    if (since_death > 0.5) peak_after = std::max(peak_after, force);
    ASSERT_TRUE(std::isfinite(force));
  }
  EXPECT_NEAR(peak_before, 3, 0.1);
  EXPECT_EQ(peak_dead, 0);  // zero_at is 80 ms; the rest is room for a machine that is busy
  EXPECT_NEAR(peak_after, 3, 0.1);
  EXPECT_NEAR(log.number("device_x", 0), 0.1, 1e-5);  // the home pose came from the scene
  EXPECT_NE(text_of(folder_ / "bridge_log.json").find("\"stale_events\": "), std::string::npos);
  EXPECT_NE(said().find("server was restarted"), std::string::npos);

  // all of it again, from what the loop took in
  EXPECT_EQ(run_to_end({"--rerun", folder_ / "bridge_log.ticks"}), 0) << said();
  EXPECT_NE(said().find(": " + std::to_string(log.ticks()) + " ticks, identical"), std::string::npos) << said();
}

TEST_F(BridgeProcess, SpeaksFastDdsToACycloneServer) {
  options_.vendor = Vendor::cyclone;
  const auto watcher = open_bus(options_);
  const auto status = watcher->reader<Status>();
  PushingServer server(options_);
  ChildProcess bridge(command({"--dds", "fastdds", "--seconds", "3"}), output());
  EXPECT_TRUE(reaches(*status, "engaged", 10s)) << said();
  EXPECT_EQ(bridge.wait(10s), 0) << said();
  EXPECT_NE(said().find("fastdds"), std::string::npos);
}

TEST_F(BridgeProcess, ReplaysAPathWithoutAServer) {
  write_text(folder_ / "path.csv", "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n1,0.1,0,0,0,0,0,1\n");
  EXPECT_EQ(run_to_end({"--device", "replay", "--path", folder_ / "path.csv", "--seconds", "1.2"}), 0);
  const FlightTable log(folder_ / "bridge_log.csv");
  EXPECT_EQ(log.ticks(), 1200u);
  EXPECT_NEAR(log.number("device_x", log.ticks() - 1), 0.1, 1e-9);
  EXPECT_EQ(log.text("state", log.ticks() - 1), "waiting");
}

TEST_F(BridgeProcess, IsStoppedCleanlyWhileItWaitsAndSaysWhyItWaits) {
  ChildProcess bridge(command(), output());
  EXPECT_TRUE(eventually([&] { return says("no sim_server is heard"); }, 5s)) << said();
  bridge.send_signal(SIGINT);
  EXPECT_EQ(bridge.wait(5s), 0);
}

TEST_F(BridgeProcess, SaysThatTheSceneHasNoProxyForIt) {
  PushingServer server(options_, 3);
  ChildProcess bridge(command({"--device-number", "1"}), output());
  EXPECT_TRUE(eventually([&] { return says("no proxy"); }, 5s)) << said();
  EXPECT_NE(said().find("scene 'test' has no proxy for device 1 (it has 3)"), std::string::npos) << said();
}

TEST_F(BridgeProcess, RefusesBadInputWithOneClearMessage) {
  write_text(folder_ / "bad.toml", "name = \"x\"\n[limits]\nforce = -3\n[arm]\nmas = 1\n");
  write_text(folder_ / "bad.csv", "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n0,0,0,0,0,0,0,1\n");
  write_text(folder_ / "malformed.toml", "name = \"x\"\n[limits\nforce = 3\n");
  write_text(folder_ / "infinite.toml", "name = \"x\"\n[limits]\nforce = nan\ntorque = 1\n");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--profile", folder_ / "bad.toml"}, "bad.toml:3"},
      {{"--profile", folder_ / "bad.toml"}, "bad.toml:5"},
      {{"--profile", folder_ / "none.toml"}, "none.toml"},
      {{"--hand", folder_ / "bad.toml"}, "bad.toml"},
      {{"--device", "replay", "--path", folder_ / "bad.csv"}, "bad.csv:3"},
      {{"--device", "replay"}, "--path"},
      {{"--device", "puppet"}, "puppet"},
      {{"--hand", "x", "--device", "replay", "--path", "y"}, "--hand"},
      {{"--home", "1", "2", "3", "4"}, "--home"},
      {{"--home", "1", "2", "nan"}, "--home"},
      {{"--device-number", "8"}, "--device-number"},
      {{"--rate-hz", "0"}, "--rate-hz"},
      {{"--rerun", folder_ / "bad.csv"}, "bad.csv: at byte"},
      {{"--rate-hz", "nan"}, "--rate-hz"},
      {{"--stiffness", "nan"}, "--stiffness: expected a number from 0 to 100000, got 'nan'"},
      {{"--seconds", "-1"}, "--seconds"},
      {{"--seconds", "nan"}, "--seconds"},
      {{"--nonsense"}, "--nonsense"},
      {{"--profile", folder_ / "malformed.toml"}, "malformed.toml:2: not valid TOML"},
      {{"--profile", folder_ / "infinite.toml"}, "infinite.toml:3: [limits]: force is nan, expected a number"},
      {{"--profile", folder_.path().string()}, "not a plain file"},
      {{"--device", "virtuose", "--library", PALP_LIB_DIR "/libincomplete_virtuose.so"}, "it has no function virt"},
      {{"--device", "virtuose", "--library", "libno_such_virtuose.so"}, "cannot be loaded"},
      {{"--log", folder_ / "bad.toml/log.csv"}, "its directory cannot be made"},
      {{"--summary", folder_ / "bad.toml/summary.json"}, "summary.json"},
      {{"--device", "virtuose", "--library", folder_ / "none.so"}, "there is no such file"},
      {{"--device", "virtuose", "--library", folder_ / "bad.toml"}, "cannot be loaded"},
      {{"--device", "virtuose", "--profile", PALP_SOURCE_DIR "/config/devices/simulated.toml"}, "[virtuose]"},
      {{"--device", "virtuose", "--virtuose-mode", "force"}, "--virtuose-mode"},
      {{"--library", "x.so"}, "--device virtuose"},
      {{"--device", "spacenav", "--library", "libno_such.so", "--home", "0", "0", "0"}, "cannot be loaded"},
      {{"--device", "virtuose", "--hand", "x"}, "--hand"},
      // at once, with no server to be heard
      {{"--device", "spacenav", "--library", "libno_such.so"}, "cannot be loaded"},
      {{"--hand", "stirr"}, "did you mean 'stir'?"},
      {{"--profile", "simulatd"}, "did you mean 'simulated'?"},
      {{"--log", folder_ / "log.txt"}, "expected a file NAME.csv, or a folder"},
      {{"--path", "x.csv"}, "--path needs --device replay"},
  };
  for (const auto& [arguments, expected] : cases) {
    SCOPED_TRACE(arguments[0] + " " + arguments.back());
    const int status = run_to_end(arguments);
    EXPECT_EQ(status, 2);
    EXPECT_NE(said().find(expected), std::string::npos) << said();
  }
}

TEST_F(BridgeProcess, RefusesALogThatItCannotWrite) {
  EXPECT_EQ(run_to_end({"--home", "0", "0", "0", "--seconds", "0.3", "--log", "/proc/none/bridge_log.csv"}), 2);
  EXPECT_NE(said().find("/proc/none"), std::string::npos) << said();
}

TEST_F(BridgeProcess, MakesTheFolderOfItsLogAndKnowsHandsByTheirNames) {
  const std::vector<std::string> short_run{"--home", "0", "0", "0", "--seconds", "0.2", "--hand", "still"};
  for (const char* folder : {"new/deep", "with_slash/"}) {
    std::vector<std::string> arguments = short_run;
    arguments.insert(arguments.end(), {"--log", folder_ / folder});
    EXPECT_EQ(run_to_end(arguments), 0) << said();
    for (const char* ending : {".csv", ".ticks", ".json"})
      EXPECT_TRUE(fs::is_regular_file(folder_.path() / folder / ("bridge_log" + std::string(ending))))
          << folder << ending;
  }
}

TEST_F(BridgeProcess, RefusesADiskWithoutRoomForItsLog) {
  const SmallDisk disk(folder_ / "disk", 2);
  if (!disk.there) GTEST_SKIP() << "no right to mount a small disk";
  EXPECT_EQ(run_to_end({"--home", "0", "0", "0", "--seconds", "0.3", "--log", (disk.path / "log.csv").string()}), 2);
  EXPECT_NE(said().find("there is no room for its"), std::string::npos) << said();
}

TEST_F(BridgeProcess, LosesNothingOnADiskThatFillsWhileItRuns) {
  const SmallDisk disk(folder_ / "disk", 8);
  if (!disk.there) GTEST_SKIP() << "no right to mount a small disk";
  ChildProcess bridge(
      command({"--home", "0", "0", "0", "--log-seconds", "5", "--log", (disk.path / "log.csv").string()}), output());
  EXPECT_TRUE(begins()) << said();
  disk.fill();
  std::this_thread::sleep_for(700ms);
  bridge.send_signal(SIGTERM);
  EXPECT_EQ(bridge.wait(10s), 0) << said();
  EXPECT_GT(FlightTable(disk.path / "log.csv").ticks(), 500u);
  EXPECT_NE(said().find("log.csv ("), std::string::npos) << said();
}

// As where a quota ends, or a disk that breaks: what was reserved cannot be written either.
TEST_F(BridgeProcess, KeepsWhatTheDiskStillTakesAndSaysSo) {
  ChildProcess bridge(command({"--home", "0", "0", "0"}), output());
  EXPECT_TRUE(begins()) << said();
  std::this_thread::sleep_for(800ms);
  const rlimit most{20'000, 20'000};  // less than a fifth of a second's rows
  ASSERT_EQ(prlimit(bridge.pid(), RLIMIT_FSIZE, &most, nullptr), 0);
  bridge.send_signal(SIGTERM);
  EXPECT_EQ(bridge.wait(10s), 1);
  EXPECT_NE(said().find("bridge_log.csv.part: cannot be written: File too large"), std::string::npos) << said();
  EXPECT_FALSE(fs::exists(folder_ / "bridge_log.csv"));
  EXPECT_EQ(fs::file_size(folder_ / "bridge_log.csv.part"), 20'000u);
}

TEST_F(BridgeProcess, LeavesItsLogWhenItCrashes) {
  ChildProcess bridge(command({"--home", "0", "0", "0"}), output());
  EXPECT_TRUE(begins()) << said();
  std::this_thread::sleep_for(300ms);
  bridge.send_signal(SIGSEGV);
  EXPECT_EQ(bridge.wait(10s), 128 + SIGSEGV);
  EXPECT_TRUE(eventually([&] { return says("the bridge has died: the flight log was written to"); })) << said();
  EXPECT_GT(FlightTable(folder_ / "bridge_log.csv").ticks(), 100u);
  EXPECT_EQ(run_to_end({"--rerun", folder_ / "bridge_log.ticks"}), 0) << said();
}

}  // namespace
}  // namespace palp::test
