#include "tools/recording/raw_bus.h"

namespace palp {

std::unique_ptr<RawBus> open_raw_bus(const BusOptions& options) {
  return options.vendor == Vendor::cyclone ? open_raw_cyclone(options) : open_raw_fastdds(options);
}

bool raw_key(Payload payload, std::size_t bytes, std::array<std::uint8_t, 16>& key) {
  key.fill(0);
  // 0 0: big-endian, 0 1: little-endian; anything else is no plain CDR
  if (bytes > key.size() || payload.size() < 4 + bytes || payload[0] != 0 || payload[1] > 1) return false;
  const bool little = payload[1] == 1;
  for (std::size_t i = 0; i < bytes; ++i) key[i] = payload[4 + (little ? bytes - 1 - i : i)];
  return true;
}

}  // namespace palp
