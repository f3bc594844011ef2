// Sends particle frames in paced chunks from a thread of its own.
#pragma once

#include <semaphore.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <thread>

#include "idl/bus.h"
#include "idl/latest.h"
#include "idl/particle_frame.h"

namespace palp {

// Time from the start of one chunk to the start of the next. A receive buffer of 212992 bytes holds a few chunks, so
// the readers must get a turn between them.
inline constexpr std::chrono::nanoseconds kChunkInterval = std::chrono::microseconds(200);

// frame(), submit() and wanted() belong to one thread, the caller's; they never block, so a real-time thread may call
// them (submit makes one futex call at most; filling the frame allocates only while frames grow).
class ParticleSender {
 public:
  explicit ParticleSender(std::unique_ptr<Writer<ParticleChunk>> writer,
                          std::chrono::nanoseconds chunk_interval = kChunkInterval);
  // Stops within one chunk; a frame under way stays incomplete.
  ~ParticleSender();
  ParticleSender(const ParticleSender&) = delete;
  ParticleSender& operator=(const ParticleSender&) = delete;

  // Returns whether anyone listens, as of at most 100 ms ago. Frames are dropped while nobody does.
  bool wanted() const { return wanted_.load(std::memory_order_relaxed); }
  // Returns the frame to fill; it holds what some earlier frame left there (set every field that is sent).
  ParticleFrame& frame() { return frames_.back(); }
  // Hands frame() over. If the thread is still busy with an earlier frame, it finishes that and takes the latest then.
  void submit();

  struct Counts {
    std::uint64_t sent = 0;            // frames, whole
    std::uint64_t replaced = 0;        // frames that a later one overtook
    std::uint64_t refused_chunks = 0;  // that the vendor would not take
    std::uint64_t bad_frames = 0;      // empty, or with arrays that do not fit each other: not sent
  };
  Counts counts() const;

 private:
  void run();
  void send(const ParticleFrame& frame);

  std::unique_ptr<Writer<ParticleChunk>> writer_;
  const std::chrono::nanoseconds chunk_interval_;
  TripleBuffer<ParticleFrame> frames_;
  sem_t submitted_;
  ParticleChunk chunk_;  // the thread's, kept for its memory
  std::atomic<bool> stop_ = false;
  std::atomic<bool> wanted_ = false;
  std::atomic<std::uint64_t> sent_ = 0;
  std::atomic<std::uint64_t> replaced_ = 0;
  std::atomic<std::uint64_t> refused_chunks_ = 0;
  std::atomic<std::uint64_t> bad_frames_ = 0;
  std::thread thread_;
};

}  // namespace palp
