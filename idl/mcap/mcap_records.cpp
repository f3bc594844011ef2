#include "idl/mcap/mcap_records.h"

#include <zlib.h>

namespace palp {
namespace {

void put_map(Bytes& out, const std::map<std::string, std::string>& values) {
  const std::size_t at = out.size();
  put(out, std::uint32_t{0});
  for (const auto& [key, value] : values) {
    put_string(out, key);
    put_string(out, value);
  }
  patch(out, at, static_cast<std::uint32_t>(out.size() - at - 4));
}

void put_map(Bytes& out, const std::map<std::uint16_t, std::uint64_t>& values) {
  put(out, static_cast<std::uint32_t>(values.size() * 10));
  for (const auto& [key, value] : values) {
    put(out, key);
    put(out, value);
  }
}

}  // namespace

std::uint32_t crc32_of(std::uint32_t before, ByteView bytes) {
  return static_cast<std::uint32_t>(crc32_z(before, bytes.data(), bytes.size()));
}

Bytes encode(const McapSchema& schema) {
  Bytes out;
  put(out, schema.id);
  put_string(out, schema.name);
  put_string(out, schema.encoding);
  put_string(out, schema.data);
  return out;
}

Bytes encode(const McapChannel& channel) {
  Bytes out;
  put(out, channel.id);
  put(out, channel.schema_id);
  put_string(out, channel.topic);
  put_string(out, channel.encoding);
  put_map(out, channel.metadata);
  return out;
}

Bytes encode(const McapChunkIndex& chunk) {
  Bytes out;
  put(out, chunk.start_time_ns);
  put(out, chunk.end_time_ns);
  put(out, chunk.offset);
  put(out, chunk.length);
  put_map(out, chunk.message_index);
  put(out, chunk.message_index_length);
  put_string(out, chunk.compression);
  put(out, chunk.packed_size);
  put(out, chunk.size);
  return out;
}

Bytes encode(const McapStatistics& s) {
  Bytes out;
  put(out, s.messages);
  put(out, s.schemas);
  put(out, s.channels);
  put(out, s.attachments);
  put(out, s.metadata);
  put(out, s.chunks);
  put(out, s.start_time_ns);
  put(out, s.end_time_ns);
  put_map(out, s.channel_messages);
  return out;
}

Bytes encode(const McapMetadata& metadata) {
  Bytes out;
  put_string(out, metadata.name);
  put_map(out, metadata.values);
  return out;
}

McapSchema decode_schema(ByteCursor in) {
  McapSchema schema;
  schema.id = in.get<std::uint16_t>();
  schema.name = in.string();
  schema.encoding = in.string();
  schema.data = in.string();
  return schema;
}

McapChannel decode_channel(ByteCursor in) {
  McapChannel channel;
  channel.id = in.get<std::uint16_t>();
  channel.schema_id = in.get<std::uint16_t>();
  channel.topic = in.string();
  channel.encoding = in.string();
  channel.metadata = in.string_map();
  return channel;
}

McapMessage decode_message(ByteCursor in) {
  McapMessage message;
  message.channel_id = in.get<std::uint16_t>();
  message.sequence = in.get<std::uint32_t>();
  message.log_time_ns = in.get<std::uint64_t>();
  message.publish_time_ns = in.get<std::uint64_t>();
  message.data = in.take(in.left());
  return message;
}

McapMetadata decode_metadata(ByteCursor in) {
  McapMetadata metadata;
  metadata.name = in.string();
  metadata.values = in.string_map();
  return metadata;
}

McapChunkIndex decode_chunk_index(ByteCursor in) {
  McapChunkIndex chunk;
  chunk.start_time_ns = in.get<std::uint64_t>();
  chunk.end_time_ns = in.get<std::uint64_t>();
  chunk.offset = in.get<std::uint64_t>();
  chunk.length = in.get<std::uint64_t>();
  chunk.message_index = in.number_map();
  chunk.message_index_length = in.get<std::uint64_t>();
  chunk.compression = in.string();
  chunk.packed_size = in.get<std::uint64_t>();
  chunk.size = in.get<std::uint64_t>();
  return chunk;
}

McapStatistics decode_statistics(ByteCursor in) {
  McapStatistics s;
  s.messages = in.get<std::uint64_t>();
  s.schemas = in.get<std::uint16_t>();
  s.channels = in.get<std::uint32_t>();
  s.attachments = in.get<std::uint32_t>();
  s.metadata = in.get<std::uint32_t>();
  s.chunks = in.get<std::uint32_t>();
  s.start_time_ns = in.get<std::uint64_t>();
  s.end_time_ns = in.get<std::uint64_t>();
  s.channel_messages = in.number_map();
  return s;
}

}  // namespace palp
