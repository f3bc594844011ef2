#include "idl/roster.h"

#include <unistd.h>

#include <algorithm>
#include <array>

namespace palp {
namespace {

constexpr std::string_view kProcessMetric = "pid_on_";
// Whoever invents more sessions than this replaces those that have been silent longest.
constexpr std::size_t kMostPeers = 64;

std::string host_name() {
  std::array<char, 65> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

}  // namespace

Metric process_metric() {
  static const std::string host = host_name();
  return {std::string(kProcessMetric) + host, static_cast<double>(getpid())};
}

std::string name_of(const Status& status) {
  for (const Metric& m : status.metrics) {
    if (!m.name.starts_with(kProcessMetric) || !(m.value >= 0 && m.value < 1e9)) continue;
    return status.process + " (process " + std::to_string(static_cast<std::int64_t>(m.value)) + " on " +
           m.name.substr(kProcessMetric.size()) + ")";
  }
  return status.process;
}

bool has_ended(const Status& status) { return status.state == "ended" || status.state == "stopped"; }

void Roster::add(const Received<Status>& received) {
  const std::uint64_t session = received.message.header.session;
  const std::string& process = received.message.process;
  for (Peer& peer : peers_) {
    if (peer.session() != session || peer.status.process != process) continue;
    peer = {received.message, received.t_receive_ns};
    return;
  }
  if (peers_.size() < kMostPeers) {
    peers_.push_back({received.message, received.t_receive_ns});
    return;
  }
  const auto oldest = std::min_element(peers_.begin(), peers_.end(),
                                       [](const Peer& a, const Peer& b) { return a.t_receive_ns < b.t_receive_ns; });
  *oldest = {received.message, received.t_receive_ns};
}

void Roster::forget(std::int64_t now_ns) {
  std::erase_if(peers_, [&](const Peer& peer) { return now_ns - peer.t_receive_ns > kGoneAfterNs; });
}

const Peer* Roster::find(std::uint64_t session) const {
  for (const Peer& peer : peers_)
    if (peer.session() == session) return &peer;
  return nullptr;
}

const Peer* Roster::server_beside(std::uint64_t session, std::uint64_t other_session) const {
  for (const Peer& peer : peers_) {
    const bool other = peer.session() != session && peer.session() != other_session;
    if (other && peer.status.process == kServerName && !has_ended(peer.status)) return &peer;
  }
  return nullptr;
}

std::string Roster::name_of_session(std::uint64_t session) const {
  if (const Peer* peer = find(session)) return name_of(peer->status);
  return "a process that has not said its name (session " + std::to_string(session) + ")";
}

}  // namespace palp
