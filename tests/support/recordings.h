// Random recordings, and what any recording holds.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "idl/mcap/mcap_reader.h"
#include "idl/mcap/mcap_writer.h"

namespace palp::test {

struct OwnedMessage {
  std::string topic;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0;
  std::uint64_t publish_time_ns = 0;
  Bytes data;
  bool operator==(const OwnedMessage&) const = default;
};

inline OwnedMessage owned(const McapMessage& m, const std::string& topic) {
  return {topic, m.sequence, m.log_time_ns, m.publish_time_ns, Bytes(m.data.begin(), m.data.end())};
}

// One channel per compression and one that stays empty.
inline const std::vector<std::pair<std::string, Compression>>& test_channels() {
  static const std::vector<std::pair<std::string, Compression>> channels{{"palp/zstd", Compression::zstd},
                                                                         {"palp/none", Compression::none},
                                                                         {"palp/lz4", Compression::lz4},
                                                                         {"palp/zstd_too", Compression::zstd},
                                                                         {"palp/empty", Compression::lz4}};
  return channels;
}

// Adds the channels and `count` messages with growing times (some equal). Does not close.
inline std::vector<OwnedMessage> fill(McapWriter& writer, std::size_t count, std::mt19937& random) {
  const std::uint16_t schema = writer.add_schema("palp::Thing", "omgidl", "module palp { struct Thing { long x; }; };");
  std::vector<std::uint16_t> ids;
  for (const auto& [topic, compression] : test_channels())
    ids.push_back(writer.add_channel(topic, schema, "cdr", {{"qos", "reliability: 1"}}, compression));
  std::vector<OwnedMessage> out;
  std::uint64_t time = 1'700'000'000'000'000'000;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t channel = random() % 4;
    time += random() % 3 * 1000;
    Bytes data(random() % 300);
    std::generate(data.begin(), data.end(), [&] { return static_cast<std::uint8_t>(random() % 7); });
    writer.write({ids[channel], static_cast<std::uint32_t>(i + 1), time, time - 5, data});
    out.push_back({test_channels()[channel].first, static_cast<std::uint32_t>(i + 1), time, time - 5, data});
  }
  return out;
}

inline McapWriterOptions small_chunks() {
  McapWriterOptions options;
  options.chunk_bytes = 2000;
  return options;
}

// Writes and closes a file with `count` messages.
inline std::vector<OwnedMessage> make_file(const std::string& path, std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  McapWriter writer(path, small_chunks());
  std::vector<OwnedMessage> messages = fill(writer, count, random);
  writer.add_metadata({"palp_recording", {{"drops", "0"}}});
  writer.close();
  return messages;
}

inline std::vector<OwnedMessage> read_all(const McapReader& reader) {
  std::vector<OwnedMessage> out;
  reader.read([&](const McapMessage& m) {
    out.push_back(owned(m, reader.channels().at(m.channel_id).topic));
    return true;
  });
  return out;
}

// Messages in the order of the file.
inline std::vector<OwnedMessage> scan_all(const McapReader& reader, McapScan& result) {
  std::vector<OwnedMessage> out;
  std::map<std::uint16_t, std::string> topics;
  McapVisitor visitor;
  visitor.channel = [&](const McapChannel& channel) { topics[channel.id] = channel.topic; };
  visitor.message = [&](const McapMessage& m, Compression) { out.push_back(owned(m, topics.at(m.channel_id))); };
  result = reader.scan(visitor);
  return out;
}

// Returns the payloads of each topic, in their order.
inline std::map<std::string, std::vector<Bytes>> payloads_by_topic(const std::string& path) {
  const McapReader reader(path);
  std::map<std::string, std::vector<Bytes>> out;
  for (OwnedMessage& m : read_all(reader)) out[m.topic].push_back(std::move(m.data));
  return out;
}

inline Bytes file_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

inline void write_file(const std::string& path, ByteView bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// Times in one file are unique per sequence number, so this is the order in which they were written.
inline void sort_by_sequence(std::vector<OwnedMessage>& messages) {
  std::sort(messages.begin(), messages.end(), [](const auto& a, const auto& b) { return a.sequence < b.sequence; });
}

}  // namespace palp::test
