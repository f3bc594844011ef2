// How long a sample of the proxy takes over the bus, from one process to another on this host.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace palp::bench {

struct BusTime {
  std::string vendor;
  std::size_t sent = 0, received = 0;
  double median_us = 0, p99_us = 0, p999_us = 0, max_us = 0;  // from publish to having been taken
};

// At 1 kHz for so many seconds over loopback, Cyclone DDS and then Fast DDS, in this domain; both ends with the
// bridge's scheduling where that is allowed. Forks: to be called before a thread is started. Throws std::runtime_error
// when a process cannot be started or nothing arrives.
std::vector<BusTime> bus_times(int domain, double seconds);

// As a table.
std::string markdown(const std::vector<BusTime>& times);

}  // namespace palp::bench
