// The real palp-record, palp-replay and palp-info on the loopback interface, each test in a DDS domain of its own.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <thread>

#include "idl/bus.h"
#include "tests/support/eventually.h"
#include "tests/support/process.h"
#include "tests/support/recordings.h"
#include "tests/tools/talker.h"
#include "tools/recording/raw_bus.h"

namespace palp::test {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 20s;

const std::string kBin = PALP_BIN_DIR "/";
const std::string kIndependentReader = PALP_SOURCE_DIR "/tests/tools/independent_reader.py";

int unused_domain() {
  static int next = 20 + static_cast<int>(getpid() % 100) * 2;
  return next++;
}

std::vector<std::string> program(const std::string& name, const std::string& file, Vendor vendor, int domain) {
  return {kBin + name, file, "--dds", to_string(vendor), "--domain", std::to_string(domain)};
}
std::vector<std::string> recorder(const std::string& file, Vendor vendor, int domain) {
  std::vector<std::string> command = program("palp-record", "--out=" + file, vendor, domain);
  return command;
}
std::vector<std::string> with(std::vector<std::string> command, const std::vector<std::string>& more) {
  command.insert(command.end(), more.begin(), more.end());
  return command;
}

std::string read_independently(const ScratchFolder& folder, const std::string& file, const std::string& topic = {}) {
  std::vector<std::string> command{kIndependentReader, file};
  if (!topic.empty()) command.insert(command.end(), {"--print", topic});
  ChildProcess reader(command, folder / "independent.txt");
  EXPECT_EQ(reader.wait(), 0) << reader.output();
  return reader.output();
}

// A recorder may know its writers later than they know it, and what they say before is lost.
bool eventually_hears(const ChildProcess& recorder, int writers) {
  const std::string said = fmt::format("  {} writers", writers);
  return eventually([&] { return recorder.output().find(said) != std::string::npos; }, kPatience);
}

// A recording of `steps` steps in folder / "a.mcap".
std::map<std::string, std::size_t> record_something(const ScratchFolder& folder, Vendor vendor, int steps,
                                                    const std::vector<std::string>& more = {}) {
  const int domain = unused_domain();
  Talker talker(domain);
  ChildProcess record(with(recorder(folder / "a.mcap", vendor, domain), more), folder / "record.txt");
  EXPECT_TRUE(eventually([&] { return talker.heard(); }, kPatience)) << record.output();
  EXPECT_TRUE(eventually_hears(record, 6)) << record.output();
  for (int i = 0; i < steps; ++i) talker.say(i);
  std::this_thread::sleep_for(200ms);
  EXPECT_EQ(record.stop(), 0) << record.output();
  return talker.said();
}

struct Pairing {
  Vendor recorder;
  Vendor replayer;
};

void PrintTo(const Pairing& pairing, std::ostream* out) {
  *out << to_string(pairing.recorder) << " records, " << to_string(pairing.replayer) << " replays";
}

class RecordReplay : public testing::TestWithParam<Pairing> {};

TEST_P(RecordReplay, GivesEveryReaderTheSameBytesInTheSameOrder) {
  const ScratchFolder folder;
  const auto said = record_something(folder, GetParam().recorder, 300);
  const auto first = payloads_by_topic(folder / "a.mcap");
  for (const auto& [topic, count] : said) {
    ASSERT_TRUE(first.contains(topic)) << topic;
    EXPECT_EQ(first.at(topic).size(), count) << topic;
  }

  const int domain = unused_domain();
  ChildProcess again(recorder(folder / "b.mcap", GetParam().recorder, domain), folder / "again.txt");
  ChildProcess replay(with(program("palp-replay", folder / "a.mcap", GetParam().replayer, domain),
                           {"--wait-readers", std::to_string(said.size())}),
                      folder / "replay.txt");
  EXPECT_EQ(replay.wait(), 0) << replay.output();
  EXPECT_NE(replay.output().find("lateness"), std::string::npos) << replay.output();
  EXPECT_EQ(again.stop(), 0) << again.output();
  const auto second = payloads_by_topic(folder / "b.mcap");
  for (const auto& [topic, payloads] : first) {
    ASSERT_TRUE(second.contains(topic)) << topic;
    std::string missing;  // places
    for (std::size_t i = 0; i < payloads.size(); ++i)
      if (std::find(second.at(topic).begin(), second.at(topic).end(), payloads[i]) == second.at(topic).end())
        missing += " " + std::to_string(i);
    EXPECT_EQ(second.at(topic).size(), payloads.size()) << topic << " lacks those at" << missing;
    EXPECT_TRUE(second.at(topic) == payloads) << topic;
  }
  read_independently(folder, folder / "b.mcap");
}

INSTANTIATE_TEST_SUITE_P(
    Vendors, RecordReplay,
    testing::Values(Pairing{Vendor::cyclone, Vendor::cyclone}, Pairing{Vendor::cyclone, Vendor::fastdds},
                    Pairing{Vendor::fastdds, Vendor::cyclone}, Pairing{Vendor::fastdds, Vendor::fastdds}),
    [](const auto& pairing) {
      return std::string(to_string(pairing.param.recorder)) + "_" + to_string(pairing.param.replayer);
    });

TEST(Record, AnIndependentReaderDecodesTheFile) {
  const ScratchFolder folder;
  record_something(folder, Vendor::cyclone, 101);
  const std::string proxy = read_independently(folder, folder / "a.mcap", "palp/proxy");
  EXPECT_EQ(std::count(proxy.begin(), proxy.end(), '\n'), 101);
  EXPECT_NE(proxy.find("\"force\": [1.5, 50.0, -3.0]"), std::string::npos) << proxy.substr(0, 1000);
  const std::string scene = read_independently(folder, folder / "a.mcap", "palp/scene");
  EXPECT_NE(scene.find("\"name\": \"a tray\""), std::string::npos) << scene;
  EXPECT_NE(scene.find("\"name\": \"water\""), std::string::npos) << scene;
  ChildProcess info({kBin + "palp-info", folder / "a.mcap"}, folder / "info.txt");
  EXPECT_EQ(info.wait(), 0);
  EXPECT_NE(info.output().find("palp::wire::ProxySample"), std::string::npos) << info.output();
}

TEST(Record, KeepsChosenTopicsAndEveryNthFrame) {
  const ScratchFolder folder;
  const int domain = unused_domain();
  Talker talker(domain);
  ChildProcess record(with(recorder(folder / "a.mcap", Vendor::cyclone, domain),
                           {"--topics", "particles,palp/proxy", "--decimate", "particles=2,proxy=10", "--summary",
                            folder / "summary.json"}),
                      folder / "record.txt");
  ASSERT_TRUE(eventually([&] { return talker.heard_chosen(); }, kPatience)) << record.output();
  ASSERT_TRUE(eventually_hears(record, 2)) << record.output();
  for (int i = 0; i < 200; ++i) talker.say(i);
  EXPECT_EQ(record.stop(SIGINT), 0) << record.output();
  const auto payloads = payloads_by_topic(folder / "a.mcap");
  EXPECT_EQ(payloads.size(), 2u);
  EXPECT_EQ(payloads.at("palp/particles").size(), 10u);  // frames 0, 2, 4, 6, 8 of two chunks each
  EXPECT_EQ(payloads.at("palp/proxy").size(), 20u);
  const std::string text = text_of(folder / "summary.json");
  EXPECT_NE(text.find("\"messages\": 30"), std::string::npos) << text;
  EXPECT_NE(text.find("\"healthy\": true"), std::string::npos) << text;
}

TEST(Record, AKilledRecorderLosesAtMostItsLastSecond) {
  const ScratchFolder folder;
  const int domain = unused_domain();
  Talker talker(domain);
  ChildProcess record(recorder(folder / "a.mcap", Vendor::cyclone, domain), folder / "record.txt");
  ASSERT_TRUE(eventually([&] { return talker.heard(); }, kPatience)) << record.output();
  ASSERT_TRUE(eventually_hears(record, 6)) << record.output();
  for (int i = 0; i < 1500; ++i) talker.say(i);
  record.stop(SIGKILL);
  const std::string unfinished = folder / ("a.mcap" + std::string(kUnfinishedSuffix));
  ASSERT_TRUE(std::filesystem::exists(unfinished));
  ChildProcess replay(program("palp-replay", unfinished, Vendor::cyclone, domain), folder / "replay.txt");
  EXPECT_EQ(replay.wait(), 1);
  EXPECT_NE(replay.output().find("--recover"), std::string::npos) << replay.output();

  ChildProcess recover({kBin + "palp-record", "--recover", unfinished}, folder / "recover.txt");
  EXPECT_EQ(recover.wait(), 0) << recover.output();
  const auto payloads = payloads_by_topic(folder / "a.mcap");
  EXPECT_GT(payloads.at("palp/proxy").size(), 500u);
  EXPECT_GT(payloads.at("palp/particles").size(), 50u);
  read_independently(folder, folder / "a.mcap");
}

TEST(Record, MalformedSamplesAreRecordedAsTheyCame) {
  const ScratchFolder folder;
  const int domain = unused_domain();
  const auto bus = open_raw_bus(on(Vendor::fastdds, domain));
  const auto proxy = bus->writer(topic_of<ProxySample>());
  const auto scene = bus->writer(topic_of<SceneDescription>());
  ChildProcess record(recorder(folder / "a.mcap", Vendor::cyclone, domain), folder / "record.txt");
  ASSERT_TRUE(eventually([&] { return proxy->matched_readers() > 0 && scene->matched_readers() > 0; }, kPatience));
  ASSERT_TRUE(eventually_hears(record, 2)) << record.output();
  const Bytes half{0, 1, 0, 0, 1, 0, 0, 0, 0xff, 0xff, 0xff, 0xff};
  const Bytes no_key{0, 1, 0, 0};
  EXPECT_TRUE(proxy->write(half));
  EXPECT_FALSE(proxy->write(no_key));
  EXPECT_TRUE(scene->write(half));
  EXPECT_TRUE(scene->write(no_key));
  std::this_thread::sleep_for(500ms);
  EXPECT_EQ(record.stop(), 0) << record.output();
  const auto payloads = payloads_by_topic(folder / "a.mcap");
  ASSERT_EQ(payloads.size(), 2u) << record.output();
  EXPECT_EQ(payloads.at("palp/proxy"), std::vector<Bytes>{half});
  EXPECT_EQ(payloads.at("palp/scene"), (std::vector<Bytes>{half, no_key}));
}

TEST(Replay, StepsMessageByMessage) {
  const ScratchFolder folder;
  record_something(folder, Vendor::cyclone, 10);
  const int domain = unused_domain();
  const auto bus = open_raw_bus(on(Vendor::cyclone, domain));
  const auto reader = bus->reader(topic_of<ProxySample>(), 100);
  std::size_t count = 0;
  const auto take = [&] { return count += reader->take([](Payload, std::int64_t) {}); };
  ChildProcess replay(with(program("palp-replay", folder / "a.mcap", Vendor::cyclone, domain),
                           {"--step", "message", "--topics", "proxy"}),
                      folder / "replay.txt");
  std::this_thread::sleep_for(2s);
  EXPECT_EQ(take(), 0u);
  replay.type("\n\n");
  EXPECT_TRUE(eventually([&] { return take() == 2; }, 5s));
  std::this_thread::sleep_for(200ms);
  EXPECT_EQ(take(), 2u);
  replay.type("\n");
  EXPECT_TRUE(eventually([&] { return take() == 3; }, 5s));
  EXPECT_EQ(replay.stop(SIGINT), 0) << replay.output();
}

// Reads it with the packages that other tools use, where they are installed.
TEST(Record, McapCoreDecodesTheFile) {
  const std::string node = "/usr/bin/node";
  if (!std::filesystem::exists(node)) GTEST_SKIP() << "no " << node;
  const ScratchFolder folder;
  record_something(folder, Vendor::fastdds, 101);
  ChildProcess reader({node, PALP_SOURCE_DIR "/tests/tools/read_with_mcap_core.cjs", folder / "a.mcap"},
                      folder / "node.txt");
  const int status = reader.wait();
  if (status == 77) GTEST_SKIP() << reader.output();
  EXPECT_EQ(status, 0) << reader.output();
  EXPECT_NE(reader.output().find("\"palp/proxy\":101"), std::string::npos) << reader.output();
}

// Each wrong use: status 1 or more, and one sentence that says what to do.
TEST(Record, WrongUseIsOneClearSentence) {
  const ScratchFolder folder;
  write_file(folder / "there.mcap", Bytes(3));
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"palp-record"}, "--out"},
      {{"palp-record", "--out", folder / "a.mcap", "--colour"}, "--colour"},
      {{"palp-record", "--out", folder / "a.mcap", "--topics", "proxies"}, "palp/proxy"},
      {{"palp-record", "--out", folder / "a.mcap", "--decimate", "particles"}, "TOPIC=N"},
      {{"palp-record", "--out", folder / "there.mcap", "--domain", "230"}, "exists already"},
      {{"palp-record", "--out", folder / "no/such/place.mcap", "--domain", "230"}, "cannot be created"},
      {{"palp-record", "--recover", folder / "there.mcap"}, "too short"},
      {{"palp-replay", folder / "there.mcap"}, "too short"},
      {{"palp-replay", folder / "absent.mcap"}, "cannot be opened"},
      {{"palp-info", folder / "absent.mcap"}, "cannot be opened"},
      {{"palp-info"}, "file is required"},
  };
  for (auto [command, expected] : cases) {
    command[0] = kBin + command[0];
    ChildProcess child(command, folder / "out.txt");
    EXPECT_GT(child.wait(10s), 0) << child.output();
    EXPECT_NE(child.output().find(expected), std::string::npos) << child.output();
  }
}

