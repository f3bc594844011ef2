#include "idl/bus.h"

#include <algorithm>
#include <random>
#include <stdexcept>
#include <unordered_map>

#include "idl/clock.h"
#include "idl/roster.h"
#include "idl/topics.h"
#include "idl/validate.h"
#include "idl/vendor.h"

namespace palp {
namespace {

class OpenBus : public Bus {
 public:
  explicit OpenBus(const BusOptions& options)
      : participant(options.vendor == Vendor::cyclone ? open_cyclone(options) : open_fastdds(options)) {
    vendor_ = options.vendor;
    domain_ = options.domain;
    std::random_device random;
    while (session_ == 0) session_ = (std::uint64_t{random()} << 32) | random();
  }

  const std::shared_ptr<Participant> participant;
};

// Appends which process sends it, once.
void sign(Status& status) {
  const Metric metric = process_metric();
  if (status.metrics.empty() || status.metrics.back().name != metric.name) status.metrics.push_back(metric);
}
template <class T>
void sign(T&) {}

// Stamps what it sends.
template <class T>
class StampingWriter : public Writer<T> {
 public:
  StampingWriter(std::unique_ptr<Sink<T>> sink, std::uint64_t session) : sink_(std::move(sink)), session_(session) {}

  bool publish(T& message) override {
    message.header.version = kProtocolVersion;
    message.header.session = session_;
    message.header.sequence = ++sequences_[key_of(message)];
    message.header.t_send_ns = now_ns();
    sign(message);
    return sink_->write(message);
  }
  int matched_readers() const override { return sink_->matched(); }

 private:
  std::unique_ptr<Sink<T>> sink_;
  std::uint64_t session_;
  std::unordered_map<std::uint64_t, std::uint64_t> sequences_;  // of each key
};

// Checks and counts what it hands on.
template <class T>
class CheckingReader : public Reader<T> {
 public:
  explicit CheckingReader(std::unique_ptr<Source<T>> source) : source_(std::move(source)) {}

  bool take_latest(Received<T>& out) override {
    const std::size_t n = take();
    if (n == 0) return false;
    std::swap(out.message, taken_[n - 1].message);
    out.t_receive_ns = t_taken_ns_;
    return true;
  }
  std::size_t take_all(std::vector<Received<T>>& out) override {
    const std::size_t n = take();
    for (std::size_t i = 0; i < n; ++i) out.push_back({std::move(taken_[i].message), t_taken_ns_});
    return n;
  }
  bool wait(std::chrono::nanoseconds timeout) override { return source_->wait(timeout); }
  DropCounts drops() const override {
    DropCounts counts = drops_;
    counts.malformed += source_->undecodable();
    counts.lost = gaps_.lost();
    return counts;
  }
  int matched_writers() const override { return source_->matched(); }

 private:
  // Fills the first n of taken_ with sound samples, oldest first.
  std::size_t take() {
    std::size_t n = source_->take(taken_, 0);
    t_taken_ns_ = now_ns();
    // a vendor may group samples by key
    const auto older = [](const Taken<T>& a, const Taken<T>& b) { return a.source_time_ns < b.source_time_ns; };
    if (topic_of<T>().key_bytes > 0)
      std::stable_sort(taken_.begin(), taken_.begin() + static_cast<std::ptrdiff_t>(n), older);
    std::size_t sound = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const T& message = taken_[i].message;
      const Fault fault = validate(message);
      count(fault, message.header, drops_);
      if (fault != Fault::none) continue;
      gaps_.arrived(message.header, key_of(message));
      if (sound != i) std::swap(taken_[sound], taken_[i]);
      ++sound;
    }
    return sound;
  }

  std::unique_ptr<Source<T>> source_;
  std::vector<Taken<T>> taken_;  // kept for its memory
  std::int64_t t_taken_ns_ = 0;
  DropCounts drops_;
  SequenceGaps gaps_;
};

bool plain(const std::string& text) {
  return !text.empty() && text.size() < 256 && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '.' || c == '-' || c == '_' || c == ':';
  });
}

BusOptions checked(BusOptions options) {
  if (options.domain < 0 || options.domain > kMaxDomain) {
    throw std::runtime_error("DDS domain " + std::to_string(options.domain) + " is out of range: expected 0 to " +
                             std::to_string(kMaxDomain));
  }
  for (const std::string& peer : options.peers) {
    if (!plain(peer))
      throw std::runtime_error("peer \"" + peer + "\" is not an address: expected one like 192.168.1.2");
  }
  if (!options.peers.empty()) options.network = true;
  if (!options.interface.empty() && !plain(options.interface)) {
    throw std::runtime_error("network interface \"" + options.interface + "\" is neither a name nor an address");
  }
  if (!options.interface.empty() && !options.network) {
    throw std::runtime_error("--interface has no effect on the loopback interface: give --network or --peer with it");
  }
  return options;
}

}  // namespace

template <class T>
std::unique_ptr<Writer<T>> Bus::writer() {
  auto& bus = static_cast<OpenBus&>(*this);
  return std::make_unique<StampingWriter<T>>(
      vendor_ == Vendor::cyclone ? cyclone_sink<T>(bus.participant) : fastdds_sink<T>(bus.participant), session_);
}

template <class T>
std::unique_ptr<Reader<T>> Bus::reader() {
  auto& bus = static_cast<OpenBus&>(*this);
  return std::make_unique<CheckingReader<T>>(vendor_ == Vendor::cyclone ? cyclone_source<T>(bus.participant)
                                                                        : fastdds_source<T>(bus.participant));
}

// NOLINTBEGIN(bugprone-macro-parentheses): T is a type
#define PALP_INSTANTIATE(T)                             \
  template std::unique_ptr<Writer<T>> Bus::writer<T>(); \
  template std::unique_ptr<Reader<T>> Bus::reader<T>();
PALP_FOR_EACH_MESSAGE(PALP_INSTANTIATE)
#undef PALP_INSTANTIATE
// NOLINTEND(bugprone-macro-parentheses)

std::unique_ptr<Bus> open_bus(const BusOptions& options) { return std::make_unique<OpenBus>(checked(options)); }

const char* to_string(Vendor vendor) { return vendor == Vendor::cyclone ? "cyclone" : "fastdds"; }

Vendor vendor_from(const std::string& text) {
  if (text == "cyclone") return Vendor::cyclone;
  if (text == "fastdds") return Vendor::fastdds;
  throw std::invalid_argument("unknown DDS vendor \"" + text + "\": expected cyclone or fastdds");
}

}  // namespace palp
