// The real haptic_bridge binary against a scripted server on the loopback interface.
#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>

#include "idl/bus.h"
#include "idl/clock.h"
#include "tests/haptic_bridge/log/small_disk.h"

extern char** environ;

namespace palp {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

// A child that is stopped, whatever becomes of the test.
class Process {
 public:
  Process(const std::vector<std::string>& arguments, const fs::path& output) {
    std::vector<char*> argv;
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions, 1, 2);
    if (posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ) != 0) pid_ = -1;
    posix_spawn_file_actions_destroy(&actions);
  }
  ~Process() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
  }
  void signal(int number) const { kill(pid_, number); }
  pid_t pid() const { return pid_; }
  // The exit status, 128 + signal, or -1 if it has not ended in time.
  int wait(std::chrono::milliseconds timeout) {
    for (auto left = timeout; left > 0ms; left -= 20ms) {
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      }
      std::this_thread::sleep_for(20ms);
    }
    return -1;
  }

 private:
  pid_t pid_ = -1;
};

// A server that pushes the device up with a constant force, as long as it lives.
class FakeServer {
 public:
  FakeServer(const BusOptions& options, std::uint32_t proxy_device = 0) : bus_(open_bus(options)) {
    scene_ = bus_->writer<SceneDescription>();
    SceneDescription scene;
    scene.name = "test";
    scene.method = "accurate";
    scene.particle_count = 0;
    scene.spacing = 0.01;
    scene.support_radius = 0.02;
    scene.haptic_rate_hz = 1000;
    scene.bodies.emplace_back();
    scene.bodies[0].name = "tool";
    scene.bodies[0].kind = BodyKind::rigid;
    ProxyDescription proxy;
    proxy.device = proxy_device;
    proxy.pose.position = {0.1, 0.2, 0.3};
    scene.proxies.push_back(proxy);
    scene_->publish(scene);
    thread_ = std::thread([this] { serve(); });
  }
  ~FakeServer() {
    stop_ = true;
    thread_.join();
  }
  std::uint64_t heard() const { return heard_; }
  std::int64_t t_last_sent_ns() const { return t_last_sent_ns_; }

 private:
  void serve() {
    const auto reader = bus_->reader<DeviceSample>();
    const auto writer = bus_->writer<ProxySample>();
    Received<DeviceSample> in;
    while (!stop_) {
      if (!reader->wait(10ms) || !reader->take_latest(in)) continue;
      ++heard_;
      const DeviceSample& d = in.message;
      ProxySample s;
      s.device = d.device;
      s.flags = kEngaged | kHealthy;
      s.device_session = d.header.session;
      s.device_sequence = d.header.sequence;
      s.t_device_ns = d.t_device_ns;
      s.device_pose = s.proxy_pose = d.pose;
      s.device_twist = s.proxy_twist = d.twist;
      s.gains = d.gains;
      s.wrench.force = {0, 0, 3};
      writer->publish(s);
      t_last_sent_ns_ = now_ns();
    }
  }

  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Writer<SceneDescription>> scene_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> heard_{0};
  std::atomic<std::int64_t> t_last_sent_ns_{0};
};

// Rows of the flight log by column name.
struct FlightTable {
  explicit FlightTable(const fs::path& path) {
    std::ifstream in(path);
    std::string line;
    std::getline(in, line);
    std::vector<std::string> names = split(line);
    while (std::getline(in, line)) {
      const std::vector<std::string> cells = split(line);
      if (cells.size() != names.size()) throw std::runtime_error("row with another number of columns: " + line);
      for (std::size_t i = 0; i < cells.size(); ++i) columns[names[i]].push_back(cells[i]);
    }
  }
  static std::vector<std::string> split(const std::string& line) {
    std::vector<std::string> cells;
    std::stringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
    return cells;
  }
  double number(const char* column, std::size_t row) const {
    return std::strtod(columns.at(column)[row].c_str(), nullptr);
  }
  std::size_t rows() const { return columns.at("tick").size(); }
  std::map<std::string, std::vector<std::string>> columns;
};

class BridgeProcess : public testing::Test {
 protected:
  void SetUp() override {
    dir_ = fs::temp_directory_path() / ("palp_bridge_test_" + std::to_string(getpid()));
    fs::create_directories(dir_);
    options_.domain = 100 + getpid() % 100;
  }
  void TearDown() override { fs::remove_all(dir_); }