McapChunkIndex first_chunk_of(const McapReader& recording, const std::string& topic) {
  for (const McapChunkIndex& chunk : recording.chunks())
    for (const auto& [channel, at] : chunk.message_index)
      if (recording.channels().at(channel).topic == topic) return chunk;
  ADD_FAILURE() << "no chunk has messages of " << topic;
  return {};
}

TEST(Replay, GoesOnBehindADamagedChunkAndSaysWhatWasLost) {
  const ScratchFolder folder;
  record_something(folder, Vendor::cyclone, 1500);  // 3 s, a chunk each second
  const std::size_t whole = payloads_by_topic(folder / "a.mcap").at("palp/proxy").size();
  const McapChunkIndex hit = first_chunk_of(McapReader(folder / "a.mcap"), "palp/proxy");
  Bytes bytes = file_bytes(folder / "a.mcap");
  bytes[hit.offset + hit.length / 2] ^= 0x10;
  write_file(folder / "a.mcap", bytes);

  ChildProcess replay(with(program("palp-replay", folder / "a.mcap", Vendor::cyclone, unused_domain()),
                           {"--wait-readers", "0", "--rate", "0", "--topics", "proxy"}),
                      folder / "replay.txt");
  EXPECT_EQ(replay.wait(), 1) << replay.output();
  const std::string said = replay.output();
  unsigned long played = 0, lost = 0;
  if (const std::size_t at = said.find(" messages played"); at != std::string::npos)
    played = std::stoul(said.substr(said.rfind('\n', at) + 1));
  if (const std::size_t at = said.find(" messages are lost in 1 damaged chunk;"); at != std::string::npos)
    lost = std::stoul(said.substr(said.rfind(' ', at - 1)));
  EXPECT_GT(played, whole / 4) << said;
  EXPECT_GT(lost, 0u) << said;
  EXPECT_EQ(played + lost, whole) << said;
  EXPECT_NE(said.find(fmt::format("at byte {}", hit.offset)), std::string::npos) << said;
  EXPECT_NE(said.find("palp-record --recover " + (folder / "a.mcap")), std::string::npos) << said;
}

