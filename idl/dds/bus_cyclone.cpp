// The end points of the bus over Cyclone DDS, by its C API and the types that idlc generates.
#include <dds/dds.h>

#include <algorithm>
#include <array>
#include <string>

#include "idl/dds/cyclone_participant.h"
#include "palp.h"

#define PALP_WIRE(object, name) (object).name
#include "idl/dds/wire_fields.h"

namespace palp {
namespace {

template <class T>
struct Wire;
#define PALP_CYCLONE_WIRE(T)                                                            \
  template <>                                                                           \
  struct Wire<T> {                                                                      \
    using Type = palp_wire_##T;                                                         \
    static const dds_topic_descriptor_t* descriptor() { return &palp_wire_##T##_desc; } \
  };
PALP_FOR_EACH_MESSAGE(PALP_CYCLONE_WIRE)
#undef PALP_CYCLONE_WIRE

template <class S>
concept Scalar = std::is_arithmetic_v<S> || std::is_enum_v<S>;

// Fills a wire sample that points into the message: nothing of the message is copied but scalars and arrays. The sample
// is good as long as the message and this object are.
class ToWire {
 public:
  template <Scalar A, class B>
  void operator()(const A& a, B& b) {
    b = static_cast<B>(a);
  }
  template <Scalar A, class B>
  void derived(const A& a, B& b) {
    b = a;
  }
  template <class S, std::size_t n>
  void operator()(const std::array<S, n>& a, S (&b)[n]) {
    std::copy(a.begin(), a.end(), b);
  }
  // the generated types have no const; dds_write does not write to them
  void operator()(const std::string& a, char*& b) { b = const_cast<char*>(a.c_str()); }
  template <Scalar S, class Sequence>
  void operator()(const std::vector<S>& a, Sequence& b) {
    set(b, const_cast<S*>(a.data()), a.size());
  }
  template <class M, class Sequence>
  void operator()(const std::vector<M>& a, Sequence& b) {
    using W = std::remove_pointer_t<decltype(b._buffer)>;
    auto buffer = std::make_unique<std::byte[]>(sizeof(W) * a.size() + 1);
    W* w = reinterpret_cast<W*>(buffer.get());
    std::fill_n(w, a.size(), W{});
    for (std::size_t i = 0; i < a.size(); ++i) map_fields(*this, a[i], w[i]);
    set(b, w, a.size());
    buffers_.push_back(std::move(buffer));
  }
  template <class M, class W>
  requires std::is_class_v<M>
  void operator()(const M& a, W& b) { map_fields(*this, a, b); }

 private:
  template <class Sequence, class E>
  static void set(Sequence& b, E* data, std::size_t size) {
    b._buffer = data;
    b._length = b._maximum = static_cast<std::uint32_t>(size);
    b._release = false;
  }

  std::vector<std::unique_ptr<std::byte[]>> buffers_;
};

struct FromWire {
  template <Scalar A, class B>
  void operator()(A& a, const B& b) {
    a = static_cast<A>(b);
  }
  template <class A, class B>
  void derived(const A&, const B&) {}
  template <class S, std::size_t n>
  void operator()(std::array<S, n>& a, const S (&b)[n]) {
    std::copy(b, b + n, a.begin());
  }
  void operator()(std::string& a, char* const& b) { a = b ? b : ""; }
  template <Scalar S, class Sequence>
  void operator()(std::vector<S>& a, const Sequence& b) {
    a.assign(b._buffer, b._buffer + b._length);
  }
  template <class M, class Sequence>
  void operator()(std::vector<M>& a, const Sequence& b) {
    a.resize(b._length);
    for (std::size_t i = 0; i < a.size(); ++i) map_fields(*this, a[i], b._buffer[i]);
  }
  template <class M, class W>
  requires std::is_class_v<M>
  void operator()(M& a, const W& b) { map_fields(*this, a, b); }
};

// Each end point makes the topic for itself; Cyclone gives the same one back under the hood.
template <class T>
dds_entity_t create_topic(const CycloneParticipant& participant) {
  const TopicRow& row = topic_of<T>();
  return cyclone_check(dds_create_topic(participant.entity(), Wire<T>::descriptor(), row.name, nullptr, nullptr),
                       std::string("cannot create the topic ") + row.name);
}

template <class T>
class CycloneSink : public Sink<T> {
 public:
  explicit CycloneSink(std::shared_ptr<Participant> participant) : participant_(std::move(participant)) {
    auto& cyclone = static_cast<CycloneParticipant&>(*participant_);
    const dds_entity_t topic = create_topic<T>(cyclone);
    dds_qos_t* qos = cyclone_qos(topic_of<T>(), false);
    writer_ = dds_create_writer(cyclone.entity(), topic, qos, nullptr);
    dds_delete_qos(qos);
    cyclone_check(writer_, std::string("cannot write to ") + topic_of<T>().name);
  }
  ~CycloneSink() override { dds_delete(writer_); }

