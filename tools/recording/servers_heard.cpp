#include "tools/recording/servers_heard.h"

#include <algorithm>

#include "idl/roster.h"
#include "idl/topics.h"

namespace palp {
namespace {

// behind the encapsulation: the key, the version that fills eight bytes, the session
constexpr std::size_t kKeyAt = 4, kSessionAt = kKeyAt + 16;

std::uint64_t word_at(ByteView bytes, std::size_t at) {
  std::uint64_t value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

}  // namespace

void ServersHeard::add(ByteView status, std::uint64_t time_ns) {
  if (status.size() < kSessionAt + 8 || word_at(status, kKeyAt) != process_key(kServerName)) return;
  const auto [server, is_new] = spans_.try_emplace(word_at(status, kSessionAt), Span{time_ns, time_ns});
  if (!is_new) server->second.last_ns = time_ns;
}

std::size_t ServersHeard::together() const {
  return static_cast<std::size_t>(std::count_if(spans_.begin(), spans_.end(), [&](const auto& one) {
    return std::any_of(spans_.begin(), spans_.end(), [&](const auto& other) {
      return other.first != one.first && other.second.first_ns < one.second.last_ns &&
             one.second.first_ns < other.second.last_ns;
    });
  }));
}

}  // namespace palp