  std::vector<std::string> command(std::vector<std::string> more = {}) const {
    std::vector<std::string> all{PALP_BIN_DIR "/palp-haptic-bridge", "--domain", std::to_string(options_.domain)};
    if (std::find(more.begin(), more.end(), "--log") == more.end())
      more.insert(more.end(), {"--log", (dir_ / "bridge_log.csv").string()});
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  fs::path output() const { return dir_ / "output.txt"; }
  int run_to_end(const std::vector<std::string>& more) {
    Process bridge(command(more), output());
    return bridge.wait(10s);
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

  fs::path dir_;
  BusOptions options_;
};

TEST_F(BridgeProcess, FeelsAServerLosesItAndFindsTheNextOne) {
  const auto watcher = open_bus(options_);
  const auto status = watcher->reader<Status>();
  Process bridge(command({"--hand", PALP_SOURCE_DIR "/config/hands/still.toml"}), output());
  ASSERT_TRUE(reaches(*status, "waiting", 10s)) << text_of(output());

  std::int64_t t_dead_ns = 0;
  {
    FakeServer server(options_);
    ASSERT_TRUE(reaches(*status, "engaged", 10s)) << text_of(output());
    std::this_thread::sleep_for(800ms);
    EXPECT_GT(server.heard(), 500u);
    t_dead_ns = server.t_last_sent_ns();
  }
  ASSERT_TRUE(reaches(*status, "stale", 5s)) << text_of(output());
  {
    FakeServer server(options_);
    ASSERT_TRUE(reaches(*status, "engaged", 10s)) << text_of(output());
    std::this_thread::sleep_for(800ms);
    bridge.signal(SIGTERM);
    EXPECT_EQ(bridge.wait(10s), 0) << text_of(output());
  }

  const FlightTable log(dir_ / "bridge_log.csv");
  ASSERT_GT(log.rows(), 2000u);
  double peak_before = 0, peak_dead = 0, peak_after = 0;
  for (std::size_t i = 0; i < log.rows(); ++i) {
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
  EXPECT_NE(text_of(dir_ / "bridge_log.json").find("\"stale_events\": "), std::string::npos);
  EXPECT_NE(text_of(output()).find("server was restarted"), std::string::npos);

  // all of it again, from what the loop took in
  EXPECT_EQ(run_to_end({"--rerun", (dir_ / "bridge_log.ticks").string()}), 0) << text_of(output());
  EXPECT_NE(text_of(output()).find(": " + std::to_string(log.rows()) + " ticks, identical"), std::string::npos)
      << text_of(output());
}

TEST_F(BridgeProcess, SpeaksFastDdsToACycloneServer) {
  options_.vendor = Vendor::cyclone;
  const auto watcher = open_bus(options_);
  const auto status = watcher->reader<Status>();
  FakeServer server(options_);
  Process bridge(command({"--dds", "fastdds", "--seconds", "3"}), output());
  EXPECT_TRUE(reaches(*status, "engaged", 10s)) << text_of(output());
  EXPECT_EQ(bridge.wait(10s), 0) << text_of(output());
  EXPECT_NE(text_of(output()).find("fastdds"), std::string::npos);
}

TEST_F(BridgeProcess, ReplaysAPathWithoutAServer) {
  std::ofstream(dir_ / "path.csv") << "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n1,0.1,0,0,0,0,0,1\n";
  EXPECT_EQ(run_to_end({"--device", "replay", "--path", (dir_ / "path.csv").string(), "--seconds", "1.2"}), 0);
  const FlightTable log(dir_ / "bridge_log.csv");
  EXPECT_EQ(log.rows(), 1200u);
  EXPECT_NEAR(log.number("device_x", log.rows() - 1), 0.1, 1e-9);
  EXPECT_EQ(log.columns.at("state").back(), "waiting");
}

TEST_F(BridgeProcess, IsStoppedCleanlyWhileItWaitsAndSaysWhyItWaits) {
  Process bridge(command(), output());
  std::this_thread::sleep_for(700ms);
  bridge.signal(SIGINT);
  EXPECT_EQ(bridge.wait(5s), 0);
  EXPECT_NE(text_of(output()).find("no sim_server is heard"), std::string::npos) << text_of(output());
}

TEST_F(BridgeProcess, SaysThatTheSceneHasNoProxyForIt) {
  FakeServer server(options_, 3);
  Process bridge(command({"--device-number", "1"}), output());
  for (int i = 0; i < 100 && text_of(output()).find("no proxy") == std::string::npos; ++i)
    std::this_thread::sleep_for(50ms);
  EXPECT_NE(text_of(output()).find("scene 'test' has no proxy for device 1 (it has 3)"), std::string::npos)
      << text_of(output());
}

TEST_F(BridgeProcess, RefusesBadInputWithOneClearMessage) {
  std::ofstream(dir_ / "bad.toml") << "name = \"x\"\n[limits]\nforce = -3\n[arm]\nmas = 1\n";
  std::ofstream(dir_ / "bad.csv") << "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n0,0,0,0,0,0,0,1\n";
  std::ofstream(dir_ / "malformed.toml") << "name = \"x\"\n[limits\nforce = 3\n";
  std::ofstream(dir_ / "infinite.toml") << "name = \"x\"\n[limits]\nforce = nan\ntorque = 1\n";
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--profile", (dir_ / "bad.toml").string()}, "bad.toml:3"},
      {{"--profile", (dir_ / "bad.toml").string()}, "bad.toml:5"},
      {{"--profile", (dir_ / "none.toml").string()}, "none.toml"},
      {{"--hand", (dir_ / "bad.toml").string()}, "bad.toml"},
      {{"--device", "replay", "--path", (dir_ / "bad.csv").string()}, "bad.csv:3"},
      {{"--device", "replay"}, "--path"},
      {{"--device", "puppet"}, "puppet"},
      {{"--hand", "x", "--device", "replay", "--path", "y"}, "--hand"},
      {{"--home", "1", "2", "3", "4"}, "--home"},
      {{"--home", "1", "2", "nan"}, "--home"},
      {{"--device-number", "8"}, "--device-number"},
      {{"--rate-hz", "0"}, "--rate-hz"},
      {{"--rerun", (dir_ / "bad.csv").string()}, "bad.csv: at byte"},
      {{"--rate-hz", "nan"}, "--rate-hz"},
      {{"--stiffness", "nan"}, "--stiffness: expected a number from 0 to 100000, got 'nan'"},
      {{"--seconds", "-1"}, "--seconds"},
      {{"--seconds", "nan"}, "--seconds"},
      {{"--nonsense"}, "--nonsense"},
      {{"--profile", (dir_ / "malformed.toml").string()}, "malformed.toml:2: not valid TOML"},
      {{"--profile", (dir_ / "infinite.toml").string()}, "infinite.toml:3: [limits]: force is nan, expected a number"},
      {{"--profile", dir_.string()}, "not a plain file"},
      {{"--device", "virtuose", "--library", PALP_LIB_DIR "/libincomplete_virtuose.so"}, "it has no function virt"},
      {{"--device", "virtuose", "--library", "libno_such_virtuose.so"}, "cannot be loaded"},
      {{"--log", (dir_ / "bad.toml" / "log.csv").string()}, "its directory cannot be made"},
      {{"--summary", (dir_ / "bad.toml" / "summary.json").string()}, "summary.json"},
      {{"--device", "virtuose", "--library", (dir_ / "none.so").string()}, "there is no such file"},
      {{"--device", "virtuose", "--library", (dir_ / "bad.toml").string()}, "cannot be loaded"},
      {{"--device", "virtuose", "--profile", PALP_SOURCE_DIR "/config/devices/simulated.toml"}, "[virtuose]"},
      {{"--device", "virtuose", "--virtuose-mode", "force"}, "--virtuose-mode"},
      {{"--library", "x.so"}, "--device virtuose"},
      {{"--device", "spacenav", "--library", "libno_such.so", "--home", "0", "0", "0"}, "cannot be loaded"},
      {{"--device", "virtuose", "--hand", "x"}, "--hand"},
      // at once, with no server to be heard
      {{"--device", "spacenav", "--library", "libno_such.so"}, "cannot be loaded"},
      {{"--hand", "stirr"}, "did you mean 'stir'?"},
      {{"--profile", "simulatd"}, "did you mean 'simulated'?"},
      {{"--log", (dir_ / "log.txt").string()}, "expected a file NAME.csv, or a folder"},
      {{"--path", "x.csv"}, "--path needs --device replay"},
  };
  for (const auto& [arguments, expected] : cases) {
    SCOPED_TRACE(arguments[0] + " " + arguments.back());
    const int status = run_to_end(arguments);
    EXPECT_EQ(status, 2);
    EXPECT_NE(text_of(output()).find(expected), std::string::npos) << text_of(output());
  }
}

TEST_F(BridgeProcess, RefusesALogThatItCannotWrite) {
  EXPECT_EQ(run_to_end({"--home", "0", "0", "0", "--seconds", "0.3", "--log", "/proc/none/bridge_log.csv"}), 2);
  EXPECT_NE(text_of(output()).find("/proc/none"), std::string::npos) << text_of(output());
}

TEST_F(BridgeProcess, MakesTheFolderOfItsLogAndKnowsHandsByTheirNames) {
  const std::vector<std::string> short_run{"--home", "0", "0", "0", "--seconds", "0.2", "--hand", "still"};
  for (const char* folder : {"new/deep", "with_slash/"}) {
    std::vector<std::string> arguments = short_run;
    arguments.insert(arguments.end(), {"--log", (dir_ / folder).string()});
    EXPECT_EQ(run_to_end(arguments), 0) << text_of(output());
    for (const char* ending : {".csv", ".ticks", ".json"})
      EXPECT_TRUE(fs::is_regular_file(dir_ / folder / ("bridge_log" + std::string(ending)))) << folder << ending;
  }
}

TEST_F(BridgeProcess, RefusesADiskWithoutRoomForItsLog) {
  const test::SmallDisk disk(dir_ / "disk", 2);
  if (!disk.there) GTEST_SKIP() << "no right to mount a small disk";
  EXPECT_EQ(run_to_end({"--home", "0", "0", "0", "--seconds", "0.3", "--log", (disk.path / "log.csv").string()}), 2);
  EXPECT_NE(text_of(output()).find("there is no room for its"), std::string::npos) << text_of(output());
}

TEST_F(BridgeProcess, LosesNothingOnADiskThatFillsWhileItRuns) {
  const test::SmallDisk disk(dir_ / "disk", 8);
  if (!disk.there) GTEST_SKIP() << "no right to mount a small disk";
  Process bridge(command({"--home", "0", "0", "0", "--log-seconds", "5", "--log", (disk.path / "log.csv").string()}),
                 output());
  for (int i = 0; i < 100 && text_of(output()).find("the loop runs") == std::string::npos; ++i)
    std::this_thread::sleep_for(50ms);
  disk.fill();
  std::this_thread::sleep_for(700ms);
  bridge.signal(SIGTERM);
  EXPECT_EQ(bridge.wait(10s), 0) << text_of(output());
  EXPECT_GT(FlightTable(disk.path / "log.csv").rows(), 500u);
  EXPECT_NE(text_of(output()).find("log.csv ("), std::string::npos) << text_of(output());
}

// As where a quota ends, or a disk that breaks: what was reserved cannot be written either.
TEST_F(BridgeProcess, KeepsWhatTheDiskStillTakesAndSaysSo) {
  Process bridge(command({"--home", "0", "0", "0"}), output());
  for (int i = 0; i < 100 && text_of(output()).find("the loop runs") == std::string::npos; ++i)
    std::this_thread::sleep_for(50ms);
  std::this_thread::sleep_for(800ms);
  const rlimit most{100'000, 100'000};
  ASSERT_EQ(prlimit(bridge.pid(), RLIMIT_FSIZE, &most, nullptr), 0);
  bridge.signal(SIGTERM);
  EXPECT_EQ(bridge.wait(10s), 1);
  EXPECT_NE(text_of(output()).find("bridge_log.csv.part: cannot be written: File too large"), std::string::npos)
      << text_of(output());
  EXPECT_FALSE(fs::exists(dir_ / "bridge_log.csv"));
  EXPECT_EQ(fs::file_size(dir_ / "bridge_log.csv.part"), 100'000u);
}

TEST_F(BridgeProcess, WritesItsLogWhenItCrashes) {
  Process bridge(command({"--home", "0", "0", "0"}), output());
  for (int i = 0; i < 100 && text_of(output()).find("the loop runs") == std::string::npos; ++i)
    std::this_thread::sleep_for(50ms);
  std::this_thread::sleep_for(300ms);
  bridge.signal(SIGSEGV);
  EXPECT_EQ(bridge.wait(10s), 128 + SIGSEGV);
  EXPECT_GT(FlightTable(dir_ / "bridge_log.csv").rows(), 100u);
  EXPECT_EQ(run_to_end({"--rerun", (dir_ / "bridge_log.ticks").string()}), 0) << text_of(output());
}

}  // namespace
}  // namespace palp
