// Which samples of the server are let through to the force. Nothing from the bus is trusted: what is not finite, out of
// range, out of order or meant for somebody else is counted and dropped.
#pragma once

#include <array>
#include <cstdint>

#include "idl/messages.h"

namespace palp {

// A sample and when it came in, on this host's monotonic clock.
struct IncomingProxy {
  ProxySample sample;
  std::int64_t t_receive_ns = 0;
};

enum class Verdict : std::uint32_t {
  accepted = 0,
  restarted,  // accepted, and it comes from a new session of the server: everything known of the old one is void
  not_finite,
  bad_range,     // quaternion, blend, stamps or device number that cannot be
  bad_gains,     // gains beyond those that were proposed
  out_of_order,  // not newer than the last one, or of the session before this one
  other_bridge,  // computed from samples of another bridge, or of none yet
  repeated,      // an answer that was accepted before, sent again
};
inline constexpr std::size_t kVerdicts = 8;
const char* to_string(Verdict verdict);

class SampleGate {
 public:
  // own_session: of this bridge, as its DeviceSamples carry it. proposed: the most that the gains may come back as.
  SampleGate(std::uint32_t device, std::uint64_t own_session, const CouplingGains& proposed)
      : device_(device), own_session_(own_session), proposed_(proposed) {}

  // Judges, and remembers session and sequence of what it accepts. No allocation, no lock, no throw.
  Verdict judge(const IncomingProxy& in, std::int64_t now_ns);
  // Data has gone stale: the session before the present one may come back (two servers took turns and this one ended).
  void forget_previous_session() { previous_session_ = 0; }

  const std::array<std::uint64_t, kVerdicts>& counts() const { return counts_; }
  std::uint64_t passed_over() const { return passed_over_; }  // gaps in the sequence: lost, or overtaken by a newer one

 private:
  Verdict check_content(const ProxySample& s, std::int64_t now_ns) const;

  std::uint32_t device_;
  std::uint64_t own_session_;
  CouplingGains proposed_;
  std::uint64_t session_ = 0;  // 0: none yet
  std::uint64_t previous_session_ = 0;
  std::uint64_t sequence_ = 0;
  double sim_time_ = 0;           // of what was accepted last [s]
  std::int64_t t_device_ns_ = 0;  // likewise
  std::uint64_t passed_over_ = 0;
  std::array<std::uint64_t, kVerdicts> counts_{};
};

}  // namespace palp
