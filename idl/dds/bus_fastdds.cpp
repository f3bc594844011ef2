// The end points of the bus over Fast DDS, by the types that fastddsgen generates.
#include <atomic>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <stdexcept>
#include <string>

#include "idl/dds/fastdds_participant.h"
#include "palpPubSubTypes.h"

#define PALP_WIRE(object, name) (object).name()
#include "idl/dds/wire_fields.h"

namespace palp {
namespace {

namespace dds = eprosima::fastdds::dds;
using eprosima::fastrtps::types::ReturnCode_t;

// The generated type support lets exceptions of its decoder pass; here bytes that it cannot read are counted.
template <class PubSubType>
class Guarded : public PubSubType {
 public:
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    bool ok = false;
    try {
      ok = PubSubType::deserialize(payload, data);
    } catch (const std::exception&) {
    }
    if (!ok) ++refused_;
    return ok;
  }
  std::uint64_t refused() const { return refused_; }

 private:
  std::atomic<std::uint64_t> refused_ = 0;
};

template <class T>
struct Wire;
#define PALP_FASTDDS_WIRE(T)                      \
  template <>                                     \
  struct Wire<T> {                                \
    using Type = wire::T;                         \
    using Support = Guarded<wire::T##PubSubType>; \
  };
PALP_FOR_EACH_MESSAGE(PALP_FASTDDS_WIRE)
#undef PALP_FASTDDS_WIRE

template <class S>
concept Scalar = std::is_arithmetic_v<S> || std::is_enum_v<S>;

// Both directions: the generated types hold the same standard containers as the messages.
struct Copy {
  template <Scalar A, class B>
  void operator()(const A& a, B& b) {
    b = static_cast<B>(a);
  }
  template <class A>
  requires(!Scalar<A>) void operator()(const A& a, A& b) { b = a; }
  template <class M, class W>
  requires(!std::same_as<M, W>) void operator()(const std::vector<M>& a, std::vector<W>& b) {
    b.resize(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) (*this)(a[i], b[i]);
  }
  template <class M, class W>
  requires(std::is_class_v<M> && !std::same_as<M, W>) void operator()(const M& a, W& b) { map_fields(*this, a, b); }
  template <class A, class B>
  void derived(const A& a, B& b) {
    b = a;
  }
};

struct CopyBack {
  template <Scalar A, class B>
  void operator()(A& a, const B& b) {
    a = static_cast<A>(b);
  }
  template <class A>
  requires(!Scalar<A>) void operator()(A& a, const A& b) { a = b; }
  template <class M, class W>
  requires(!std::same_as<M, W>) void operator()(std::vector<M>& a, const std::vector<W>& b) {
    a.resize(b.size());
    for (std::size_t i = 0; i < a.size(); ++i) (*this)(a[i], b[i]);
  }
  template <class M, class W>
  requires(std::is_class_v<M> && !std::same_as<M, W>) void operator()(M& a, const W& b) { map_fields(*this, a, b); }
  template <class A, class B>
  void derived(const A&, const B&) {}
};

template <class T>
class FastddsSink : public Sink<T> {
 public:
  explicit FastddsSink(std::shared_ptr<Participant> participant) : participant_(std::move(participant)) {
    auto& fast = static_cast<FastddsParticipant&>(*participant_);
    const TopicRow& row = topic_of<T>();
    dds::Topic* topic = fast.topic(row, dds::TypeSupport(new typename Wire<T>::Support()));
    publisher_ = fast.get().create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    writer_ = publisher_ ? publisher_->create_datawriter(topic, fastdds_writer_qos(row)) : nullptr;
    if (!writer_) throw std::runtime_error(std::string("Fast DDS: cannot write to ") + row.name);
  }
  ~FastddsSink() override {
    publisher_->delete_datawriter(writer_);
    static_cast<FastddsParticipant&>(*participant_).get().delete_publisher(publisher_);
  }

  bool write(const T& message) override {
    Copy copy;
    map_fields(copy, message, sample_);
    return writer_->write(&sample_);
  }
  int matched() const override {
    dds::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return status.current_count;
  }

 private:
  std::shared_ptr<Participant> participant_;
  dds::Publisher* publisher_ = nullptr;
  dds::DataWriter* writer_ = nullptr;
  typename Wire<T>::Type sample_;  // kept for its memory
};

template <class T>
class FastddsSource : public Source<T> {
 public:
  explicit FastddsSource(std::shared_ptr<Participant> participant) : participant_(std::move(participant)) {
    auto& fast = static_cast<FastddsParticipant&>(*participant_);
    const TopicRow& row = topic_of<T>();
    dds::Topic* topic = fast.topic(row, dds::TypeSupport(new typename Wire<T>::Support()));
    support_ = fast.get().find_type(row.type_name);
    subscriber_ = fast.get().create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
    reader_ = subscriber_ ? subscriber_->create_datareader(topic, fastdds_reader_qos(row)) : nullptr;
    if (!reader_) throw std::runtime_error(std::string("Fast DDS: cannot read from ") + row.name);
  }
  ~FastddsSource() override {
    subscriber_->delete_datareader(reader_);
    static_cast<FastddsParticipant&>(*participant_).get().delete_subscriber(subscriber_);
  }

  std::size_t take(std::vector<Taken<T>>& out, std::size_t count) override {
    dds::SampleInfo info;
    while (reader_->take_next_sample(&sample_, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      if (count == out.size()) out.emplace_back();
      Taken<T>& taken = out[count++];
      CopyBack copy_back;
      map_fields(copy_back, taken.message, const_cast<const typename Wire<T>::Type&>(sample_));
      taken.source_time_ns = info.source_timestamp.to_ns();
    }
    return count;
  }
  bool wait(std::chrono::nanoseconds timeout) override {
    const auto ns = std::max<std::int64_t>(0, timeout.count());
    return reader_->wait_for_unread_message(
        {static_cast<std::int32_t>(ns / 1'000'000'000), static_cast<std::uint32_t>(ns % 1'000'000'000)});
  }
  int matched() const override {
    dds::SubscriptionMatchedStatus status;
    reader_->get_subscription_matched_status(status);
    return status.current_count;
  }
  std::uint64_t undecodable() const override {
    const auto* support = dynamic_cast<const typename Wire<T>::Support*>(support_.get());
    return support ? support->refused() : 0;
  }

 private:
  std::shared_ptr<Participant> participant_;
  dds::TypeSupport support_;
  dds::Subscriber* subscriber_ = nullptr;
  dds::DataReader* reader_ = nullptr;
  typename Wire<T>::Type sample_;  // kept for its memory
};

}  // namespace

template <class T>
std::unique_ptr<Sink<T>> fastdds_sink(std::shared_ptr<Participant> participant) {
  return std::make_unique<FastddsSink<T>>(std::move(participant));
}

template <class T>
std::unique_ptr<Source<T>> fastdds_source(std::shared_ptr<Participant> participant) {
  return std::make_unique<FastddsSource<T>>(std::move(participant));
}

// NOLINTBEGIN(bugprone-macro-parentheses): T is a type
#define PALP_INSTANTIATE(T)                                                        \
  template std::unique_ptr<Sink<T>> fastdds_sink<T>(std::shared_ptr<Participant>); \
  template std::unique_ptr<Source<T>> fastdds_source<T>(std::shared_ptr<Participant>);
PALP_FOR_EACH_MESSAGE(PALP_INSTANTIATE)
#undef PALP_INSTANTIATE
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace palp
