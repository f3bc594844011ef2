// Which servers speak, and whether two do at one time, from the serialised statuses of a recording. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "idl/mcap/mcap_format.h"

namespace palp {

// The rest of a sentence that tells of several servers in a recording.
inline constexpr const char* kServersTogether =
    "what is recorded of the simulation is of all of them, told apart by the session of each sample";

class ServersHeard {
 public:
  // Takes a payload of palp/status: 4 bytes of encapsulation header, then CDR. Those of other processes, and what is
  // too short, change nothing. Times rise from call to call.
  void add(ByteView status, std::uint64_t time_ns);
  // Returns how many servers have spoken while another one did; 0 where each began after the one before had ended.
  std::size_t together() const;

 private:
  struct Span {
    std::uint64_t first_ns, last_ns;
  };
  std::map<std::uint64_t, Span> spans_;  // by session
};

}  // namespace palp
