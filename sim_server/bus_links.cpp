#include "sim_server/bus_links.h"

#include <spdlog/spdlog.h>

#include <cerrno>
#include <cmath>
#include <ctime>

#include "config/error.h"
#include "idl/clock.h"
#include "idl/topics.h"
#include "idl/validate.h"
#include "sim_server/messages_from_state.h"

namespace palp {
namespace {

constexpr double kLongestPeriodNs = 1e18;
// A bridge that was started again in the place of a killed one is passed over for less long than this.
constexpr std::int64_t kRefusedAfterNs = 500'000'000;
constexpr std::int64_t kLookForReadersNs = 100'000'000;
constexpr std::size_t kMostCommands = 64;  // that wait; a peer that sends more, faster, waits itself

std::uint64_t refused(const DropCounts& d) { return d.wrong_version + d.not_finite + d.malformed; }

// Takes the posts that have piled up meanwhile: one is enough, as only the newest data matters.
void swallow_posts(sem_t& semaphore) {
  while (sem_trywait(&semaphore) == 0) {
  }
}

// Waits for a post.
void wait_for(sem_t& semaphore) {
  while (sem_wait(&semaphore) != 0) {
  }
  swallow_posts(semaphore);
}

// Waits for a post, but not past a time on the monotonic clock. False: there was no post.
bool wait_until(sem_t& semaphore, std::int64_t t_ns) {
  const timespec until = to_timespec(t_ns);
  while (sem_clockwait(&semaphore, CLOCK_MONOTONIC, &until) != 0)
    if (errno != EINTR) return false;
  swallow_posts(semaphore);
  return true;
}

std::unique_ptr<FrameRingWriter> make_ring(const Bus& bus, const Scene& scene) {
  try {
    return std::make_unique<FrameRingWriter>(
        RingPlace{bus.domain(), bus.session(), static_cast<std::uint32_t>(scene.position.size())});
  } catch (const std::exception& error) {
    spdlog::warn("particles go over the bus alone: {}", error.what());
    return nullptr;
  }
}

}  // namespace

HapticLink::HapticLink(Bus& bus, const Scene& scene)
    : scene_(scene), reader_(bus.reader<DeviceSample>()), writer_(bus.writer<ProxySample>()) {
  sem_init(&ready_, 0, 0);
  receiver_ = std::thread(&HapticLink::receive, this);
  sender_ = std::thread(&HapticLink::send, this);
}

HapticLink::~HapticLink() {
  stop_ = true;
  sem_post(&ready_);
  receiver_.join();
  sender_.join();
  sem_destroy(&ready_);
}

std::string HapticLink::foreign_peer() {
  DropCounts drops;
  drops.wrong_version = wrong_version_;
  drops.other_version = other_version_;
  const std::string sentence = wrong_version_sentence(topic_of<DeviceSample>().name, drops);
  if (drops.wrong_version != wrong_version_told_) {
    if (wrong_version_told_ == 0) spdlog::warn("{}", sentence);
    wrong_version_told_ = drops.wrong_version;
    tell_until_ns_ = now_ns() + 5'000'000'000;
  }
  return now_ns() < tell_until_ns_ ? sentence : "";
}

void HapticLink::receive() {
  std::vector<Received<DeviceSample>> samples;
  while (!stop_) {
    reader_->wait(std::chrono::milliseconds(50));  // what cannot be decoded is counted, but wakes nobody
    samples.clear();
    reader_->take_all(samples);
    for (std::size_t p = 0; p < scene_.proxies.size(); ++p) hand_over(p, samples);
    const DropCounts drops = reader_->drops();
    dropped_ = refused(drops);
    other_version_ = drops.other_version;
    wrong_version_ = drops.wrong_version;
  }
}

void HapticLink::hand_over(std::size_t proxy, const std::vector<Received<DeviceSample>>& samples) {
  const std::uint32_t device = scene_.proxies[proxy].device;
  heard_.clear();
  for (const Received<DeviceSample>& s : samples)
    if (s.message.device == device) heard_.push_back(s.message.header.session);
  SessionHold& hold = holds_[proxy];
  const std::uint64_t held = hold.look(heard_, now_ns());
  for (const Received<DeviceSample>& s : samples)
    if (s.message.device == device && s.message.header.session == held)
      devices_[proxy].put({s.message, s.t_receive_ns});
  holders_[proxy].store(held, std::memory_order_relaxed);
  refused_[proxy].store(hold.rival(kRefusedAfterNs), std::memory_order_relaxed);
}

std::optional<NumberHolder> HapticLink::contested() const {
  for (std::size_t p = 0; p < scene_.proxies.size(); ++p)
    if (const std::uint64_t refused = refused_[p].load(std::memory_order_relaxed))
      return NumberHolder{scene_.proxies[p].device, holders_[p].load(std::memory_order_relaxed), refused};
  return std::nullopt;
}

void HapticLink::send() {
  std::array<ProxySample, kMaxProxies> newest{};
  int repeats = kMostRepeats;
  while (!stop_) {
    if (repeats == kMostRepeats) {
      wait_for(ready_);
      repeats = 0;
    } else if (wait_until(ready_, now_ns() + kRepeatAfterNs)) {
      repeats = 0;
    } else {
      for (ProxySample& s : newest)
        if (repeat(s, repeats)) writer_->publish(s);
      ++repeats;
      continue;
    }
    for (std::size_t p = 0; p < scene_.proxies.size(); ++p)
      if (proxies_[p].take(newest[p])) writer_->publish(newest[p]);
  }
}

FrameLink::FrameLink(Bus& bus, Simulation& simulation)
    : simulation_(simulation),
      sender_(bus.writer<ParticleChunk>()),
      ring_(make_ring(bus, simulation.scene())),
      poses_writer_(bus.writer<BodyPoses>()),
      rate_hz_(simulation.scene().config.stream.particle_rate_hz),
      scalar_(simulation.scene().config.stream.scalar) {
  sem_init(&begun_, 0, 0);
  thread_ = std::thread(&FrameLink::forward, this);
}

FrameLink::~FrameLink() {
  stop_ = true;
  sem_post(&begun_);
  thread_.join();
  sem_destroy(&begun_);
}

bool FrameLink::offer(const StepOutput& output, std::int64_t now_ns) {
  if (failed_.load(std::memory_order_acquire)) std::rethrow_exception(failure_);
  if (!(rate_hz_ > 0) || now_ns < next_ns_ || busy_.load(std::memory_order_acquire)) return false;
  if (!sender_.wanted() && !ring_wanted_.load(std::memory_order_relaxed)) return false;
  if (!simulation_.begin_frame(scalar_)) return false;
  const auto period_ns = static_cast<std::int64_t>(std::min(1e9 / rate_hz_, kLongestPeriodNs));
  next_ns_ = std::max(next_ns_ + period_ns, now_ns - period_ns);
  sending_ = scalar_;
  poses_ = body_poses(simulation_.scene(), output);
  busy_.store(true, std::memory_order_release);
  sem_post(&begun_);
  return true;
}

void FrameLink::forward() {
  while (true) {
    const bool begun = wait_until(begun_, now_ns() + kLookForReadersNs);
    if (stop_) return;
    ring_wanted_ = ring_ && ring_->has_readers();
    if (!begun) continue;
    try {
      while (!simulation_.take_frame(frame_)) std::this_thread::sleep_for(std::chrono::microseconds(100));
    } catch (...) {
      failure_ = std::current_exception();
      failed_.store(true, std::memory_order_release);
      return;
    }
    ParticleFrame& out = sender_.frame();
    out.frame = ++frames_;
    out.sim_time = frame_.time;
    out.field = sending_;
    std::swap(out.positions, frame_.position);
    std::swap(out.scalars, frame_.scalar);
    std::swap(out.solid, frame_.solid);
    if (ring_wanted_) share(out);
    sender_.submit();
    if (!poses_.body.empty()) poses_writer_->publish(poses_);
    busy_.store(false, std::memory_order_release);
  }
}

void FrameLink::share(const ParticleFrame& frame) {
  if (ring_->write(frame)) {
    ++shared_;
    return;
  }
  spdlog::warn("shared memory for frames of {} particles is used up: from now on they go over the bus alone",
               frame.positions.size() / 3);
  ring_ = nullptr;
  ring_wanted_ = false;
}

ControlLink::ControlLink(Bus& bus)
    : reader_(bus.reader<Command>()),
      replies_(bus.writer<CommandReply>()),
      events_(bus.writer<Event>()),
      statuses_(bus.writer<Status>()) {
  thread_ = std::thread(&ControlLink::run, this);
}

ControlLink::~ControlLink() {
  stop_ = true;
  thread_.join();
}

bool ControlLink::take(Command& out) {
  if (!some_.load(std::memory_order_acquire)) return false;
  const std::lock_guard lock(mutex_);
  out = std::move(commands_.front());
  commands_.pop_front();
  some_.store(!commands_.empty(), std::memory_order_release);
  return true;
}

void ControlLink::reply(const Command& to, bool ok, const std::string& text) {
  const std::lock_guard lock(mutex_);
  CommandReply& r = answers_.emplace_back();
  r.command_session = to.header.session;
  r.command_sequence = to.header.sequence;
  r.ok = ok;
  r.text = text.substr(0, kMaxText);
}

void ControlLink::event(Severity severity, double sim_time, const std::string& text) {
  const std::lock_guard lock(mutex_);
  Event& e = news_.emplace_back();
  e.process = "sim_server";
  e.severity = severity;
  e.sim_time = sim_time;
  e.text = text.substr(0, kMaxText);
}

bool ControlLink::is_full() {
  const std::lock_guard lock(mutex_);
  return commands_.size() >= kMostCommands;
}

void ControlLink::run() {
  std::vector<Received<Command>> arrived;
  while (true) {
    const bool last = stop_;
    send();
    if (last) return;
    if (is_full()) {  // the reader keeps what its depth has room for
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      continue;
    }
    reader_->wait(std::chrono::milliseconds(20));
    arrived.clear();
    reader_->take_all(arrived);
    const DropCounts drops = reader_->drops();
    dropped_ = refused(drops);
    const std::lock_guard lock(mutex_);
    for (Received<Command>& c : arrived) commands_.push_back(std::move(c.message));
    some_.store(!commands_.empty(), std::memory_order_release);
  }
}

void ControlLink::send() {
  std::vector<CommandReply> answers;
  std::vector<Event> news;
  {
    const std::lock_guard lock(mutex_);
    std::swap(answers, answers_);
    std::swap(news, news_);
  }
  for (CommandReply& r : answers) replies_->publish(r);
  for (Event& e : news) events_->publish(e);
}

void ControlLink::status(const std::string& state, const std::string& text, std::vector<Metric> metrics) {
  Status s;
  s.process = "sim_server";
  s.state = state;
  s.text = text;
  // one that is not finite would have every reader refuse the rest, too
  std::erase_if(metrics, [](const Metric& m) { return !std::isfinite(m.value); });
  s.metrics = std::move(metrics);
  statuses_->publish(s);
}

}  // namespace palp
