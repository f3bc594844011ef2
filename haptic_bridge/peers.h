// Whom this bridge shares the bus with, as far as people must be told: another bridge of the same device number,
// another server. One thread, not the loop's.
#pragma once

#include <memory>
#include <string>

#include "haptic_bridge/bus_link.h"
#include "idl/roster.h"

namespace palp {

class BridgePeers {
 public:
  BridgePeers(Bus& bus, std::uint32_t device) : device_(device), statuses_(bus.reader<Status>()) {}

  // Takes what has arrived; a few times a second.
  void look();
  // Returns why this bridge must end because another one holds its device number, as one sentence, or empty.
  std::string refusal(const BusLink& link) const;
  // Returns which server is held and which is passed over, as one sentence, or empty where there is one server.
  std::string two_servers(const BusLink& link) const;
  std::string name_of_session(std::uint64_t session) const { return roster_.name_of_session(session); }

 private:
  std::uint32_t device_;
  std::unique_ptr<Reader<Status>> statuses_;
  Roster roster_;
};

}  // namespace palp
