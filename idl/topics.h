// The topics and their quality of service, one row per message, for both vendors, the recorder and the replayer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "idl/messages.h"

namespace palp {

enum class Reliability { best_effort, reliable };
enum class Durability { volatile_only, transient_local };

struct TopicRow {
  const char* name;
  const char* type_name;  // on the wire, the same for both vendors
  std::size_t key_bytes;  // on the wire, where the key is the first member of the type and of fixed size; 0: no key
  Reliability reliability;
  Durability durability;
  int writer_depth;  // history is always KEEP_LAST: nothing a slow reader does may block a writer
  int reader_depth;
};

// At most this many keys live at once in a reader or writer; a peer that invents more of them gets no further.
inline constexpr int kMaxKeys = 64;

// A chunk is 64 kB and a frame of 1,000,000 particles 250 chunks: a reader that looks 60 times a second must hold a few
// frames. Both vendors take the memory when chunks arrive, so small scenes do not pay for this.
inline constexpr int kParticleReaderDepth = 768;

// No deadline and no liveliness: readers judge each sample by its age, which covers every cause of silence, and neither
// costs the 1 kHz writers a timer.
inline constexpr std::array kTopics = std::to_array<TopicRow>({
    // State at 1 kHz: only the newest counts, a repeated old one would do harm. Readers keep a few, so that a second
    // sender of the same key cannot push out what the one that counts has sent (session_hold.h).
    {"palp/device", "palp::wire::DeviceSample", 4, Reliability::best_effort, Durability::volatile_only, 1, 8},
    {"palp/proxy", "palp::wire::ProxySample", 4, Reliability::best_effort, Durability::volatile_only, 1, 8},
    // Frames: a lost chunk costs one picture, sending it again would delay the next.
    {"palp/particles", "palp::wire::ParticleChunk", 0, Reliability::best_effort, Durability::volatile_only, 1,
     kParticleReaderDepth},
    // Needed by all, whenever they start; of several servers, each.
    {"palp/scene", "palp::wire::SceneDescription", 0, Reliability::reliable, Durability::transient_local, 1, 4},
    // As the particle frames that they go with; a few, for readers that match them to frames.
    {"palp/bodies", "palp::wire::BodyPoses", 0, Reliability::best_effort, Durability::volatile_only, 1, 4},
    // The last word of each process; who joins late need not wait for the next.
    {"palp/status", "palp::wire::Status", 8, Reliability::reliable, Durability::transient_local, 1, 4},
    // People must see them, also in a viewer that was started because of them.
    {"palp/event", "palp::wire::Event", 0, Reliability::reliable, Durability::transient_local, 32, 64},
    // Must arrive, but not later: who was not there must not act on it.
    {"palp/command", "palp::wire::Command", 0, Reliability::reliable, Durability::volatile_only, 64, 64},
    {"palp/command_reply", "palp::wire::CommandReply", 0, Reliability::reliable, Durability::volatile_only, 64, 64},
});

// Runs macro for every message type, in the order of kTopics.
#define PALP_FOR_EACH_MESSAGE(macro)                                                                                 \
  macro(DeviceSample) macro(ProxySample) macro(ParticleChunk) macro(SceneDescription) macro(BodyPoses) macro(Status) \
      macro(Event) macro(Command) macro(CommandReply)

enum class TopicNumber : std::size_t {
#define PALP_NUMBER(T) of_##T,
  PALP_FOR_EACH_MESSAGE(PALP_NUMBER)
#undef PALP_NUMBER
};

// Declared for messages only.
#define PALP_ROW(T)                                                                                           \
  constexpr const TopicRow& row_of(const T*) {                                                                \
    constexpr const TopicRow& row = kTopics[static_cast<std::size_t>(TopicNumber::of_##T)];                   \
    static_assert(row.type_name == std::string_view("palp::wire::" #T), "a row of kTopics in another place"); \
    return row;                                                                                               \
  }
PALP_FOR_EACH_MESSAGE(PALP_ROW)
#undef PALP_ROW

template <class T>
constexpr const TopicRow& topic_of() {
  return row_of(static_cast<const T*>(nullptr));
}

// FNV-1a: the key of a Status, made from the name of its process.
constexpr std::uint64_t process_key(std::string_view process) {
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : process) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hash;
}

// Returns the key within the topic; 0 where the topic has none.
template <class T>
std::uint64_t key_of([[maybe_unused]] const T& m) {
  constexpr std::size_t bytes = topic_of<T>().key_bytes;
  if constexpr (bytes == 0) {
    return 0;
  } else if constexpr (requires { m.device; }) {
    static_assert(bytes == sizeof m.device);
    return m.device;
  } else {
    static_assert(bytes == sizeof process_key(m.process));
    return process_key(m.process);
  }
}

}  // namespace palp
