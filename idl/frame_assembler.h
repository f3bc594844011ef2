// Puts particle chunks together into complete frames.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "idl/bus.h"
#include "idl/particle_frame.h"

namespace palp {

// Chunks may come in any order, twice or not at all; a frame that stays incomplete is dropped when a newer one is
// complete or its place is needed. The sender may restart (a new session, or a frame number far behind): the new frames
// count. Memory grows with the bytes received, not with what a chunk claims. One thread.
class FrameAssembler {
 public:
  struct Counts {
    std::uint64_t complete = 0;
    std::uint64_t incomplete = 0;  // frames that began and were given up
    std::uint64_t late = 0;        // chunks of frames or sessions already passed
    std::uint64_t duplicate = 0;   // chunks
    std::uint64_t refused = 0;     // chunks that contradict themselves or their frame
  };

  // True if the chunk completed a frame; take() gives it out.
  bool add(const ParticleChunk& chunk, std::int64_t t_receive_ns);
  bool add(const Received<ParticleChunk>& received) { return add(received.message, received.t_receive_ns); }

  // Swaps the newest complete frame into out, if it was not taken yet. Else false and out is untouched. Giving the same
  // out again and again lets the memory go round.
  bool take(ParticleFrame& out);

  const Counts& counts() const { return counts_; }

 private:
  static constexpr std::size_t kOpenFrames = 3;
  static constexpr std::size_t kPastSessions = 8;
  // A frame number this far behind the newest is no latecomer: the numbering began anew.
  static constexpr std::uint64_t kRestart = 32;

  struct Open {
    bool used = false;
    ParticleFrame frame;
    std::uint32_t particle_count = 0;
    bool with_solid = false;
    std::uint32_t arrived = 0;
    std::uint64_t touched = 0;  // when, in chunks
    bool in_order = true;
    std::vector<std::uint32_t> order;  // which chunk came when
    std::vector<bool> seen;
  };

  bool follow_session(const ParticleChunk& chunk);
  Open* open_for(const ParticleChunk& chunk);
  void begin(Open& open, const ParticleChunk& chunk);
  void sort(Open& open);
  void give_up(Open& open);
  void restart();

  std::array<Open, kOpenFrames> open_;
  ParticleFrame newest_;
  std::vector<float> scratch_;
  std::vector<std::uint8_t> scratch_bytes_;
  std::uint64_t clock_ = 0;
  bool fresh_ = false;  // newest_ was not taken yet
  bool any_ = false;    // a frame of this session was complete
  std::uint64_t newest_frame_ = 0;
  std::uint64_t session_ = 0;
  std::array<std::uint64_t, kPastSessions> past_sessions_{};
  std::size_t next_past_ = 0;
  Counts counts_;
};

}  // namespace palp
