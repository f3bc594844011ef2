// The viewer as people run it: the real program, and a small publisher in place of the server.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <thread>

#include <osg/Image>
#include <osgDB/ReadFile>

#include "idl/particle_sender.h"
#include "tests/support/bus.h"
#include "tests/support/eventually.h"
#include "tests/support/files.h"
#include "tests/support/process.h"
#include "tests/viewer/synthetic_scene.h"
#include "tests/viewer/x_display.h"

namespace palp::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

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
    make_look(scene.bodies[0], "custard");  // opaque, in that colour
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
  ChildProcess start(std::vector<std::string> more) {
    std::vector<std::string> arguments{std::string(PALP_BIN_DIR) + "/palp-viewer",
                                       "--headless",
                                       "--gpu",
                                       "cpu",
                                       "--gl-errors",
                                       "--size",
                                       "320x240",
                                       "--dds",
                                       to_string(GetParam()),
                                       "--domain",
                                       std::to_string(test_domain())};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return {arguments, folder_ / "log"};
  }

  ScratchFolder folder_;
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
  ChildProcess viewer = start({"--color", "body", "--png", folder_ / "p.png", "--png-every", "0.2", "--no-figures"});
  ASSERT_TRUE(eventually([&] { return exists(folder_ / "p-0002.png"); }, 20s)) << viewer.output();
  EXPECT_EQ(pixels_of(folder_ / "p-0002.png", 0), 0);
  const auto picture = [&](int n) {
    const std::string number = std::to_string(n);
    return folder_ / ("p-" + std::string(4 - number.size(), '0') + number + ".png");
  };
  const auto newest = [&] {
    int n = 1;
    while (exists(picture(n + 1))) ++n;
    return picture(n);
  };
  {
    Publisher server(GetParam(), test_domain(), {1, 0, 0});
    EXPECT_TRUE(server.publish_until([&] { return pixels_of(newest(), 0) > 3000; }, 20s)) << viewer.output();
  }
  Publisher server(GetParam(), test_domain(), {0, 1, 0});
  EXPECT_TRUE(server.publish_until([&] { return pixels_of(newest(), 1) > 3000; }, 20s)) << viewer.output();
  EXPECT_LT(pixels_of(newest(), 0), 100) << "the grain of the paddle's wood";
  viewer.send_signal(SIGTERM);
  EXPECT_EQ(viewer.wait(20s), 0) << viewer.output();
}

TEST_P(ViewerProcess, SigtermLeavesAWholePictureAndVideo) {
  Publisher server(GetParam(), test_domain(), {0, 0, 1});
  ChildProcess viewer =
      start({"--color", "speed", "--png", folder_ / "p.png", "--video", folder_ / "v.mp4", "--fps", "15"});
  // the color asked for reaches the server as a command
  EXPECT_TRUE(server.publish_until([&] { return server.commanded(CommandKind::set_parameter); }, 20s))
      << viewer.output();
  server.publish_until([] { return false; }, 1s);
  viewer.send_signal(SIGTERM);
  EXPECT_EQ(viewer.wait(20s), 0) << viewer.output();
  EXPECT_GT(pixels_of(folder_ / "p.png", 2), 300);
  const Outcome decoded = run_program({"ffmpeg", "-v", "error", "-i", folder_ / "v.mp4", "-f", "null", "-"});
  EXPECT_EQ(decoded.status, 0);
  EXPECT_EQ(decoded.output, "");
}

TEST_P(ViewerProcess, APictureOfNothingIsAFailure) {
  ChildProcess viewer = start({"--png", folder_ / "p.png", "--seconds", "0.5"});
  EXPECT_EQ(viewer.wait(20s), 1);
  EXPECT_NE(viewer.output().find("no particles arrived"), std::string::npos) << viewer.output();
}

INSTANTIATE_TEST_SUITE_P(BothVendors, ViewerProcess, testing::Values(Vendor::cyclone, Vendor::fastdds),
                         [](const auto& of) { return std::string(to_string(of.param)); });

