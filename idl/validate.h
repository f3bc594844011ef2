// The one place where samples from the bus are judged, whichever vendor brought them.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "idl/bus.h"
#include "idl/particle_frame.h"
#include "idl/topics.h"

namespace palp {

// Maxima that no sound message passes; they bound what a reader has to hold.
inline constexpr std::uint32_t kMaxParticles = 1u << 24;
inline constexpr std::size_t kMaxBodies = 1u << 16;
inline constexpr std::size_t kMaxMeshFloats = 3u << 22;
inline constexpr std::size_t kMaxMeshIndices = 6u << 22;
inline constexpr std::size_t kMaxMetrics = 1u << 12;
inline constexpr std::size_t kMaxName = 256;
inline constexpr std::size_t kMaxText = 1u << 16;

enum class Fault { none, wrong_version, not_finite, malformed };

// The first fault found. The version is looked at first, for nothing else of such a sample can be trusted.
#define PALP_VALIDATE(T) Fault validate(const T& m);
PALP_FOR_EACH_MESSAGE(PALP_VALIDATE)
#undef PALP_VALIDATE
// The same of a whole frame that came by another way than the bus.
Fault validate(const ParticleFrame& frame);

// Counts the fault, if there is one.
void count(Fault fault, const Header& header, DropCounts& drops);

// One sentence for people if samples of another protocol version were refused on that topic, else empty.
std::string wrong_version_sentence(const char* topic, const DropCounts& drops);

// Counts missing sequence numbers of each session and key. The first sample of a session begins the count; one that
// arrives late stays counted as lost. Remembers a bounded number of sessions.
class SequenceGaps {
 public:
  void arrived(const Header& header, std::uint64_t key);
  std::uint64_t lost() const { return lost_; }

 private:
  struct Entry {
    std::uint64_t session = 0;
    std::uint64_t key = 0;
    std::uint64_t last = 0;
    std::uint64_t used = 0;  // when, to replace the entry that was silent longest
  };
  std::array<Entry, 64> entries_;
  std::uint64_t lost_ = 0;
  std::uint64_t clock_ = 0;
};

}  // namespace palp
