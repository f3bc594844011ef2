// The viewer as people run it: the real program, and a small publisher in place of the server.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <thread>

#include <osg/Image>
#include <osgDB/ReadFile>

#include "idl/particle_sender.h"
#include "tests/viewer/synthetic_scene.h"

extern char** environ;

namespace palp::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

bool eventually(const std::function<bool()>& done, Clock::duration limit) {
  for (const auto end = Clock::now() + limit; Clock::now() < end; std::this_thread::sleep_for(5ms)) {
    if (done()) return true;
  }
  return done();
}

class Process {
 public:
  Process(std::vector<std::string> arguments, const std::string& log) : log_(log) {
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ) != 0) pid_ = -1;
    posix_spawn_file_actions_destroy(&actions);
  }
  ~Process() {
    if (pid_ > 0 && !ended_) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
  }
  void signal(int number) const { kill(pid_, number); }
  // The exit status, or -1 if it did not end in time or was killed.
  int wait(Clock::duration limit) {
    int status = 0;
    ended_ = eventually([&] { return waitpid(pid_, &status, WNOHANG) == pid_; }, limit);
    return ended_ && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string log() const {
    std::ifstream in(log_);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }

 private:
  std::string log_;
  pid_t pid_ = -1;
  bool ended_ = false;
};

// Publishes the synthetic scene as a server does.
class Publisher {
 public:
  Publisher(Vendor vendor, int domain, std::array<float, 3> water) {
    BusOptions options;
    options.vendor = vendor;
    options.domain = domain;
    bus_ = open_bus(options);
    scene_ = bus_->writer<SceneDescription>();
    poses_ = bus_->writer<BodyPoses>();
    proxies_ = bus_->writer<ProxySample>();
    status_ = bus_->writer<Status>();
    commands_ = bus_->reader<Command>();
    sender_ = std::make_unique<ParticleSender>(bus_->writer<ParticleChunk>());
    SceneDescription scene = synthetic_scene().scene;
    scene.bodies[0].color = water;
    scene.scene_hash = bus_->session();
    EXPECT_TRUE(scene_->publish(scene));
  }

  void publish() {
    SyntheticScene s = synthetic_scene(0.01 * count_);
    // the scene has a fixed number of particles; the formula has not
    const std::size_t n = synthetic_scene().scene.particle_count;
    s.frame.positions.resize(3 * n, 0.0f);
    s.frame.scalars.resize(n, 0.0f);
    s.frame.frame = static_cast<std::uint64_t>(++count_);
    sender_->frame() = s.frame;
    sender_->submit();
    poses_->publish(s.poses);
    proxies_->publish(s.proxy);
    Status status;
    status.process = "sim_server";
    status.state = "running";
    status.metrics = {{"real_time_factor", 1}, {"step_p50_us", 400}};
    status_->publish(status);
  }

  // Publishes at 30 Hz until done() or the time is up.
  bool publish_until(const std::function<bool()>& done, Clock::duration limit) {
    for (const auto end = Clock::now() + limit; Clock::now() < end; std::this_thread::sleep_for(33ms)) {
      publish();
      if (done()) return true;
    }
    return false;
  }

  bool commanded(CommandKind kind) {
    std::vector<Received<Command>> commands;
    commands_->take_all(commands);
    for (const auto& c : commands) seen_ = seen_ || c.message.kind == kind;
    return seen_;
  }

 private:
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Writer<SceneDescription>> scene_;
  std::unique_ptr<Writer<BodyPoses>> poses_;
  std::unique_ptr<Writer<ProxySample>> proxies_;
  std::unique_ptr<Writer<Status>> status_;
  std::unique_ptr<Reader<Command>> commands_;
  std::unique_ptr<ParticleSender> sender_;
  int count_ = 0;
  bool seen_ = false;
};