// Without an X server there is nothing to see: Xvfb is among the packages that tests need.
TEST(ViewerWindows, ShowTheSceneAndCloseByThemselvesUntilTheFirstDoes) {
  XDisplay x;
  if (!x.open()) GTEST_SKIP() << "no Xvfb";
  const ScratchFolder folder;
  ChildProcess viewer(
      {"env", "DISPLAY=" + x.name(), "LIBGL_ALWAYS_SOFTWARE=1", std::string(PALP_BIN_DIR) + "/palp-viewer", "--windows",
       "2", "--gl-errors", "--no-settings", "--size", "320x240", "--samples", "0", "--dds", "cyclone", "--domain",
       std::to_string(test_domain())},
      folder / "log");
  Publisher server(Vendor::cyclone, test_domain(), {1, 0, 0});
  ASSERT_TRUE(server.publish_until([&] { return x.window("palp") && x.window("palp 2"); }, 20s)) << viewer.output();
  const unsigned long first = *x.window("palp"), second = *x.window("palp 2");
  x.place(second, 600, 300, 400, 300);
  const auto shown = [&](unsigned long window) { return x.red_pixels(window) > 3000; };
  EXPECT_TRUE(server.publish_until([&] { return shown(first) && x.red_pixels(second) > 6000; }, 20s))
      << viewer.output();
  EXPECT_EQ(x.size(first), std::pair(320, 240));
  x.press(first, 'w');
  EXPECT_TRUE(server.publish_until([&] { return x.window("palp 3").has_value(); }, 20s)) << viewer.output();
  x.close(second);
  EXPECT_TRUE(server.publish_until([&] { return !x.window("palp 2"); }, 20s)) << viewer.output();
  const unsigned long third = *x.window("palp 3");
  x.place(third, 600, 60, 320, 240);
  EXPECT_TRUE(server.publish_until([&] { return shown(first) && shown(third); }, 20s)) << viewer.output();
  x.close(first);
  EXPECT_EQ(viewer.wait(20s), 0) << viewer.output();
}

TEST(ViewerCommandLine, BadInputGivesOneMessageAndAFailure) {
  const std::vector<std::vector<std::string>> bad{{"--headless", "--gpu", "egl:99"},
                                                  {"--headless", "--gpu", "pci:ff:1f.7"},
                                                  {"--headless", "--gpu", "cuda:99"},
                                                  {"--headless", "--gpu", "fast"},
                                                  {"--size", "huge"},
                                                  {"--windows", "2", "--headless"},
                                                  {"--headless", "--gpu", "cpu", "--video", "/nonexistent/v.mp4"}};
  for (const auto& more : bad) {
    std::vector<std::string> arguments{std::string(PALP_BIN_DIR) + "/palp-viewer"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome viewer = run_program(arguments, 20s);
    EXPECT_TRUE(viewer.status > 0 && viewer.status < 128) << more[0] << " ended with " << viewer.status;
    EXPECT_NE(viewer.output.find(more.back()), std::string::npos) << viewer.output;
  }
}

// Mesa's software device alone is known to be there.
TEST(ViewerCommandLine, ListsTheGpusByTheNamesThatItTakes) {
  const Outcome list = run_program({std::string(PALP_BIN_DIR) + "/palp-viewer", "--gpu", "list"}, 20s);
  EXPECT_EQ(list.status, 0) << list.output;
  ASSERT_EQ(list.output.rfind("egl:0", 0), 0u) << list.output;
  const std::string software = list.output.substr(0, list.output.find("llvmpipe"));
  const std::string name = software.substr(software.rfind("egl:"), 5);
  const Outcome drawn = run_program({std::string(PALP_BIN_DIR) + "/palp-viewer", "--headless", "--gpu", name,
                                     "--domain", std::to_string(test_domain()), "--seconds", "0.1"},
                                    20s);
  EXPECT_EQ(drawn.status, 0) << drawn.output;
  EXPECT_NE(drawn.output.find("llvmpipe"), std::string::npos) << drawn.output;
}

}  // namespace
}  // namespace palp::test
