#include "haptic_bridge/peers.h"

#include <fmt/format.h>

#include "idl/clock.h"

namespace palp {

void BridgePeers::look() {
  std::vector<Received<Status>> statuses;
  statuses_->take_all(statuses);
  for (const Received<Status>& s : statuses) roster_.add(s);
  roster_.forget(now_ns());
}

std::string BridgePeers::refusal(const BusLink& link) const {
  const std::uint64_t holder = link.number_holder();
  if (holder == 0) return "";
  return fmt::format(
      "device number {} is held by {}, which moves the tool: end that one, or give this one another --device-number",
      device_, roster_.name_of_session(holder));
}

std::string BridgePeers::two_servers(const BusLink& link) const {
  const std::uint64_t other = link.rival_server();
  if (other == 0) return "";
  return fmt::format(
      "two servers answer in this domain: the force comes from {} alone, {} is passed over; end one of the two, or "
      "give it another --domain",
      roster_.name_of_session(link.server_session()), roster_.name_of_session(other));
}

}  // namespace palp