// A message that a sender kept from before the recording may come behind what another one said later.
TEST(Replay, KeepsTheOrderOfATopicWhoseMessagesComeLate) {
  constexpr std::uint64_t kBegin = 1'700'000'000'000'000'000;
  const std::int64_t published[] = {-5, 1, -3, 2, -4};  // after the beginning [ns]
  const ScratchFolder folder;
  std::vector<Bytes> said;
  {
    McapWriter writer(folder / "a.mcap");
    const TopicRow& topic = topic_of<Event>();
    const auto schema = writer.add_schema(topic.type_name, "omgidl", "");
    const auto channel = writer.add_channel(topic.name, schema, "cdr", {}, Compression::none);
    for (std::size_t i = 0; i < std::size(published); ++i) {
      said.push_back({0, 1, 0, 0, static_cast<std::uint8_t>(i), 0, 0, 0});
      const auto at = kBegin + static_cast<std::uint64_t>(published[i]);
      writer.write({channel, static_cast<std::uint32_t>(i + 1), kBegin + i, at, said.back()});
    }
    writer.close();
  }
  const int domain = unused_domain();
  const auto bus = open_raw_bus(on(Vendor::cyclone, domain));
  const auto reader = bus->reader(topic_of<Event>(), 100);
  ChildProcess replay(program("palp-replay", folder / "a.mcap", Vendor::fastdds, domain), folder / "replay.txt");
  std::vector<Bytes> heard;
  EXPECT_TRUE(eventually(
      [&] {
        reader->take([&](Payload p, std::int64_t) { heard.emplace_back(p.begin(), p.end()); });
        return heard.size() >= said.size();
      },
      kPatience))
      << replay.output();
  EXPECT_EQ(replay.wait(), 0) << replay.output();
  EXPECT_EQ(heard, said);
}

TEST(Replay, SaysThatNobodyListens) {
  const ScratchFolder folder;
  record_something(folder, Vendor::cyclone, 5);
  ChildProcess replay(
      with(program("palp-replay", folder / "a.mcap", Vendor::cyclone, unused_domain()), {"--timeout", "0.5"}),
      folder / "replay.txt");
  EXPECT_EQ(replay.wait(), 1);
  EXPECT_NE(replay.output().find("--wait-readers 0"), std::string::npos) << replay.output();
}

}  // namespace
}  // namespace palp::test