class ViewerProcess : public testing::TestWithParam<Vendor> {
 protected:
  void SetUp() override {
    directory_ = std::filesystem::temp_directory_path() / ("palp_viewer_" + std::to_string(getpid()));
    std::filesystem::create_directories(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  std::string path(const std::string& name) const { return (directory_ / name).string(); }
  int domain() const { return 100 + static_cast<int>(getpid() % 101); }
  Process start(std::vector<std::string> more) {
    std::vector<std::string> arguments{std::string(PALP_BIN_DIR) + "/palp-viewer",
                                       "--headless",
                                       "--gpu",
                                       "cpu",
                                       "--size",
                                       "320x240",
                                       "--dds",
                                       to_string(GetParam()),
                                       "--domain",
                                       std::to_string(domain())};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return {arguments, path("log")};
  }

  std::filesystem::path directory_;
};

// Pixels whose strongest channel (0 r, 1 g, 2 b) is that one by far.
int pixels_of(const std::string& file, int channel) {
  osg::ref_ptr<osg::Image> image = osgDB::readRefImageFile(file);
  if (!image) return -1;
  int count = 0;
  for (int y = 0; y < image->t(); ++y) {
    for (int x = 0; x < image->s(); ++x) {
      const osg::Vec4f c = image->getColor(static_cast<unsigned>(x), static_cast<unsigned>(y));
      const float other = std::max(c[(channel + 1) % 3], c[(channel + 2) % 3]);
      count += c[channel] > 0.3f && c[channel] > 1.8f * other;
    }
  }
  return count;
}

bool exists(const std::string& file) { return std::filesystem::exists(file); }

TEST_P(ViewerProcess, StartsBeforeTheServerAndFollowsItsRestart) {
  Process viewer = start({"--color", "body", "--png", path("p.png"), "--png-every", "0.2", "--no-figures"});
  ASSERT_TRUE(eventually([&] { return exists(path("p-0002.png")); }, 20s)) << viewer.log();
  EXPECT_EQ(pixels_of(path("p-0002.png"), 0), 0);
  const auto newest = [&] {
    int n = 1;
    while (exists(path("p-" + std::string(4 - std::to_string(n + 1).size(), '0') + std::to_string(n + 1) + ".png")))
      ++n;
    return path("p-" + std::string(4 - std::to_string(n).size(), '0') + std::to_string(n) + ".png");
  };
  {
    Publisher server(GetParam(), domain(), {1, 0, 0});
    EXPECT_TRUE(server.publish_until([&] { return pixels_of(newest(), 0) > 3000; }, 20s)) << viewer.log();
  }
  Publisher server(GetParam(), domain(), {0, 1, 0});
  EXPECT_TRUE(server.publish_until([&] { return pixels_of(newest(), 1) > 3000; }, 20s)) << viewer.log();
  EXPECT_EQ(pixels_of(newest(), 0), 0);
  viewer.signal(SIGTERM);
  EXPECT_EQ(viewer.wait(20s), 0) << viewer.log();
}

TEST_P(ViewerProcess, SigtermLeavesAWholePictureAndVideo) {
  Publisher server(GetParam(), domain(), {0, 0, 1});
  Process viewer = start({"--color", "speed", "--png", path("p.png"), "--video", path("v.mp4"), "--fps", "15"});
  // the color asked for reaches the server as a command
  EXPECT_TRUE(server.publish_until([&] { return server.commanded(CommandKind::set_parameter); }, 20s)) << viewer.log();
  server.publish_until([] { return false; }, 1s);
  viewer.signal(SIGTERM);
  EXPECT_EQ(viewer.wait(20s), 0) << viewer.log();
  EXPECT_GT(pixels_of(path("p.png"), 2), 300);
  const std::string check = "ffmpeg -v error -i '" + path("v.mp4") + "' -f null - 2> '" + path("errors") + "'";
  EXPECT_EQ(std::system(check.c_str()), 0);
  EXPECT_EQ(std::filesystem::file_size(path("errors")), 0u);
}

TEST_P(ViewerProcess, APictureOfNothingIsAFailure) {
  Process viewer = start({"--png", path("p.png"), "--seconds", "0.5"});
  EXPECT_EQ(viewer.wait(20s), 1);
  EXPECT_NE(viewer.log().find("no particles arrived"), std::string::npos) << viewer.log();
}

INSTANTIATE_TEST_SUITE_P(BothVendors, ViewerProcess, testing::Values(Vendor::cyclone, Vendor::fastdds),
                         [](const auto& of) { return std::string(to_string(of.param)); });

TEST(ViewerCommandLine, BadInputGivesOneMessageAndAFailure) {
  const std::string log = (std::filesystem::temp_directory_path() / ("palp_log_" + std::to_string(getpid()))).string();
  const std::vector<std::vector<std::string>> bad{{"--headless", "--gpu", "egl:99"},
                                                  {"--size", "huge"},
                                                  {"--headless", "--gpu", "cpu", "--video", "/nonexistent/v.mp4"}};
  for (const auto& more : bad) {
    std::vector<std::string> arguments{std::string(PALP_BIN_DIR) + "/palp-viewer"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Process viewer(arguments, log);
    EXPECT_GT(viewer.wait(20s), 0) << more[0];
    EXPECT_NE(viewer.log().find(more.back()), std::string::npos) << viewer.log();
  }
  std::filesystem::remove(log);
}

}  // namespace
}  // namespace palp::test
