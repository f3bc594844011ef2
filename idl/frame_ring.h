// Particle frames on one host: a server writes them into a file in shared memory, beside the bus, and whoever may open
// that file takes whole frames from it. It works alike with both vendors and loses nothing to the buffers of sockets.
//
// Nothing announces it: its name is made of the domain and of the server's session, which every sample carries. Who
// does not find it there is on another host, in another container or another user, and takes the chunks from the bus.
//
// The file is read and written by system calls and mapped by nobody. So what a reader judges is a copy that nobody can
// change meanwhile, and a file that is cut short or memory that is used up is an answer of the system, not a signal.
//
//   page 0   RingHeader
//   slots    kRingSlots times: SlotHeader, 3 floats a particle, 1 float a particle, 1 byte a particle
//
// Frame number n (from 1) lies in slot n % kRingSlots. The writer sets begun[slot] = n, writes the slot, sets newest =
// n, and waits for nobody. A reader reads newest, the slot, and then begun[slot]: if that is still n, the slot held
// frame n, whole, all the while. The writer comes back to a slot after two other frames.
//
// Locks of open files say who is there, and end with their process however it ends: the server holds byte 0, so that a
// file whose byte 0 is free was left by a dead one and may be removed; each reader shares byte 1, by which the server
// sees that it has readers. Nobody ever waits for a lock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "idl/particle_frame.h"

namespace palp {

// Raised with every change of what lies in the file. It is a part of the name: other layouts are other files.
inline constexpr std::uint64_t kRingLayout = 1;
inline constexpr std::size_t kRingSlots = 3;

// Which ring is meant.
struct RingPlace {
  int domain = 0;
  std::uint64_t session = 0;         // of the server's bus
  std::uint32_t particle_count = 0;  // of each frame
  std::string folder = "/dev/shm";
};

struct RingHeader {
  std::array<char, 8> magic{'p', 'a', 'l', 'p', 'r', 'i', 'n', 'g'};
  std::uint64_t layout = kRingLayout;
  std::uint64_t domain = 0, session = 0, particle_count = 0;
  std::uint64_t newest = 0;  // frame that is whole; 0: none yet; kRingClosed: no more will come
  std::array<std::uint64_t, kRingSlots> begun{};
};
inline constexpr std::uint64_t kRingClosed = ~std::uint64_t{0};

struct SlotHeader {
  std::uint64_t frame = 0;
  double sim_time = 0;
  std::int64_t t_send_ns = 0;
  std::uint32_t field = 0;
  std::uint32_t with_solid = 0;  // 1: the bytes are there
};

std::string path_of(const RingPlace& place);
// Returns where a slot begins, in bytes; kRingSlots: where the file ends.
std::size_t slot_begin(std::size_t slot, std::uint32_t particle_count);

// An open file with its end.
class RingFile {
 public:
  explicit RingFile(int file = -1) : file_(file) {}
  RingFile(RingFile&& other) noexcept;
  RingFile& operator=(RingFile&& other) noexcept;
  ~RingFile();
  int number() const { return file_; }

 private:
  int file_;
};

// One thread.
class FrameRingWriter {
 public:
  // Makes the ring, for readers of this user, and removes those that dead servers have left. Takes a page of memory;
  // the slots take theirs as they are written. Throws std::runtime_error with one sentence.
  explicit FrameRingWriter(const RingPlace& place);
  // Takes the file away. Who has it open finds nothing new there.
  ~FrameRingWriter();
  FrameRingWriter(const FrameRingWriter&) = delete;
  FrameRingWriter& operator=(const FrameRingWriter&) = delete;

  // Returns whether anybody has the ring open to read.
  bool has_readers() const;
  // Writes a frame with the time of now, as sent. Returns false where that cannot be done, as its particles are not as
  // many as the ring's or the memory is used up: then the ring is closed, and its readers go back to the bus.
  bool write(const ParticleFrame& frame);

 private:
  bool close_ring();

  const RingPlace place_;
  RingFile file_;
  std::uint64_t written_ = 0;
};

enum class RingAnswer {
  nothing,  // newer than what was taken before
  frame,
  refused,  // a frame that no sound writer writes; it was passed over
  closed    // no frame will come any more
};

// One thread.
class FrameRingReader {
 public:
  // Opens the ring to take the frames that are written from now on. Throws std::runtime_error with one sentence where
  // there is none, or none that this process may open or understands.
  explicit FrameRingReader(const RingPlace& place);

  // Puts the newest frame into out, if it has not been taken yet; the memory of out is used again. Any other answer
  // leaves out with values of no use.
  RingAnswer take(ParticleFrame& out);

 private:
  bool copy_slot(std::uint64_t number, ParticleFrame& out) const;

  const RingPlace place_;
  RingFile file_;
  std::uint64_t taken_ = 0;
};

}  // namespace palp
