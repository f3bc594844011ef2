#include "haptic_bridge/run.h"

namespace palp {

namespace {

// Says that the loop is alive. When it ends, the device is left without force before it is silent.
class Pulse {
 public:
  Pulse(Heartbeat* heartbeat, HapticLoop& loop) : heartbeat_(heartbeat), loop_(loop) {}
  ~Pulse() {
    loop_.release();
    if (heartbeat_ != nullptr) heartbeat_->rest();
  }
  Pulse(const Pulse&) = delete;
  Pulse& operator=(const Pulse&) = delete;
  // False: the loop was taken for dead.
  bool beat(std::int64_t now_ns) const { return heartbeat_ == nullptr || heartbeat_->beat(now_ns); }

 private:
  Heartbeat* heartbeat_;
  HapticLoop& loop_;
};

}  // namespace

LoopFault run_loop(HapticLoop& loop, Clock& clock, LoopPorts& ports, FlightLog& log, const std::atomic<bool>& stop,
                   std::uint64_t max_ticks) {
  const std::int64_t period = loop.config().period_ns;
  const Pulse pulse(ports.heartbeat, loop);
  IncomingProxy incoming;
  const std::int64_t cpu_before = clock.cpu_ns();
  std::uint64_t refused = ports.refused.load(std::memory_order_relaxed);
  std::int64_t deadline = clock.now_ns() + period;

  for (std::uint64_t i = 0; !stop.load(std::memory_order_relaxed) && (max_ticks == 0 || i < max_ticks); ++i) {
    clock.sleep_until(deadline);
    const std::int64_t now = clock.now_ns();
    const std::int64_t missed = (now - deadline) / period;
    if (!pulse.beat(now))
      loop.fail(LoopFault::taken_for_dead);
    else if (ports.unguarded.load(std::memory_order_relaxed))
      loop.fail(LoopFault::unguarded);

    const std::uint64_t refused_now = ports.refused.load(std::memory_order_relaxed);
    loop.note_refused(refused_now - refused);
    refused = refused_now;
    const bool came = ports.incoming.take(incoming);
    loop.tick(now, now - deadline, static_cast<std::uint32_t>(missed), came ? &incoming : nullptr);

    if (loop.worth_sending()) {
      ports.outgoing.put(loop.sample());
      ports.sample_ready.wake();
    }
    ports.report.put(loop.report());
    TickRecord record = loop.record();
    ports.lateness.add(record.lateness_ns);
    if (record.state != LoopState::waiting && record.state != LoopState::stale) ports.age.add(record.age_ns);
    if (record.verdict == static_cast<std::int32_t>(Verdict::accepted)) ports.delay.add(record.delay_ns);
    record.duration_ns = clock.now_ns() - now;
    ports.duration.add(record.duration_ns);
    log.add(record, loop.input());

    if (loop.report().fault != LoopFault::none) break;
    deadline += (1 + missed) * period;
  }
  ports.cpu_ns = clock.cpu_ns() - cpu_before;
  return loop.report().fault;
}

}  // namespace palp
