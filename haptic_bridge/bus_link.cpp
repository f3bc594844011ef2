#include "haptic_bridge/bus_link.h"

#include <exception>

#include "idl/clock.h"

namespace palp {

namespace {

using namespace std::chrono_literals;
constexpr std::int64_t kSenderTimeoutNs = 50'000'000;  // only for looking at the stop flag
constexpr std::int64_t kNotePeriodNs = 50'000'000;
constexpr auto kReceiverTimeout = 20ms;
// The last samples of a server that was stopped may still come in while the next one is heard.
constexpr std::int64_t kRivalAfterNs = 300'000'000;

}  // namespace

BusLink::BusLink(Bus& bus, std::uint32_t device, const RealtimeOptions& realtime, LoopPorts& ports)
    : device_(device),
      realtime_(realtime),
      ports_(ports),
      writer_(bus.writer<DeviceSample>()),
      reader_(bus.reader<ProxySample>()),
      number_watch_(bus.session()) {}

BusLink::~BusLink() { stop(); }

bool BusLink::newest_proxy(ProxySample& out) {
  IncomingProxy in;
  const bool came = take_newest(in);
  note_reader();
  if (came) out = in.sample;
  return came;
}

void BusLink::start() {
  sender_ = std::thread([this] { guarded(&BusLink::send_all); });
  receiver_ = std::thread([this] { guarded(&BusLink::receive_all); });
}

void BusLink::stop() {
  stop_ = true;
  ports_.sample_ready.wake();
  if (sender_.joinable()) sender_.join();
  if (receiver_.joinable()) receiver_.join();
}

DropCounts BusLink::drops() const {
  const auto at = [&](std::size_t i) { return drops_[i].load(std::memory_order_relaxed); };
  return {at(0), at(1), at(2), at(3), other_version_.load(std::memory_order_relaxed)};
}

void BusLink::guarded(void (BusLink::*work)()) {
  RealtimeReport ignored;
  make_realtime(realtime_, ignored);
  try {
    (this->*work)();
  } catch (const std::exception& error) {
    if (!failing_.exchange(true)) {
      failure_ = error.what();
      failed_.store(true, std::memory_order_release);
    }
  }
}

void BusLink::send_all() {
  DeviceSample sample;
  while (!stop_) {
    if (!ports_.sample_ready.wait_for(kSenderTimeoutNs) || !ports_.outgoing.take(sample)) continue;
    if (writer_->publish(sample)) {
      sent_.fetch_add(1, std::memory_order_relaxed);
    } else {
      send_failures_.fetch_add(1, std::memory_order_relaxed);
    }
    send_time_.add(now_ns() - sample.t_device_ns);
  }
}

void BusLink::receive_all() {
  IncomingProxy in;
  while (!stop_) {
    reader_->wait(kReceiverTimeout);
    const bool found = take_newest(in);
    // before the sample: one that is sound ends the row of those that are not
    const DropCounts drops = reader_->drops();
    ports_.refused.store(drops.not_finite + drops.malformed, std::memory_order_relaxed);
    if (found) ports_.incoming.put(in);
    note_reader();
  }
}

// Gives the last sample of this device by the server that is held: samples of other devices travel on the same topic.
bool BusLink::take_newest(IncomingProxy& out) {
  batch_.clear();
  heard_.clear();
  reader_->take_all(batch_);
  for (const Received<ProxySample>& r : batch_)
    if (r.message.device == device_) heard_.push_back(r.message.header.session);
  const std::uint64_t server = hold_.look(heard_, now_ns());
  bool found = false;
  for (const Received<ProxySample>& r : batch_) {
    if (r.message.device != device_ || r.message.header.session != server) continue;
    out = {r.message, r.t_receive_ns};
    number_watch_.see(r.message, r.t_receive_ns);
    found = true;
    received_.fetch_add(1, std::memory_order_relaxed);
  }
  server_session_.store(server, std::memory_order_relaxed);
  rival_server_.store(hold_.rival(kRivalAfterNs), std::memory_order_relaxed);
  number_holder_.store(number_watch_.holder(), std::memory_order_relaxed);
  return found;
}

void BusLink::note_reader() {
  const std::int64_t now = now_ns();
  if (now - t_noted_ns_ < kNotePeriodNs) return;
  t_noted_ns_ = now;
  const DropCounts d = reader_->drops();
  drops_[0].store(d.wrong_version, std::memory_order_relaxed);
  drops_[1].store(d.not_finite, std::memory_order_relaxed);
  drops_[2].store(d.malformed, std::memory_order_relaxed);
  drops_[3].store(d.lost, std::memory_order_relaxed);
  other_version_.store(d.other_version, std::memory_order_relaxed);
  servers_.store(reader_->matched_writers(), std::memory_order_relaxed);
}

}  // namespace palp
