#include "idl/session_hold.h"

#include <algorithm>

namespace palp {
namespace {

// More than a receiver usually waits between two looks.
constexpr std::int64_t kLongestLookNs = 60'000'000;
// Whoever invents more sessions than this replaces those that have been silent longest.
constexpr std::size_t kMostSenders = 16;

}  // namespace

std::uint64_t SessionHold::look(std::span<const std::uint64_t> heard, std::int64_t now_ns) {
  pass_time(now_ns);
  for (const std::uint64_t session : heard) sender_of(session).silent_ns = 0;
  // the one that is held is judged after all that was heard: others may stand before it in the same look
  const auto by_session = [this](const Sender& s) { return s.session == held_; };
  const auto held = std::find_if(senders_.begin(), senders_.end(), by_session);
  if (held != senders_.end() && held->silent_ns < rule_.free_after_ns) return held_;
  for (const std::uint64_t session : heard) {
    if (sender_of(session).barred) continue;
    if (held_ != 0 && held_ != session) sender_of(held_).barred = rule_.barred_for_ns > 0;
    held_ = session;
    break;
  }
  return held_;
}

void SessionHold::let_go(std::uint64_t session) {
  if (session != held_) return;
  std::erase_if(senders_, [&](const Sender& s) { return s.session == session; });
  held_ = 0;
}

std::uint64_t SessionHold::rival(std::int64_t for_ns) const {
  for (const Sender& s : senders_)
    if (s.session != held_ && s.silent_ns < rule_.free_after_ns && s.heard_for_ns >= for_ns) return s.session;
  return 0;
}

SessionHold::Sender& SessionHold::sender_of(std::uint64_t session) {
  const auto found =
      std::find_if(senders_.begin(), senders_.end(), [&](const Sender& s) { return s.session == session; });
  if (found != senders_.end()) return *found;
  if (senders_.size() < kMostSenders) return senders_.emplace_back(Sender{session});
  const auto key = [this](const Sender& s) { return s.session == held_ ? -1 : s.silent_ns; };
  const auto oldest = std::max_element(senders_.begin(), senders_.end(),
                                       [&](const Sender& a, const Sender& b) { return key(a) < key(b); });
  return *oldest = Sender{session};
}

void SessionHold::pass_time(std::int64_t now_ns) {
  const std::int64_t passed = t_look_ns_ == 0 ? 0 : std::clamp<std::int64_t>(now_ns - t_look_ns_, 0, kLongestLookNs);
  t_look_ns_ = now_ns;
  for (Sender& s : senders_) {
    s.silent_ns += passed;
    s.heard_for_ns = s.silent_ns < rule_.free_after_ns ? s.heard_for_ns + passed : 0;
    if (s.silent_ns >= rule_.barred_for_ns) s.barred = false;
  }
}

}  // namespace palp
