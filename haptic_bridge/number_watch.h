// Finds out from the server's answers that another live bridge holds the device number of this one. Pure.
#pragma once

#include <cstdint>

#include "idl/messages.h"

namespace palp {

// A bridge that takes the place of a killed one is answered long before this, for a server lets go of a bridge that is
// silent (kDeviceHold in idl/session_hold.h).
inline constexpr std::int64_t kHeldByOtherAfterNs = 1'000'000'000;

// One thread.
class NumberWatch {
 public:
  explicit NumberWatch(std::uint64_t own_session) : own_session_(own_session) {}

  // Takes in an answer of the server that is held. Answers to samples that get no newer are those to a dead bridge.
  void see(const ProxySample& answer, std::int64_t t_receive_ns) {
    if (answer.device_session == own_session_ || answer.device_session == 0) {
      *this = NumberWatch(own_session_);
    } else if (answer.device_session != other_) {
      other_ = answer.device_session;
      sequence_ = answer.device_sequence;
      t_first_ns_ = t_receive_ns;
      alive_for_ns_ = 0;
    } else if (answer.device_sequence > sequence_) {
      sequence_ = answer.device_sequence;
      alive_for_ns_ = t_receive_ns - t_first_ns_;
    }
  }

  // Returns the session of the bridge that holds the number, or 0.
  std::uint64_t holder() const { return alive_for_ns_ >= kHeldByOtherAfterNs ? other_ : 0; }

 private:
  std::uint64_t own_session_;
  std::uint64_t other_ = 0;  // whom the server answers instead; 0: nobody
  std::uint64_t sequence_ = 0;
  std::int64_t t_first_ns_ = 0;
  std::int64_t alive_for_ns_ = 0;
};

}  // namespace palp
