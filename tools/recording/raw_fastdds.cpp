// Raw samples with Fast DDS: a data type whose serialisation is a copy of the bytes.
#include <fastdds/dds/core/condition/WaitSet.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include <array>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "idl/dds/fastdds_participant.h"
#include "tools/recording/raw_bus.h"

namespace palp {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kFirstSize = 1024;  // payloads grow from here

class BlobType : public dds::TopicDataType {
 public:
  explicit BlobType(const TopicRow& row) : key_size_(row.key_bytes) {
    setName(row.type_name);
    m_typeSize = kFirstSize;
    m_isGetKeyDefined = row.key_bytes > 0;
    // Cyclone refuses end points that come with Fast DDS's type information
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }

  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<const Bytes*>(data);
    if (bytes.size() < 4 || bytes.size() > payload->max_size) return false;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = bytes[1] == 1 ? CDR_LE : CDR_BE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    if (payload->length < 4) return false;
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<const Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes(); }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void* data, rtps::InstanceHandle_t* handle, bool) override {
    std::array<std::uint8_t, 16> key{};
    if (!m_isGetKeyDefined || !raw_key(*static_cast<const Bytes*>(data), key_size_, key)) return false;
    for (std::size_t i = 0; i < key.size(); ++i) handle->value[i] = key[i];
    return true;
  }

 private:
  std::size_t key_size_;
};

void check(bool ok, const std::string& what) {
  if (!ok) throw std::runtime_error("Fast DDS: " + what);
}

class FastReader : public RawReader {
 public:
  FastReader(dds::Subscriber& subscriber, dds::Topic& topic, const TopicRow& row, int depth) : subscriber_(subscriber) {
    TopicRow deep = row;
    deep.reader_depth = depth;
    reader_ = subscriber.create_datareader(&topic, fastdds_reader_qos(deep));
    check(reader_ != nullptr, std::string("cannot read from ") + row.name);
    reader_->get_statuscondition().set_enabled_statuses(dds::StatusMask::data_available());
  }
  ~FastReader() override { subscriber_.delete_datareader(reader_); }

  std::size_t take(const std::function<void(Payload, std::int64_t)>& on_sample) override {
    std::size_t count = 0;
    dds::SampleInfo info;
    while (reader_->take_next_sample(&buffer_, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      on_sample(buffer_, info.source_timestamp.to_ns());
      ++count;
    }
    return count;
  }
  std::uint64_t lost() const override {
    dds::SampleLostStatus status;
    reader_->get_sample_lost_status(status);
    return static_cast<std::uint64_t>(status.total_count);
  }
  int matched_writers() const override {
    dds::SubscriptionMatchedStatus status;
    reader_->get_subscription_matched_status(status);
    return status.current_count;
  }
  dds::Condition& condition() { return reader_->get_statuscondition(); }

 private:
  dds::Subscriber& subscriber_;
  dds::DataReader* reader_ = nullptr;
  Bytes buffer_;
};

class FastWriter : public RawWriter {
 public:
  FastWriter(dds::Publisher& publisher, dds::Topic& topic, const TopicRow& row)
      : publisher_(publisher), key_size_(row.key_bytes) {
    writer_ = publisher.create_datawriter(&topic, fastdds_writer_qos(row));
    check(writer_ != nullptr, std::string("cannot write to ") + row.name);
  }
  ~FastWriter() override { publisher_.delete_datawriter(writer_); }

  bool write(Payload payload) override {
    std::array<std::uint8_t, 16> key{};
    if (!raw_key(payload, key_size_, key)) return false;
    buffer_.assign(payload.begin(), payload.end());
    return writer_->write(&buffer_);
  }
  int matched_readers() const override {
    dds::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return status.current_count;
  }
  bool wait_acknowledged(std::chrono::milliseconds timeout) override {
    const eprosima::fastrtps::Duration_t limit(static_cast<long double>(timeout.count()) / 1000.0L);
    return writer_->wait_for_acknowledgments(limit) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK;
  }

 private:
  dds::Publisher& publisher_;
  std::size_t key_size_;
  dds::DataWriter* writer_ = nullptr;
  Bytes buffer_;
};

class FastRawBus : public RawBus {
 public:
  explicit FastRawBus(const BusOptions& options) : participant_(options) {
    publisher_ = participant_.get().create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_.get().create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
    check(publisher_ != nullptr && subscriber_ != nullptr, "cannot create a publisher and a subscriber");
  }
  ~FastRawBus() override {
    participant_.get().delete_publisher(publisher_);
    participant_.get().delete_subscriber(subscriber_);
  }

  std::unique_ptr<RawReader> reader(const TopicRow& row, int depth) override {
    auto out = std::make_unique<FastReader>(*subscriber_, topic(row), row, depth);
    waitset_.attach_condition(out->condition());
    return out;
  }
  std::unique_ptr<RawWriter> writer(const TopicRow& row) override {
    return std::make_unique<FastWriter>(*publisher_, topic(row), row);
  }
  bool wait(std::chrono::milliseconds timeout) override {
    dds::ConditionSeq active;
    const eprosima::fastrtps::Duration_t limit(static_cast<long double>(timeout.count()) / 1000.0L);
    return waitset_.wait(active, limit) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK;
  }

 private:
  dds::Topic& topic(const TopicRow& row) { return *participant_.topic(row, dds::TypeSupport(new BlobType(row))); }

  FastddsParticipant participant_;
  dds::Publisher* publisher_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
  dds::WaitSet waitset_;
};

}  // namespace

std::unique_ptr<RawBus> open_raw_fastdds(const BusOptions& options) { return std::make_unique<FastRawBus>(options); }

}  // namespace palp
