// The server's threads that talk to the bus, and the mailboxes through which the simulation's thread meets them.
#pragma once

#include <semaphore.h>

#include <array>
#include <atomic>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "idl/bus.h"
#include "idl/frame_ring.h"
#include "idl/latest.h"
#include "idl/particle_sender.h"
#include "idl/session_hold.h"
#include "sim_server/solver/simulation.h"

namespace palp {

struct TimedDeviceSample {
  DeviceSample sample;
  std::int64_t t_receive_ns = 0;
};

// Who holds a device number and who is refused it, by session.
struct NumberHolder {
  std::uint32_t device = 0;
  std::uint64_t holder = 0, refused = 0;
};

// Device samples in, proxy samples out. put and take never wait. A device number belongs to one live bridge: samples of
// another one reach nobody.
class HapticLink {
 public:
  HapticLink(Bus& bus, const Scene& scene);
  ~HapticLink();
  bool take(std::size_t proxy, TimedDeviceSample& out) { return devices_[proxy].take(out); }
  void put(std::size_t proxy, const ProxySample& sample) { proxies_[proxy].put(sample); }
  void flush() { sem_post(&ready_); }  // after the last put of a step
  std::uint64_t dropped() const { return dropped_; }
  // One sentence about a peer that speaks another version of the protocol, while samples of it come; else empty. For
  // one thread of the server's, a few times a second.
  std::string foreign_peer();
  // Any thread. Returns a device number that two bridges use, if there is one.
  std::optional<NumberHolder> contested() const;

 private:
  void receive();
  void hand_over(std::size_t proxy, const std::vector<Received<DeviceSample>>& samples);
  void send();
  const Scene& scene_;
  std::unique_ptr<Reader<DeviceSample>> reader_;
  std::unique_ptr<Writer<ProxySample>> writer_;
  std::array<Latest<TimedDeviceSample>, kMaxProxies> devices_;
  std::array<Latest<ProxySample>, kMaxProxies> proxies_;
  std::vector<SessionHold> holds_{kMaxProxies, SessionHold(kDeviceHold)};  // of the receiver
  std::vector<std::uint64_t> heard_;                                       // of the receiver
  std::array<std::atomic<std::uint64_t>, kMaxProxies> holders_{}, refused_{};
  sem_t ready_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<std::uint64_t> wrong_version_{0};
  std::atomic<std::uint32_t> other_version_{0};
  std::uint64_t wrong_version_told_ = 0;
  std::int64_t tell_until_ns_ = 0;
  std::thread receiver_, sender_;
};

// Particle frames and the rigid bodies' poses that go with them. Frames go to readers on this host through a ring in
// shared memory, to all others as chunks over the bus; either way only while somebody reads there.
class FrameLink {
 public:
  FrameLink(Bus& bus, Simulation& simulation);
  ~FrameLink();
  // Simulation's thread, after a step. Begins a frame if one is due, somebody looks and none is under way. Throws what
  // the back end threw while the last frame was fetched. Returns whether the back end is busy with one from now on.
  bool offer(const StepOutput& output, std::int64_t now_ns);
  void set_rate(double rate_hz) { rate_hz_ = rate_hz; }
  double rate() const { return rate_hz_; }
  void set_scalar(ScalarField scalar) { scalar_ = scalar; }
  ScalarField scalar() const { return scalar_; }
  std::uint64_t sent() const { return sender_.counts().sent; }  // over the bus
  std::uint64_t shared() const { return shared_; }              // by shared memory

 private:
  void forward();
  void share(const ParticleFrame& frame);
  Simulation& simulation_;
  ParticleSender sender_;
  std::unique_ptr<FrameRingWriter> ring_;  // of the thread; null: there is none
  std::atomic<bool> ring_wanted_{false};
  std::atomic<std::uint64_t> shared_{0};
  std::unique_ptr<Writer<BodyPoses>> poses_writer_;
  std::atomic<bool> busy_{false}, stop_{false};
  sem_t begun_;
  std::int64_t next_ns_ = 0;
  double rate_hz_;  // 0: no frames
  ScalarField scalar_ = ScalarField::speed, sending_ = ScalarField::speed;
  BodyPoses poses_;
  Frame frame_;
  std::uint64_t frames_ = 0;
  std::exception_ptr failure_;  // of the thread; once failed_ is set
  std::atomic<bool> failed_{false};
  std::thread thread_;
};

// Commands in; replies, events and status out.
class ControlLink {
 public:
  explicit ControlLink(Bus& bus);
  ~ControlLink();  // sends what is left
  // The simulation's thread. take locks only when a command is there; the others are for rare occasions.
  bool take(Command& out);
  void reply(const Command& to, bool ok, const std::string& text);
  void event(Severity severity, double sim_time, const std::string& text);
  // One thread of the server's.
  void status(const std::string& state, const std::string& text, std::vector<Metric> metrics);
  std::uint64_t dropped() const { return dropped_; }

 private:
  void run();
  void send();
  bool is_full();
  std::unique_ptr<Reader<Command>> reader_;
  std::unique_ptr<Writer<CommandReply>> replies_;
  std::unique_ptr<Writer<Event>> events_;
  std::unique_ptr<Writer<Status>> statuses_;
  std::mutex mutex_;
  std::deque<Command> commands_;
  std::vector<CommandReply> answers_;
  std::vector<Event> news_;
  std::atomic<bool> some_{false}, stop_{false};
  std::atomic<std::uint64_t> dropped_{0};
  std::thread thread_;
};

}  // namespace palp
