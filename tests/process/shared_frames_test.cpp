// How particles reach a viewer on the server's host: by shared memory, beside either vendor's bus, and over the bus
// where that cannot be had.
#include <unistd.h>

#include <filesystem>

#include "idl/frame_ring.h"
#include "tests/process/running_system.h"

namespace palp::test::shared_frames_test {
namespace {

class SharedFrames : public RunningSystem, public testing::WithParamInterface<Vendor> {
 protected:
  // Returns the rings in this test's domain.
  std::vector<std::string> rings() const {
    RingPlace place;
    place.domain = domain_;
    std::string start = path_of(place);
    start.erase(start.rfind('-') + 1);
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(place.folder))
      if (entry.path().string().starts_with(start)) found.push_back(entry.path());
    return found;
  }
  bool server_is_there(Watcher& watcher) {
    return watcher.sees([&] { return watcher.says("sim_server", "running") && rings().size() == 1; });
  }
  // A viewer that is modest gets no share of a machine that others keep busy.
  void start_awake_viewer(Vendor vendor) { start_viewer(vendor, {"--nice", "0"}); }
  Vendor other() const { return GetParam() == Vendor::cyclone ? Vendor::fastdds : Vendor::cyclone; }
  double figure(const std::string& name) const { return number_in_json(summary("palp-viewer"), name); }
  // Stops both; all frames that the viewer got came by this way.
  void expect_all_frames_came(bool by_shared_memory) {
    stop_viewer();
    EXPECT_GT(figure("complete_frames"), 3) << said();
    EXPECT_EQ(figure("shared_frames"), by_shared_memory ? figure("complete_frames") : 0) << said();
    EXPECT_EQ(figure("refused_samples"), 0) << said();
    stop_server();
    const std::string server = summary("palp-sim-server");
    EXPECT_EQ(number_in_json(server, "frames") > 0, !by_shared_memory) << server;
    EXPECT_EQ(number_in_json(server, "shared_frames") > 0, by_shared_memory) << server;
  }
};

TEST_P(SharedFrames, AViewerOnTheServersHostTakesAllFramesFromThere) {
  Watcher& watcher = watch();
  start_server(GetParam());
  start_awake_viewer(GetParam());
  ASSERT_TRUE(viewer_draws(watcher)) << said();
  EXPECT_NE(viewer_->output().find("particles come by shared memory"), std::string::npos) << said();
  expect_all_frames_came(true);
  EXPECT_TRUE(rings().empty());
}

TEST_P(SharedFrames, ViewersOfBothVendorsThatComeAndGoShareOneRing) {
  Watcher& watcher = watch();
  start_server(GetParam());
  ASSERT_TRUE(server_is_there(watcher)) << said();
  start_awake_viewer(other());
  ASSERT_TRUE(viewer_draws(watcher)) << said();
  const std::vector<std::string> command{kBin + "palp-viewer",
                                         "--headless",
                                         "--gpu",
                                         "cpu",
                                         "--size",
                                         "320x240",
                                         "--fps",
                                         "2",
                                         "--nice",
                                         "0",
                                         "--summary",
                                         folder_ / "second.json",
                                         "--dds",
                                         to_string(GetParam()),
                                         "--domain",
                                         std::to_string(domain_)};
  const auto second = std::make_unique<ChildProcess>(command, folder_ / "second.txt");
  ASSERT_TRUE(eventually([&] { return second->output().find("by shared memory") != std::string::npos; }, kPatience));
  viewer_->stop(SIGKILL);
  const double shared = watcher.metric("sim_server", "shared_frames");
  EXPECT_TRUE(watcher.sees([&] { return watcher.metric("sim_server", "shared_frames") > shared + 10; })) << said();
  EXPECT_EQ(second->stop(), 0) << second->output();
  EXPECT_GT(number_in_json(text_of(folder_ / "second.json"), "shared_frames"), 0);
  // nobody looks any more
  EXPECT_TRUE(watcher.sees([&] {
    const double now = watcher.metric("sim_server", "shared_frames");
    return watcher.hears_news_of("sim_server") && watcher.metric("sim_server", "shared_frames") == now;
  }));
  start_awake_viewer(GetParam());
  watcher.status.erase("viewer");
  ASSERT_TRUE(viewer_draws(watcher)) << said();
  expect_all_frames_came(true);
}

TEST_P(SharedFrames, TheNextServerRemovesWhatAKilledOneLeftAndTheViewerFollowsIt) {
  Watcher& watcher = watch();
  start_server(GetParam());
  start_awake_viewer(GetParam());
  ASSERT_TRUE(viewer_draws(watcher)) << said();
  const std::vector<std::string> before = rings();
  ASSERT_EQ(before.size(), 1u);
  server_->stop(SIGKILL);
  EXPECT_EQ(rings(), before) << "nobody was left to take it away";

  start_server(GetParam());
  watcher.status.erase("viewer");
  const auto shared = [&] { return watcher.metric("viewer", "shared_frames"); };
  ASSERT_TRUE(watcher.sees([&] { return shared() > 0; }));
  const double frames = shared();
  ASSERT_TRUE(watcher.sees([&] { return shared() > frames + 10; })) << said();
  const std::vector<std::string> after = rings();
  EXPECT_EQ(after.size(), 1u);
  EXPECT_NE(after, before);
  expect_all_frames_came(true);
}

TEST_P(SharedFrames, WhereThereIsNoneParticlesComeOverTheBus) {
  Watcher& watcher = watch();
  start_server(GetParam());
  ASSERT_TRUE(server_is_there(watcher)) << said();
  std::filesystem::remove(rings().front());  // as in another container, or on another host
  start_awake_viewer(GetParam());
  ASSERT_TRUE(viewer_draws(watcher)) << said();
  EXPECT_NE(viewer_->output().find("particles come over the bus"), std::string::npos) << said();
  expect_all_frames_came(false);
}

TEST_P(SharedFrames, WhereItIsRefusedParticlesComeOverTheBus) {
  Watcher& watcher = watch();
  start_server(GetParam());
  ASSERT_TRUE(server_is_there(watcher)) << said();
  ASSERT_EQ(truncate(rings().front().c_str(), 4096), 0);
  start_awake_viewer(other());
  ASSERT_TRUE(viewer_draws(watcher)) << said();
  EXPECT_NE(viewer_->output().find("is not the ring of frames of this server"), std::string::npos) << said();
  expect_all_frames_came(false);
}

TEST_P(SharedFrames, AViewerWhoseSharedMemoryIsClosedGoesOnOverTheBus) {
  Watcher& watcher = watch();
  start_server(GetParam());
  start_awake_viewer(GetParam());
  ASSERT_TRUE(viewer_draws(watcher)) << said();
  const std::string ring = rings().front();
  // what is cut off comes again with the server's next frame, unless the viewer looks before
  ASSERT_TRUE(watcher.sees([&] {
    return truncate(ring.c_str(), 0) == 0 && viewer_->output().find("over the bus") != std::string::npos;
  })) << said();
  ASSERT_TRUE(watcher.sees([&] { return watcher.metric("sim_server", "frames") > 3; })) << said();
  ASSERT_TRUE(watcher.hears_news_of("viewer"));
  const double shared = watcher.metric("viewer", "shared_frames"), all = watcher.metric("viewer", "frames");
  EXPECT_TRUE(watcher.sees([&] { return watcher.metric("viewer", "frames") > all + 3; })) << said();
  EXPECT_EQ(watcher.metric("viewer", "shared_frames"), shared) << said();
  stop_viewer();
  stop_server();
}

INSTANTIATE_TEST_SUITE_P(Vendors, SharedFrames, testing::Values(Vendor::cyclone, Vendor::fastdds),
                         [](const auto& vendor) { return std::string(to_string(vendor.param)); });

}  // namespace
}  // namespace palp::test::shared_frames_test
