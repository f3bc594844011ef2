// A run of the real processes is recorded and played back with no server: readers of either vendor get every payload in
// order, and a viewer draws it.
#include "tests/process/running_system.h"
#include "tests/support/recordings.h"
#include "tools/recording/raw_bus.h"

namespace palp::test::recording_test {
namespace {

const TopicRow* const kWatched[] = {&topic_of<SceneDescription>(), &topic_of<ProxySample>(), &topic_of<ParticleChunk>(),
                                    &topic_of<Event>()};

class Recording : public RunningSystem, public testing::WithParamInterface<Vendor> {
 protected:
  // Records a run in which the hand felt the fluid, to run.mcap.
  void record() {
    Watcher& watcher = watch();
    auto recorder = start_tool("palp-record", other(), {"--out", folder_ / "run.mcap"});
    start_server();
    start_bridge(Vendor::fastdds);
    EXPECT_TRUE(force_is_felt(watcher)) << said();
    const double felt_at = watcher.proxy.sim_time;
    EXPECT_TRUE(watcher.sees([&] { return watcher.proxy.sim_time > felt_at + 1; })) << said();
    EXPECT_EQ(recorder->stop(), 0) << said();
    stop_bridge();
    stop_server();
  }
  Vendor other() const { return GetParam() == Vendor::cyclone ? Vendor::fastdds : Vendor::cyclone; }
};

TEST_P(Recording, FeedsReadersAndAViewerWithNoServer) {
  record();
  auto expected = payloads_by_topic(folder_ / "run.mcap");
  const auto bus = open_raw_bus(on(GetParam()));
  std::vector<std::unique_ptr<RawReader>> readers;
  std::map<std::string, std::vector<Bytes>> heard;
  std::size_t wanted = 0;
  for (const TopicRow* topic : kWatched) {
    EXPECT_FALSE(expected[topic->name].empty()) << topic->name;
    wanted += expected[topic->name].size();
    readers.push_back(bus->reader(*topic, 1000));
  }
  start_viewer(GetParam(), {"--png", folder_ / "picture.png"});
  Watcher& watcher = watch();
  watcher.status.clear();
  ASSERT_TRUE(watcher.sees([&] { return watcher.says("viewer", "waiting"); })) << said();

  auto replay = start_tool("palp-replay", other(), {folder_ / "run.mcap", "--wait-readers", "10"});
  std::size_t count = 0;
  EXPECT_TRUE(eventually(
      [&] {
        for (std::size_t i = 0; i < readers.size(); ++i)
          count += readers[i]->take(
              [&](Payload p, std::int64_t) { heard[kWatched[i]->name].emplace_back(p.begin(), p.end()); });
        return count >= wanted;
      },
      kPatience))
      << count << " of " << wanted << "\n"
      << said();
  EXPECT_EQ(replay->wait(), 0) << said();
  for (const TopicRow* topic : kWatched) {
    ASSERT_EQ(heard[topic->name].size(), expected[topic->name].size()) << topic->name;
    EXPECT_TRUE(heard[topic->name] == expected[topic->name]) << topic->name;
  }
  stop_viewer();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "picture.png"));
}

INSTANTIATE_TEST_SUITE_P(Readers, Recording, testing::Values(Vendor::cyclone, Vendor::fastdds),
                         [](const auto& of) { return std::string(to_string(of.param)); });

}  // namespace
}  // namespace palp::test::recording_test
