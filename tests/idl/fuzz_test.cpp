// Hostile bytes on every topic: truncated, altered and random payloads crash no reader of either vendor, cost no memory
// beyond reason, and sound samples still get through afterwards.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdlib>
#include <cstring>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <random>

#include "idl/dds/fastdds_participant.h"
#include "idl/validate.h"
#include "tests/support/bus.h"
#include "tests/support/seed.h"
#include "tests/support/valid_messages.h"

namespace palp::test::fuzz_test {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Bytes = std::vector<unsigned char>;

// A type whose sample is its serialized payload.
class RawType : public dds::TopicDataType {
 public:
  explicit RawType(const TopicRow& row) {
    setName(row.type_name);
    m_typeSize = 1 << 20;
    m_isGetKeyDefined = row.key_bytes > 0;
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    payload->length = static_cast<std::uint32_t>(bytes.size());
    std::memcpy(payload->data, bytes.data(), bytes.size());
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  // few keys, whatever the bytes: the writer must not run out of instances
  bool getKey(void* data, rtps::InstanceHandle_t* handle, bool) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    *handle = rtps::InstanceHandle_t();
    handle->value[0] = bytes.empty() ? 1 : static_cast<unsigned char>(1 + bytes[bytes.size() / 2] % 8);
    return true;
  }
};

class RawWriter {
 public:
  RawWriter(FastddsParticipant& participant, const TopicRow& row) : participant_(participant.get()) {
    dds::Topic* topic = participant.topic(row, dds::TypeSupport(new RawType(row)));
    publisher_ = participant_.create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    writer_ = publisher_->create_datawriter(topic, fastdds_writer_qos(row));
  }
  ~RawWriter() {
    publisher_->delete_datawriter(writer_);
    participant_.delete_publisher(publisher_);
  }
  bool write(Bytes& bytes) { return writer_->write(&bytes); }
  int matched() const {
    dds::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return status.current_count;
  }

 private:
  dds::DomainParticipant& participant_;
  dds::Publisher* publisher_ = nullptr;
  dds::DataWriter* writer_ = nullptr;
};

// Little-endian CDR of a few fields and then whatever: enough of a header that some samples come past the decoder.
Bytes plausible(std::mt19937& random, std::size_t size) {
  Bytes bytes(4 + size);
  bytes[1] = 1;
  for (std::size_t i = 4; i < bytes.size(); ++i) {
    // small numbers make plausible lengths
    bytes[i] = random() % 4 ? 0 : static_cast<unsigned char>(random());
  }
  const std::uint32_t version = kProtocolVersion;
  if (bytes.size() >= 16) std::memcpy(&bytes[random() % 2 ? 4 : 12], &version, 4);
  return bytes;
}

Bytes hostile(std::mt19937& random) {
  Bytes bytes = plausible(random, random() % 600);
  switch (random() % 5) {
    case 0:  // pure noise
      for (auto& b : bytes) b = static_cast<unsigned char>(random());
      break;
    case 1:  // a huge length somewhere
      for (std::size_t i = 4 * (1 + random() % 100); i + 4 <= bytes.size(); i += 4 * (1 + random() % 40)) {
        const std::uint32_t lengths[] = {0xffffffff, 0x7fffffff, 0x40000000, 0x10000, 600};
        std::memcpy(&bytes[i], &lengths[random() % 5], 4);
      }
      break;
    case 2:  // cut short, down to nothing
      bytes.resize(random() % (bytes.size() + 1));
      break;
    case 3:  // big-endian, or an encapsulation that nobody knows
      bytes[1] = static_cast<unsigned char>(random() % 12);
      break;
    default:
      break;
  }
  return bytes;
}

long peak_memory_kb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

class Fuzz : public ::testing::TestWithParam<Vendor> {
 protected:
  template <class T>
  static void attack(Bus& bus, FastddsParticipant& attacker, Bus& honest, std::mt19937& random) {
    const TopicRow& row = topic_of<T>();
    SCOPED_TRACE(row.name);
    const auto reader = bus.reader<T>();
    std::vector<Received<T>> got;
    {
      RawWriter writer(attacker, row);
      ASSERT_TRUE(eventually([&] { return writer.matched() > 0 && reader->matched_writers() > 0; }));
      for (int i = 0; i < 400; ++i) {
        Bytes bytes = hostile(random);
        writer.write(bytes);
        if (i % 8 == 0) {
          reader->wait(2ms);
          reader->take_all(got);
        }
      }
      // every encoding that a payload may claim, known or not, ended anywhere
      for (unsigned char encoding = 0; encoding < 12; ++encoding) {
        for (std::size_t size = 4 * (random() % 8); size < 640; size += 20) {
          Bytes bytes = plausible(random, size);
          bytes[1] = encoding;
          writer.write(bytes);
        }
        reader->wait(2ms);
        reader->take_all(got);
      }
      reader->wait(20ms);
      reader->take_all(got);
    }
    for (const auto& r : got) EXPECT_EQ(validate(r.message), Fault::none);
    const DropCounts drops = reader->drops();
    EXPECT_GT(drops.malformed + drops.wrong_version + drops.not_finite, 0u);

    const auto writer = honest.writer<T>();
    auto m = sound<T>();
    Received<T> newest;
    EXPECT_TRUE(eventually([&] {
      writer->publish(m);
      reader->wait(20ms);
      return reader->take_latest(newest) && newest.message.header.session == honest.session();
    }));
  }
};

TEST_P(Fuzz, HostileBytesNeitherCrashNorStopAReader) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("PALP_SEED=" + std::to_string(seed));
  std::cout << "PALP_SEED=" << seed << '\n';
  std::mt19937 random(seed);
  const auto bus = open_bus(options_for(GetParam()));
  const auto honest = open_bus(options_for(Vendor::cyclone));
  FastddsParticipant attacker(options_for(Vendor::fastdds));
  const long before_kb = peak_memory_kb();
#define PALP_ATTACK(T) attack<T>(*bus, attacker, *honest, random);
  PALP_FOR_EACH_MESSAGE(PALP_ATTACK)
#undef PALP_ATTACK
  EXPECT_LT(peak_memory_kb() - before_kb, 400'000);
}

INSTANTIATE_TEST_SUITE_P(Vendors, Fuzz, ::testing::Values(Vendor::cyclone, Vendor::fastdds),
                         [](const auto& i) { return std::string(to_string(i.param)); });

}  // namespace
}  // namespace palp::test::fuzz_test
