#include "tools/recording/raw_bus.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

namespace palp {

std::unique_ptr<RawBus> open_raw_bus(const BusOptions& options) {
  return options.vendor == Vendor::cyclone ? open_raw_cyclone(options) : open_raw_fastdds(options);
}

std::size_t key_bytes(const TopicRow& topic) {
  if (!topic.keyed) return 0;
  const std::string_view name = topic.name;
  if (name == topic_of<DeviceSample>().name || name == topic_of<ProxySample>().name) return 4;
  if (name == topic_of<Status>().name) return 8;
  throw std::logic_error(std::string("the size of the key of ") + topic.name + " is not known here");
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
