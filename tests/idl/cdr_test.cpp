// Messages written without a vendor are the very bytes that both vendors send, and come back as they were.
#include <gtest/gtest.h>

#include <random>

#include "idl/cdr.h"
#include "tests/idl/reflect.h"
#include "tests/support/bus.h"
#include "tests/support/valid_messages.h"
#include "tools/recording/raw_bus.h"

namespace palp::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <class T>
void expect_same_bytes(Vendor vendor) {
  SCOPED_TRACE(topic_of<T>().name);
  T sent;
  Fill fill;
  fill(sent);
  if constexpr (requires { sent.device; }) sent.device = 3;
  auto sink = raw_sink<T>(vendor, open_raw(vendor));
  const auto bus = open_raw_bus(options_for(vendor));
  const auto reader = bus->reader(topic_of<T>(), 16);
  ASSERT_TRUE(eventually([&] { return sink->matched() > 0; }));
  Bytes heard;
  ASSERT_TRUE(eventually([&] {
    EXPECT_TRUE(sink->write(sent));
    bus->wait(20ms);
    reader->take([&](Payload payload, std::int64_t) { heard.assign(payload.begin(), payload.end()); });
    return !heard.empty();
  }));
  Bytes written = to_cdr(sent);
  ASSERT_GE(heard.size(), 4u);
  // the options of the encapsulation and the bytes that fill up the last word are the vendors' own
  heard[2] = heard[3] = written[2] = written[3] = 0;
  heard.resize((heard.size() + 3) / 4 * 4);
  EXPECT_EQ(written, heard);
}

TEST(Cdr, WritesTheBytesOfBothVendors) {
  for (const Vendor vendor : {Vendor::cyclone, Vendor::fastdds}) {
    SCOPED_TRACE(to_string(vendor));
#define PALP_CHECK(T) expect_same_bytes<T>(vendor);
    PALP_FOR_EACH_MESSAGE(PALP_CHECK)
#undef PALP_CHECK
  }
}

template <class T>
void expect_round_trip() {
  SCOPED_TRACE(topic_of<T>().name);
  const T sent = sound<T>();
  const Bytes bytes = to_cdr(sent);
  T read;
  ASSERT_EQ(from_cdr(bytes, read), Fault::none);
  Differences differences;
  differences(sent, read);
  EXPECT_EQ(differences.count, 0);

  // no shorter payload is read, and none is read past its end
  for (std::size_t size = 0; size + 4 < bytes.size(); ++size)
    EXPECT_NE(from_cdr(std::span(bytes).first(size), read), Fault::none) << size;
  Bytes longer = bytes;
  longer.resize(longer.size() + 4);
  EXPECT_EQ(from_cdr(longer, read), Fault::malformed);
  Bytes big_endian = bytes;
  big_endian[1] = 0;
  EXPECT_EQ(from_cdr(big_endian, read), Fault::malformed);
}

TEST(Cdr, ReadsWhatItWroteAndNothingShorter) {
#define PALP_CHECK(T) expect_round_trip<T>();
  PALP_FOR_EACH_MESSAGE(PALP_CHECK)
#undef PALP_CHECK
}

TEST(Cdr, KnowsAnotherVersionEvenWhereTheRestCannotBeRead) {
  SceneDescription scene = sound<SceneDescription>();
  scene.header.version = kProtocolVersion + 1;
  Bytes bytes = to_cdr(scene);
  SceneDescription read;
  EXPECT_EQ(from_cdr(bytes, read), Fault::wrong_version);
  bytes.resize(bytes.size() / 2);
  EXPECT_EQ(from_cdr(bytes, read), Fault::wrong_version);
}

TEST(Cdr, RandomBytesCostNoMoreMemoryThanTheyAre) {
  std::mt19937 random(3);
  const Bytes sound_bytes = to_cdr(sound<SceneDescription>());
  SceneDescription read;
  int refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    Bytes bytes = sound_bytes;
    for (int k = 0; k < 4; ++k) bytes[4 + random() % (bytes.size() - 4)] = static_cast<std::uint8_t>(random());
    refused += from_cdr(bytes, read) != Fault::none;
    EXPECT_LE(read.bodies.size(), bytes.size());
  }
  EXPECT_GT(refused, 5'000);  // most alterations are of lengths, enumerators, the version or orientations
}

}  // namespace
}  // namespace palp::test