  bool write(const T& message) override {
    typename Wire<T>::Type sample{};
    ToWire to_wire;
    map_fields(to_wire, message, sample);
    return dds_write(writer_, &sample) == DDS_RETCODE_OK;
  }
  int matched() const override {
    dds_publication_matched_status_t status;
    return dds_get_publication_matched_status(writer_, &status) == DDS_RETCODE_OK
               ? static_cast<int>(status.current_count)
               : 0;
  }

 private:
  std::shared_ptr<Participant> participant_;
  dds_entity_t writer_ = 0;
};

template <class T>
class CycloneSource : public Source<T> {
 public:
  explicit CycloneSource(std::shared_ptr<Participant> participant) : participant_(std::move(participant)) {
    auto& cyclone = static_cast<CycloneParticipant&>(*participant_);
    const dds_entity_t topic = create_topic<T>(cyclone);
    dds_qos_t* qos = cyclone_qos(topic_of<T>(), true);
    reader_ = dds_create_reader(cyclone.entity(), topic, qos, nullptr);
    dds_delete_qos(qos);
    cyclone_check(reader_, std::string("cannot read from ") + topic_of<T>().name);
    waitset_ = cyclone_check(dds_create_waitset(cyclone.entity()), "cannot create a wait set");
    const dds_entity_t condition = cyclone_check(dds_create_readcondition(reader_, DDS_ANY_STATE), "cannot wait");
    cyclone_check(dds_waitset_attach(waitset_, condition, 0), "cannot wait");
  }
  ~CycloneSource() override {
    dds_delete(waitset_);
    dds_delete(reader_);
  }

  std::size_t take(std::vector<Taken<T>>& out, std::size_t count) override {
    constexpr int kBatch = 64;
    std::array<void*, kBatch> samples;
    std::array<dds_sample_info_t, kBatch> infos;
    while (true) {
      samples[0] = nullptr;  // asks for a loan
      const int n = dds_take(reader_, samples.data(), infos.data(), kBatch, kBatch);
      if (n <= 0) return count;
      for (int i = 0; i < n; ++i) {
        if (!infos[i].valid_data) continue;
        if (count == out.size()) out.emplace_back();
        Taken<T>& taken = out[count++];
        FromWire from_wire;
        map_fields(from_wire, taken.message, *static_cast<const typename Wire<T>::Type*>(samples[i]));
        taken.source_time_ns = infos[i].source_timestamp;
      }
      dds_return_loan(reader_, samples.data(), n);
      if (n < kBatch) return count;
    }
  }
  bool wait(std::chrono::nanoseconds timeout) override {
    dds_attach_t fired = 0;
    return dds_waitset_wait(waitset_, &fired, 1, std::max<dds_duration_t>(0, timeout.count())) > 0;
  }
  int matched() const override {
    dds_subscription_matched_status_t status;
    return dds_get_subscription_matched_status(reader_, &status) == DDS_RETCODE_OK
               ? static_cast<int>(status.current_count)
               : 0;
  }
  std::uint64_t undecodable() const override { return cyclone_undecodable(topic_of<T>()) - undecodable_before_; }

 private:
  std::shared_ptr<Participant> participant_;
  dds_entity_t reader_ = 0;
  dds_entity_t waitset_ = 0;
  const std::uint64_t undecodable_before_ = cyclone_undecodable(topic_of<T>());
};

}  // namespace

template <class T>
std::unique_ptr<Sink<T>> cyclone_sink(std::shared_ptr<Participant> participant) {
  return std::make_unique<CycloneSink<T>>(std::move(participant));
}

template <class T>
std::unique_ptr<Source<T>> cyclone_source(std::shared_ptr<Participant> participant) {
  return std::make_unique<CycloneSource<T>>(std::move(participant));
}

// NOLINTBEGIN(bugprone-macro-parentheses): T is a type
#define PALP_INSTANTIATE(T)                                                        \
  template std::unique_ptr<Sink<T>> cyclone_sink<T>(std::shared_ptr<Participant>); \
  template std::unique_ptr<Source<T>> cyclone_source<T>(std::shared_ptr<Participant>);
PALP_FOR_EACH_MESSAGE(PALP_INSTANTIATE)
#undef PALP_INSTANTIATE
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace palp
