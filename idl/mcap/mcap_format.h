// Shared by the writer and the reader of MCAP files: record numbers, the plain structs of the records, and the byte
// order. The format: https://mcap.dev/spec. Times are ns since 1970 (CLOCK_REALTIME).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace palp {

static_assert(std::endian::native == std::endian::little, "MCAP is little-endian and is copied as it stands");

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

inline constexpr std::array<std::uint8_t, 8> kMcapMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
// The library that the header of palp's own files names; in those every message stands in a chunk.
inline constexpr const char* kMcapLibrary = "palp";
inline constexpr std::size_t kRecordHead = 9;                  // opcode and length
inline constexpr std::size_t kFooterBytes = kRecordHead + 20;  // the whole footer record
inline constexpr std::uint64_t kMaxChunkBytes = 256ull << 20;  // larger chunks are refused, packed or not
inline constexpr std::uint64_t kMaxMessageBytes = kMaxChunkBytes / 2;
inline constexpr std::uint64_t kMaxRecordBytes = kMaxChunkBytes + (1ull << 20);

enum class Op : std::uint8_t {
  header = 1,
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  message_index = 7,
  chunk_index = 8,
  attachment = 9,
  attachment_index = 10,
  statistics = 11,
  metadata = 12,
  metadata_index = 13,
  summary_offset = 14,
  data_end = 15,
};

// One sentence: the file, the byte offset where there is one, what is wrong, what to do.
class McapError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct McapSchema {
  std::uint16_t id = 0;
  std::string name;
  std::string encoding;
  std::string data;
  bool operator==(const McapSchema&) const = default;
};

struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;
  std::string topic;
  std::string encoding;
  std::map<std::string, std::string> metadata;
  bool operator==(const McapChannel&) const = default;
};

struct McapMessage {
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0;
  std::uint64_t publish_time_ns = 0;
  ByteView data;  // valid while the call that hands it over lasts
};

struct McapMetadata {
  std::string name;
  std::map<std::string, std::string> values;
};

struct McapChunkIndex {
  std::uint64_t start_time_ns = 0;
  std::uint64_t end_time_ns = 0;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::map<std::uint16_t, std::uint64_t> message_index;  // by channel: where its message index record stands
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t packed_size = 0;
  std::uint64_t size = 0;
};

struct McapStatistics {
  std::uint64_t messages = 0;
  std::uint16_t schemas = 0;
  std::uint32_t channels = 0;
  std::uint32_t attachments = 0;
  std::uint32_t metadata = 0;
  std::uint32_t chunks = 0;
  std::uint64_t start_time_ns = 0;
  std::uint64_t end_time_ns = 0;
  std::map<std::uint16_t, std::uint64_t> channel_messages;
};

// Appends to a byte vector.
template <class T>
void put(Bytes& out, T value) {
  const std::size_t at = out.size();
  out.resize(at + sizeof value);
  std::memcpy(out.data() + at, &value, sizeof value);
}
inline void put_bytes(Bytes& out, ByteView bytes) {
  if (bytes.empty()) return;
  const std::size_t at = out.size();
  out.resize(at + bytes.size());
  std::memcpy(out.data() + at, bytes.data(), bytes.size());
}
inline void put_string(Bytes& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  put_bytes(out, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}
// Overwrites bytes that were put before.
template <class T>
void patch(Bytes& out, std::size_t at, T value) {
  std::memcpy(out.data() + at, &value, sizeof value);
}

}  // namespace palp
