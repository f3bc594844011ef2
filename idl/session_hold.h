// Holds on to one of several senders of the same thing. A device number belongs to one bridge and a scene to one
// server; whoever else sends the same is passed over until the one that is held has fallen silent. Senders are told
// apart by the session in their messages' headers. Pure: sessions and times go in, no bus is needed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace palp {

struct HoldRule {
  // A sender that has been silent this long is held no more: the next one that is heard takes its place.
  std::int64_t free_after_ns = 0;
  // A sender that lost its place gets it back only once it has been silent this long; 0: as any other. For senders
  // that were stopped and go on later, as if nothing had happened.
  std::int64_t barred_for_ns = 0;
};

// A bridge renders no force from data this old, so the change takes nothing from the hand.
inline constexpr HoldRule kServerHold{100'000'000, 0};
// Twice the time after which the bridge that held the number has no force any more; a bridge that is killed and started
// again waits no longer than that.
inline constexpr HoldRule kDeviceHold{200'000'000, 20'000'000'000};
// For people who look on: several times the period of a server's status.
inline constexpr HoldRule kViewHold{1'000'000'000, 0};

// One thread.
class SessionHold {
 public:
  explicit SessionHold(const HoldRule& rule) : rule_(rule) {}

  // Takes in whose messages have arrived since the last call, in any order, and returns the session that is held, 0
  // before the first. Time during which nobody called counts little: a receiver that stood still finds everyone silent.
  std::uint64_t look(std::span<const std::uint64_t> heard, std::int64_t now_ns);

  std::uint64_t held() const { return held_; }
  // Lets go of the session that is held, if it is this one: its sender has said that it ends.
  void let_go(std::uint64_t session);
  // Returns a sender that is passed over, heard of late and for at least that long; 0 if there is none.
  std::uint64_t rival(std::int64_t for_ns) const;

 private:
  struct Sender {
    std::uint64_t session = 0;
    std::int64_t heard_for_ns = 0;  // since it was first heard, without long silence
    std::int64_t silent_ns = 0;
    bool barred = false;
  };

  Sender& sender_of(std::uint64_t session);
  void pass_time(std::int64_t now_ns);

  HoldRule rule_;
  std::vector<Sender> senders_;
  std::uint64_t held_ = 0;
  std::int64_t t_look_ns_ = 0;  // 0: never
};

}  // namespace palp
