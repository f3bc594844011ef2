// Who is on the bus: the newest status of every process, told apart by session, so that two processes of one name are
// two entries. Pure but for Roster's reader.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "idl/bus.h"

namespace palp {

inline constexpr const char* kServerName = "sim_server";

// A process is on the bus while it says something at least this often.
inline constexpr std::int64_t kGoneAfterNs = 3'000'000'000;

struct Peer {
  Status status;
  std::int64_t t_receive_ns = 0;  // of its newest status, on this host's clock
  std::uint64_t session() const { return status.header.session; }
};

class Roster {
 public:
  void add(const Received<Status>& received);
  // Drops processes that have been silent for kGoneAfterNs.
  void forget(std::int64_t now_ns);

  const std::vector<Peer>& peers() const { return peers_; }
  // Returns null if nobody of that session is there.
  const Peer* find(std::uint64_t session) const;
  // Returns a server that runs and has neither of these sessions, or null.
  const Peer* server_beside(std::uint64_t session, std::uint64_t other_session = 0) const;
  // Returns who a session is, in words for people: see name_of; a number where it has said nothing of itself.
  std::string name_of_session(std::uint64_t session) const;

 private:
  std::vector<Peer> peers_;
};

// Every status says which process of which host sent it, by a metric "pid_on_HOST", which the bus appends.
Metric process_metric();
// Returns "haptic_bridge 0 (process 4711 on lab3)", or only the name where the process did not say.
std::string name_of(const Status& status);
// Says whether the process has ended, by its own last word.
bool has_ended(const Status& status);

}  // namespace palp
