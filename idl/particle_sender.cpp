#include "idl/particle_sender.h"

#include <sys/prctl.h>

#include <ctime>

#include "idl/clock.h"
#include "idl/validate.h"

namespace palp {
namespace {

constexpr std::int64_t kIdleNs = 100'000'000;

// Returns when posted, or after kIdleNs.
void wait_for_post(sem_t& semaphore) {
  const timespec t = to_timespec(now_ns() + kIdleNs);
  sem_clockwait(&semaphore, CLOCK_MONOTONIC, &t);
}

bool sendable(const ParticleFrame& f) {
  const std::size_t n = f.positions.size() / 3;
  return n <= kMaxParticles && f.positions.size() == 3 * n &&
         f.scalars.size() == (f.field == ScalarField::none ? 0 : n) && (f.solid.empty() || f.solid.size() == n);
}

}  // namespace

ParticleSender::ParticleSender(std::unique_ptr<Writer<ParticleChunk>> writer, std::chrono::nanoseconds chunk_interval)
    : writer_(std::move(writer)), chunk_interval_(chunk_interval) {
  sem_init(&submitted_, 0, 0);
  thread_ = std::thread([this] { run(); });
}

ParticleSender::~ParticleSender() {
  stop_ = true;
  sem_post(&submitted_);
  thread_.join();
  sem_destroy(&submitted_);
}

void ParticleSender::submit() {
  if (!frames_.publish()) replaced_.fetch_add(1, std::memory_order_relaxed);
  sem_post(&submitted_);
}

ParticleSender::Counts ParticleSender::counts() const { return {sent_, replaced_, refused_chunks_, bad_frames_}; }

void ParticleSender::run() {
  prctl(PR_SET_NAME, "particles");
  // the default slack of 50 us would stretch a pace of 200 us by a quarter
  prctl(PR_SET_TIMERSLACK, 1000);
  while (!stop_) {
    wait_for_post(submitted_);
    const bool wanted = writer_->matched_readers() > 0;
    wanted_.store(wanted, std::memory_order_relaxed);
    if (!frames_.update() || !wanted) continue;
    if (sendable(frames_.front())) {
      send(frames_.front());
    } else {
      ++bad_frames_;
    }
  }
}

void ParticleSender::send(const ParticleFrame& frame) {
  chunk_.frame = frame.frame;
  chunk_.sim_time = frame.sim_time;
  chunk_.field = frame.field;
  const auto count = chunks_of(static_cast<std::uint32_t>(frame.positions.size() / 3));
  bool whole = true;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (stop_) return;
    const std::int64_t t_start_ns = now_ns();
    fill_chunk(i, frame.positions, frame.scalars, frame.solid, chunk_);
    if (!writer_->publish(chunk_)) {
      ++refused_chunks_;
      whole = false;
    }
    sleep_until(t_start_ns + chunk_interval_.count());
  }
  if (whole) ++sent_;
}

}  // namespace palp
