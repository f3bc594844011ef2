// The bus as processes use it, between both vendors in every direction.
#include "idl/bus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "idl/clock.h"
#include "idl/idl_text.h"
#include "tests/idl/reflect.h"
#include "tests/support/bus.h"
#include "tests/support/valid_messages.h"

namespace palp::test::bus_test {
namespace {

class BusPair : public testing::TestWithParam<Pairing> {
 protected:
  Vendor from() const { return std::get<0>(GetParam()); }
  Vendor to() const { return std::get<1>(GetParam()); }

  template <class T>
  static void connect(Writer<T>& writer, Reader<T>& reader) {
    ASSERT_TRUE(eventually([&] { return writer.matched_readers() > 0 && reader.matched_writers() > 0; }));
  }
  template <class T>
  static void connect(Sink<T>& sink, Reader<T>& reader) {
    ASSERT_TRUE(eventually([&] { return sink.matched() > 0 && reader.matched_writers() > 0; }));
  }
};

TEST_P(BusPair, StampsWhatItSendsAndGivesTheNewest) {
  const auto out = open_bus(options_for(from()));
  const auto in = open_bus(options_for(to()));
  EXPECT_NE(out->session(), in->session());
  const auto writer = out->writer<DeviceSample>();
  const auto reader = in->reader<DeviceSample>();
  connect(*writer, *reader);

  auto m = sound<DeviceSample>();
  const std::int64_t t_begin = now_ns();
  for (int i = 1; i <= 5; ++i) {
    ASSERT_TRUE(writer->publish(m));
    EXPECT_EQ(m.header.sequence, static_cast<std::uint64_t>(i));
    EXPECT_EQ(m.header.session, out->session());
    EXPECT_EQ(m.header.version, kProtocolVersion);
    EXPECT_GE(m.header.t_send_ns, t_begin);
  }
  auto other = m;
  other.device = 4;
  ASSERT_TRUE(writer->publish(other));
  EXPECT_EQ(other.header.sequence, 1u) << "each key has a sequence of its own";

  Received<DeviceSample> got;
  ASSERT_TRUE(eventually([&] { return reader->take_latest(got) && got.message.device == 4; }));
  EXPECT_GE(got.t_receive_ns, got.message.header.t_send_ns);
  EXPECT_FALSE(reader->take_latest(got));
  EXPECT_FALSE(reader->wait(1ms));
}

// A few of each, the newest last: one device's samples never push out another's, nor one sender's another one's.
TEST_P(BusPair, KeepsTheNewestFewSamplesOfEachDevice) {
  const auto out = open_bus(options_for(from()));
  const auto in = open_bus(options_for(to()));
  const auto writer = out->writer<DeviceSample>();
  const auto reader = in->reader<DeviceSample>();
  connect(*writer, *reader);
  auto m = sound<DeviceSample>();
  const int depth = topic_of<DeviceSample>().reader_depth;
  // best effort: on a busy machine a round may be lost or late, but never are there more than so many of a device
  std::vector<Received<DeviceSample>> got;
  EXPECT_TRUE(eventually([&] {
    for (int i = 0; i < depth + 3; ++i)
      for (m.device = 0; m.device < kMaxDevices; ++m.device) EXPECT_TRUE(writer->publish(m));
    std::this_thread::sleep_for(300ms);
    got.clear();
    reader->take_all(got);
    std::array<int, kMaxDevices> seen{};
    std::array<std::uint64_t, kMaxDevices> last{};
    for (const auto& r : got) {
      EXPECT_LE(++seen[r.message.device], depth) << "device " << r.message.device;
      last[r.message.device] = r.message.header.sequence;
    }
    const auto newest = [&](std::uint64_t sequence) { return sequence == m.header.sequence; };
    return std::all_of(last.begin(), last.end(), newest);
  }));
}

TEST_P(BusPair, DeliversCommandsAllAndInOrder) {
  const auto out = open_bus(options_for(from()));
  const auto in = open_bus(options_for(to()));
  const auto writer = out->writer<Command>();
  const auto reader = in->reader<Command>();
  connect(*writer, *reader);
  constexpr std::uint64_t kCount = 40;
  auto m = sound<Command>();
  for (std::uint64_t i = 1; i <= kCount; ++i) {
    m.value = std::to_string(i);
    ASSERT_TRUE(writer->publish(m));
  }
  std::vector<Received<Command>> got;
  ASSERT_TRUE(eventually([&] { return (reader->wait(10ms), reader->take_all(got), got.size() >= kCount); }));
  for (std::uint64_t i = 1; i <= kCount; ++i) EXPECT_EQ(got[i - 1].message.value, std::to_string(i));
  EXPECT_EQ(reader->drops().lost, 0u);
}

// A payload that ends anywhere between two multiples of four bytes.
TEST_P(BusPair, DeliversTextsOfEveryLength) {
  const auto out = open_bus(options_for(from()));
  const auto in = open_bus(options_for(to()));
  const auto writer = out->writer<Event>();
  const auto reader = in->reader<Event>();
  connect(*writer, *reader);
  auto m = sound<Event>();
  std::vector<std::string> expected;
  for (m.text.clear(); m.text.size() < 20; m.text += 'x') {
    expected.push_back(m.text);
    ASSERT_TRUE(writer->publish(m));
  }
  std::vector<Received<Event>> got;
  ASSERT_TRUE(eventually([&] { return (reader->wait(10ms), reader->take_all(got), got.size() >= expected.size()); }));
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(got[i].message.text, expected[i]);
}

TEST_P(BusPair, GivesALateJoinerTheSceneAndTheStatus) {
  const auto out = open_bus(options_for(from()));
  const auto scenes = out->writer<SceneDescription>();
  const auto statuses = out->writer<Status>();
  auto scene = sound<SceneDescription>();
  // a mesh of some size: more than one datagram
  scene.bodies[1].vertices.resize(90'000, 0.25f);
  scene.bodies[1].triangles.resize(60'000, 7);
  auto status = sound<Status>();
  ASSERT_TRUE(scenes->publish(scene));
  ASSERT_TRUE(statuses->publish(status));
  std::this_thread::sleep_for(50ms);

  const auto in = open_bus(options_for(to()));
  const auto reader = in->reader<SceneDescription>();
  const auto status_reader = in->reader<Status>();
  Received<SceneDescription> got;
  Received<Status> got_status;
  ASSERT_TRUE(eventually([&] { return (reader->wait(10ms), reader->take_latest(got)); }));
  ASSERT_TRUE(eventually([&] { return (status_reader->wait(10ms), status_reader->take_latest(got_status)); }));
  Differences differences;
  differences(scene, got.message);
  differences(status, got_status.message);
  EXPECT_EQ(differences.count, 0);
}

TEST_P(BusPair, DropsAndCountsWhatIsNotSound) {
  const auto raw = open_raw(from());
  const auto in = open_bus(options_for(to()));
  const auto sink = raw_sink<Command>(from(), raw);
  const auto devices = raw_sink<DeviceSample>(from(), raw);
  const auto reader = in->reader<Command>();
  const auto device_reader = in->reader<DeviceSample>();
  connect(*sink, *reader);
  connect(*devices, *device_reader);

  auto m = sound<Command>();
  m.header.version = 9;
  sink->write(m);
  m.header.version = kProtocolVersion;
  m.kind = static_cast<CommandKind>(17);
  sink->write(m);
  m.kind = CommandKind::reset;
  m.header.sequence = 2;
  sink->write(m);
  m.header.sequence = 5;
  sink->write(m);
  std::vector<Received<Command>> got;
  ASSERT_TRUE(eventually([&] { return (reader->wait(10ms), reader->take_all(got), got.size() >= 2); }));
  EXPECT_EQ(got.size(), 2u);
  EXPECT_EQ(reader->drops().wrong_version, 1u);
  EXPECT_EQ(reader->drops().other_version, 9u);
  EXPECT_EQ(reader->drops().malformed, 1u);
  EXPECT_EQ(reader->drops().lost, 2u);

  auto bad = sound<DeviceSample>();
  bad.pose.position[2] = std::numeric_limits<double>::quiet_NaN();
  std::vector<Received<DeviceSample>> samples;
  ASSERT_TRUE(eventually([&] {
    devices->write(bad);
    device_reader->wait(10ms);
    device_reader->take_all(samples);
    return device_reader->drops().not_finite > 0;
  }));
  EXPECT_TRUE(samples.empty());
}

TEST_P(BusPair, SurvivesTheRestartOfAPeer) {
  const auto in = open_bus(options_for(to()));
  const auto reader = in->reader<ProxySample>();
  Received<ProxySample> got;
  std::uint64_t last = 0;
  for (int life = 0; life < 2; ++life) {
    const auto out = open_bus(options_for(from()));
    const auto writer = out->writer<ProxySample>();
    auto m = sound<ProxySample>();
    ASSERT_TRUE(eventually([&] {
      writer->publish(m);
      reader->wait(10ms);
      return reader->take_latest(got) && got.message.header.session == out->session();
    }));
    EXPECT_NE(got.message.header.session, last);
    last = got.message.header.session;
  }
}

INSTANTIATE_TEST_SUITE_P(Vendors, BusPair,
                         testing::Combine(testing::Values(Vendor::cyclone, Vendor::fastdds),
                                          testing::Values(Vendor::cyclone, Vendor::fastdds)),
                         pairing_name<testing::TestParamInfo<Pairing>>);

TEST(Topics, HaveANameAndATypeOfTheIdlEach) {
  for (const TopicRow& row : kTopics) {
    EXPECT_EQ(std::string(row.name).rfind("palp/", 0), 0u);
    const std::string type = std::string(row.type_name).substr(std::string("palp::wire::").size());
    EXPECT_NE(std::string(kPalpIdlText).find("struct " + type + " {"), std::string::npos) << type;
  }
}

}  // namespace
}  // namespace palp::test::bus_test
