#include "idl/mcap/mcap_writer.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <utility>

#include "idl/mcap/mcap_records.h"

namespace palp {
namespace {

std::string error_text() { return std::strerror(errno); }

void put_record(Bytes& out, Op op, ByteView content) {
  put(out, op);
  put(out, static_cast<std::uint64_t>(content.size()));
  put_bytes(out, content);
}

// An existing recording is never lost by starting another one under its name.
void refuse_existing(const std::string& path, const std::string& unfinished) {
  if (access(path.c_str(), F_OK) == 0)
    throw McapError(path + ": the file exists already; give another name, or --overwrite to replace it");
  if (access(unfinished.c_str(), F_OK) == 0)
    throw McapError(unfinished + ": left by a recorder that was killed; save it with palp-record --recover " +
                    unfinished + ", or give --overwrite to replace it");
}

}  // namespace

McapWriter::McapWriter(std::string path, McapWriterOptions options)
    : path_(std::move(path)), unfinished_path_(path_ + options.unfinished_suffix), options_(std::move(options)) {
  if (!options_.overwrite) refuse_existing(path_, unfinished_path_);
  file_ = open(unfinished_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file_ < 0) throw McapError(unfinished_path_ + ": cannot be created: " + error_text());
  try {
    append(kMcapMagic);
    Bytes header;
    put_string(header, "");  // no profile
    put_string(header, options_.library);
    append_record(Op::header, header);
  } catch (...) {
    ::close(file_);
    if (!options_.keep_unfinished) unlink(unfinished_path_.c_str());
    throw;
  }
}

McapWriter::~McapWriter() {
  if (file_ < 0) return;
  try {
    if (failure_.empty() && options_.keep_unfinished) flush();
  } catch (const std::exception&) {
    // what was written before is whole, and there is nobody left to tell
  }
  ::close(file_);
  const bool empty = failure_.empty() && statistics_.messages == 0;
  if (empty || !options_.keep_unfinished) unlink(unfinished_path_.c_str());
}

void McapWriter::fail(const std::string& what) {
  // cut the half-written record off, so that the file ends with a whole one
  const bool cut = ftruncate(file_, static_cast<off_t>(offset_)) == 0;
  failure_ = unfinished_path_ + ": at byte " + std::to_string(offset_) + ": " + what;
  if (options_.keep_unfinished) {
    failure_ += std::string("; what was recorded before is kept") + (cut ? "" : " up to a broken last record") +
                ", recover it with palp-record --recover " + unfinished_path_;
  }
  throw McapError(failure_);
}

void McapWriter::append(ByteView bytes) {
  if (!failure_.empty()) throw McapError(failure_);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::write(file_, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail("cannot write: " + error_text());
    done += static_cast<std::size_t>(n);
  }
  offset_ += bytes.size();
  data_crc_ = crc32_of(data_crc_, bytes);
}

void McapWriter::append_record(Op op, ByteView content) {
  Bytes record;
  record.reserve(kRecordHead + content.size());
  put_record(record, op, content);
  append(record);
}

std::uint16_t McapWriter::add_schema(const std::string& name, const std::string& encoding, const std::string& data) {
  if (schemas_.size() >= 65535) throw McapError(path_ + ": more than 65535 schemas");
  const McapSchema schema{static_cast<std::uint16_t>(schemas_.size() + 1), name, encoding, data};
  append_record(Op::schema, encode(schema));
  schemas_.push_back(schema);
  ++statistics_.schemas;
  return schema.id;
}

std::uint16_t McapWriter::add_channel(const std::string& topic, std::uint16_t schema_id, const std::string& encoding,
                                      const std::map<std::string, std::string>& metadata, Compression compression) {
  if (channels_.size() >= 65535) throw McapError(path_ + ": more than 65535 channels");
  if (schema_id > schemas_.size()) throw std::invalid_argument("unknown MCAP schema " + std::to_string(schema_id));
  const McapChannel channel{static_cast<std::uint16_t>(channels_.size() + 1), schema_id, topic, encoding, metadata};
  append_record(Op::channel, encode(channel));
  channels_.push_back(channel);
  channel_compression_.push_back(compression);
  ++statistics_.channels;
  return channel.id;
}

void McapWriter::add_metadata(const McapMetadata& metadata) {
  const std::uint64_t at = offset_;
  append_record(Op::metadata, encode(metadata));
  metadata_.push_back({at, offset_ - at, metadata.name});
  ++statistics_.metadata;
}

void McapWriter::write(const McapMessage& m) {
  if (!failure_.empty()) throw McapError(failure_);
  if (m.channel_id == 0 || m.channel_id > channels_.size())
    throw std::invalid_argument("unknown MCAP channel " + std::to_string(m.channel_id));
  if (m.data.size() > kMaxMessageBytes)
    throw std::invalid_argument("a message of " + std::to_string(m.data.size()) +
                                " bytes is too large for a recording, which has room for " +
                                std::to_string(kMaxMessageBytes));
  const Compression compression = channel_compression_[m.channel_id - 1u];
  OpenChunk& chunk = open_[compression];
  if (chunk.records.empty()) {
    chunk.start_time_ns = m.log_time_ns;
    chunk.end_time_ns = m.log_time_ns;
  }
  chunk.start_time_ns = std::min(chunk.start_time_ns, m.log_time_ns);
  chunk.end_time_ns = std::max(chunk.end_time_ns, m.log_time_ns);
  chunk.index[m.channel_id].emplace_back(m.log_time_ns, chunk.records.size());
  put(chunk.records, Op::message);
  put(chunk.records, static_cast<std::uint64_t>(22 + m.data.size()));
  put(chunk.records, m.channel_id);
  put(chunk.records, m.sequence);
  put(chunk.records, m.log_time_ns);
  put(chunk.records, m.publish_time_ns);
  put_bytes(chunk.records, m.data);
  if (chunk.records.size() >= options_.chunk_bytes) close_chunk(compression);
}

void McapWriter::flush() {
  for (auto& [compression, chunk] : open_) close_chunk(compression);
}

// One append for the chunk with its indexes: a full disk cuts all of it off or nothing.
void McapWriter::close_chunk(Compression compression) {
  OpenChunk& chunk = open_[compression];
  if (chunk.records.empty()) return;
  const Bytes packed = compress(chunk.records, compression);
  McapChunkIndex index;
  index.start_time_ns = chunk.start_time_ns;
  index.end_time_ns = chunk.end_time_ns;
  index.offset = offset_;
  index.compression = mcap_name(compression);
  index.packed_size = packed.size();
  index.size = chunk.records.size();

  Bytes out;
  out.reserve(packed.size() + 256 + 20 * chunk.index.size());
  put(out, Op::chunk);
  put(out, static_cast<std::uint64_t>(8 + 8 + 8 + 4 + 4 + index.compression.size() + 8 + packed.size()));
  put(out, index.start_time_ns);
  put(out, index.end_time_ns);
  put(out, index.size);
  put(out, crc32_of(0, chunk.records));
  put_string(out, index.compression);
  put(out, index.packed_size);
  put_bytes(out, packed);
  index.length = out.size();
  for (const auto& [channel, entries] : chunk.index) {
    index.message_index[channel] = offset_ + out.size();
    put(out, Op::message_index);
    put(out, static_cast<std::uint64_t>(2 + 4 + 16 * entries.size()));
    put(out, channel);
    put(out, static_cast<std::uint32_t>(16 * entries.size()));
    for (const auto& [time, offset] : entries) {
      put(out, time);
      put(out, offset);
    }
  }
  index.message_index_length = out.size() - index.length;
  append(out);

  McapStatistics& s = statistics_;
  s.start_time_ns = s.messages == 0 ? index.start_time_ns : std::min(s.start_time_ns, index.start_time_ns);
  s.end_time_ns = std::max(s.end_time_ns, index.end_time_ns);
  for (const auto& [channel, entries] : chunk.index) {
    s.messages += entries.size();
    s.channel_messages[channel] += entries.size();
  }
  ++s.chunks;
  chunks_.push_back(std::move(index));
  chunk.records.clear();
  chunk.index.clear();
}

// The summary section, its offsets and the footer, which begin at byte `start` of the file.
Bytes McapWriter::summary(std::uint64_t start) const {
  Bytes out;
  Bytes offsets;
  const auto group = [&](Op op, auto&& fill) {
    const std::size_t at = out.size();
    fill();
    if (out.size() == at) return;
    Bytes content;
    put(content, op);
    put(content, start + at);
    put(content, static_cast<std::uint64_t>(out.size() - at));
    put_record(offsets, Op::summary_offset, content);
  };
  group(Op::schema, [&] {
    for (const McapSchema& schema : schemas_) put_record(out, Op::schema, encode(schema));
  });
  group(Op::channel, [&] {
    for (const McapChannel& channel : channels_) put_record(out, Op::channel, encode(channel));
  });
  group(Op::statistics, [&] { put_record(out, Op::statistics, encode(statistics_)); });
  group(Op::chunk_index, [&] {
    for (const McapChunkIndex& chunk : chunks_) put_record(out, Op::chunk_index, encode(chunk));
  });
  group(Op::metadata_index, [&] {
    for (const MetadataIndex& m : metadata_) {
      Bytes content;
      put(content, m.offset);
      put(content, m.length);
      put_string(content, m.name);
      put_record(out, Op::metadata_index, content);
    }
  });
  const std::uint64_t offset_start = start + out.size();
  put_bytes(out, offsets);
  put(out, Op::footer);
  put(out, std::uint64_t{20});
  put(out, start);
  put(out, offset_start);
  put(out, crc32_of(0, out));
  put_bytes(out, kMcapMagic);
  return out;
}

void McapWriter::close() {
  flush();
  Bytes end;
  put(end, data_crc_);
  append_record(Op::data_end, end);
  append(summary(offset_));
  if (fdatasync(file_) != 0 && errno != EINVAL && errno != EROFS) fail("cannot write: " + error_text());
  if (std::rename(unfinished_path_.c_str(), path_.c_str()) != 0)
    fail("cannot be renamed to " + path_ + ": " + error_text());
  ::close(file_);
  file_ = -1;
}

}  // namespace palp
