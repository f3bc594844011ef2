#include "idl/mcap/mcap_reader.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <queue>
#include <tuple>
#include <utility>

#include "idl/mcap/mcap_records.h"

namespace palp {
namespace {

constexpr std::size_t kMostDamages = 1000;
constexpr std::uint64_t kMaxLoadedBytes = 2ull << 30;  // of chunks whose times overlap

// Adds one of schemas or channels; the same id twice must mean the same thing.
template <class T>
void add_once(std::map<std::uint16_t, T>& all, T value, const ByteCursor& in) {
  const auto [it, added] = all.try_emplace(value.id, value);
  if (!added && !(it->second == value)) in.fail("the id " + std::to_string(value.id) + " is given twice, differently");
}

}  // namespace

struct McapReader::Chunk {
  Bytes records;
  Compression compression = Compression::none;
  std::uint64_t offset = 0;  // in the file
  std::uint64_t start_time_ns = 0;
  std::uint64_t end_time_ns = 0;
};

struct McapReader::Loaded {
  Chunk chunk;
  std::vector<McapMessage> messages;
  std::size_t next = 0;

  std::uint64_t bytes() const { return chunk.records.size() + messages.capacity() * sizeof(McapMessage); }
};

McapReader::McapReader(std::string path, McapReaderOptions options) : path_(std::move(path)), options_(options) {
  file_ = open(path_.c_str(), O_RDONLY | O_CLOEXEC);
  if (file_ < 0) throw McapError(path_ + ": cannot be opened: " + std::strerror(errno));
  try {
    struct stat info {};
    if (fstat(file_, &info) != 0 || !S_ISREG(info.st_mode)) throw McapError(path_ + ": is not a regular file");
    size_ = static_cast<std::uint64_t>(info.st_size);
    if (size_ < kMcapMagic.size()) fail(0, "too short for an MCAP file");
    const Bytes magic = bytes_at(0, kMcapMagic.size());
    if (!std::equal(magic.begin(), magic.end(), kMcapMagic.begin())) fail(0, "is not an MCAP file (other first bytes)");
    const RecordHead head = head_at(kMcapMagic.size());
    if (head.op != Op::header) fail(kMcapMagic.size(), "an MCAP header was expected");
    const Bytes content = bytes_at(kMcapMagic.size() + kRecordHead, head.length);
    ByteCursor in(content, path_, kMcapMagic.size() + kRecordHead);
    in.string();  // the profile says nothing that we need
    library_ = in.string();
    data_start_ = kMcapMagic.size() + kRecordHead + head.length;
    try {
      read_summary();
    } catch (const McapError& error) {
      index_fault_ = error.what() + ("; palp-record --recover " + path_ + " rebuilds the index");
      schemas_.clear();
      channels_.clear();
      chunks_.clear();
      metadata_at_.clear();
      statistics_.reset();
    }
  } catch (...) {
    close(file_);
    throw;
  }
}

McapReader::~McapReader() { close(file_); }

void McapReader::fail(std::uint64_t offset, const std::string& what) const {
  throw McapError(path_ + ": at byte " + std::to_string(offset) + ": " + what);
}

Bytes McapReader::bytes_at(std::uint64_t offset, std::uint64_t length) const {
  if (offset > size_ || length > size_ - offset)
    fail(offset, "needs " + std::to_string(length) + " bytes, but the file has " + std::to_string(size_) + " in all");
  if (length > kMaxRecordBytes) fail(offset, "a record of " + std::to_string(length) + " bytes is too large");
  Bytes out(static_cast<std::size_t>(length));
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t n = pread(file_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(offset + done, std::string("cannot be read: ") + std::strerror(errno));
    if (n == 0) fail(offset + done, "the file ends here, it became shorter while it was read");
    done += static_cast<std::size_t>(n);
  }
  return out;
}

McapReader::RecordHead McapReader::head_at(std::uint64_t offset) const {
  const Bytes bytes = bytes_at(offset, kRecordHead);
  ByteCursor in(bytes, path_, offset);
  const auto op = in.get<Op>();
  const auto length = in.get<std::uint64_t>();
  if (op == Op{0}) fail(offset, "0 is no kind of record");
  if (length > size_ - offset - kRecordHead)
    fail(offset, "a record claims " + std::to_string(length) + " bytes where " +
                     std::to_string(size_ - offset - kRecordHead) + " are left");
  return {op, length};
}

void McapReader::read_summary() {
  const std::uint64_t tail = kFooterBytes + kMcapMagic.size();
  const std::string hint = ": the recorder was killed or the file was cut";
  if (size_ < data_start_ + tail) fail(size_, "the file ends without a summary" + hint);
  const Bytes end = bytes_at(size_ - tail, tail);
  if (!std::equal(kMcapMagic.begin(), kMcapMagic.end(), end.end() - kMcapMagic.size()))
    fail(size_ - kMcapMagic.size(), "the file ends without a summary" + hint);
  ByteCursor footer(end, path_, size_ - tail);
  if (footer.get<Op>() != Op::footer || footer.get<std::uint64_t>() != 20) footer.fail("a footer was expected" + hint);
  const auto start = footer.get<std::uint64_t>();
  footer.get<std::uint64_t>();  // where the offsets are: all of the summary is read anyway
  const auto expected_crc = footer.get<std::uint32_t>();
  if (start == 0) footer.fail("the file has no summary");
  if (start < data_start_ || start > size_ - tail) footer.fail("the summary is said to begin outside of the file");

  const Bytes bytes = bytes_at(start, size_ - kMcapMagic.size() - 4 - start);  // up to the checksum itself
  if (options_.check_crc && expected_crc != 0 && crc32_of(0, bytes) != expected_crc)
    fail(start, "the summary's checksum is wrong");
  ByteCursor in(bytes, path_, start);
  while (in.offset() < size_ - tail) {
    const auto op = in.get<Op>();
    const auto length = in.get<std::uint64_t>();
    const std::uint64_t begin = in.offset();
    const ByteCursor record(in.take(length), path_, begin);
    if (op == Op::schema) add_once(schemas_, decode_schema(record), record);
    if (op == Op::channel) add_once(channels_, decode_channel(record), record);
    if (op == Op::chunk_index) chunks_.push_back(decode_chunk_index(record));
    if (op == Op::statistics) statistics_ = decode_statistics(record);
    if (op == Op::metadata_index) {
      ByteCursor index = record;
      const auto offset = index.get<std::uint64_t>();
      metadata_at_.emplace_back(offset, index.get<std::uint64_t>());
    }
  }
  std::set<std::uint64_t> offsets;
  for (const McapChunkIndex& chunk : chunks_) {
    check_chunk_index(chunk);
    if (!offsets.insert(chunk.offset).second) fail(chunk.offset, "the index names a chunk twice");
  }
  std::uint64_t counted = 0;
  if (statistics_) counted = statistics_->messages;
  if (chunks_.empty() && counted > 0) fail(start, "the messages are not indexed");
}

void McapReader::check_chunk_index(const McapChunkIndex& chunk) const {
  if (chunk.offset < data_start_ || chunk.offset > size_ || chunk.length > size_ - chunk.offset ||
      chunk.length < kRecordHead)
    fail(chunk.offset, "the index names a chunk outside of the file");
  if (chunk.start_time_ns > chunk.end_time_ns) fail(chunk.offset, "the index gives a chunk that ends before it begins");
  for (const auto& [channel, offset] : chunk.message_index)
    if (!channels_.contains(channel))
      fail(chunk.offset, "the index names the unknown channel " + std::to_string(channel));
}

std::vector<McapMetadata> McapReader::metadata() const {
  std::vector<McapMetadata> out;
  for (const auto& [offset, length] : metadata_at_) {
    const RecordHead head = head_at(offset);
    if (head.op != Op::metadata || length != head.length + kRecordHead) fail(offset, "metadata was expected");
    const Bytes content = bytes_at(offset + kRecordHead, head.length);
    out.push_back(decode_metadata(ByteCursor(content, path_, offset + kRecordHead)));
  }
  return out;
}

// content: what follows the head of the chunk record that begins at `offset` of the file.
McapReader::Chunk McapReader::unpack_chunk(ByteView content, std::uint64_t offset) const {
  ByteCursor in(content, path_, offset + kRecordHead);
  Chunk chunk;
  chunk.offset = offset;
  chunk.start_time_ns = in.get<std::uint64_t>();
  chunk.end_time_ns = in.get<std::uint64_t>();
  const auto size = in.get<std::uint64_t>();
  const auto expected_crc = in.get<std::uint32_t>();
  const std::string compression = in.string();
  const ByteView packed = in.take(in.get<std::uint64_t>());
  try {
    chunk.compression = compression_from_mcap(compression);
    if (size > kMaxChunkBytes) throw std::runtime_error("a chunk of " + std::to_string(size) + " bytes is too large");
    chunk.records = decompress(packed, chunk.compression, static_cast<std::size_t>(size));
  } catch (const std::exception& error) {
    fail(offset, error.what());
  }
  if (options_.check_crc && expected_crc != 0 && crc32_of(0, chunk.records) != expected_crc)
    fail(offset, "the checksum of the chunk is wrong");
  return chunk;
}

McapReader::Chunk McapReader::load(const McapChunkIndex& index) const {
  const RecordHead head = head_at(index.offset);
  if (head.op != Op::chunk || head.length + kRecordHead != index.length) fail(index.offset, "a chunk was expected");
  Chunk chunk = unpack_chunk(bytes_at(index.offset + kRecordHead, head.length), index.offset);
  if (chunk.start_time_ns != index.start_time_ns || chunk.end_time_ns != index.end_time_ns)
    fail(index.offset, "the chunk and the index give different times");
  return chunk;
}

// Returns the chosen messages of a chunk by time; they point into the chunk.
McapReader::Loaded McapReader::load_messages(const McapChunkIndex& index, const std::set<std::uint16_t>& chosen) const {
  Loaded out;
  out.chunk = load(index);
  ByteCursor in(out.chunk.records, path_ + ": in the chunk at byte " + std::to_string(index.offset), 0);
  while (in.left() > 0) {
    const auto op = in.get<Op>();
    const auto length = in.get<std::uint64_t>();
    const ByteCursor record(in.take(length), path_, index.offset);
    if (op != Op::message) continue;
    const McapMessage message = decode_message(record);
    if (!channels_.contains(message.channel_id)) in.fail("a message of an unknown channel");
    if (message.log_time_ns < index.start_time_ns || message.log_time_ns > index.end_time_ns)
      in.fail("a message outside of the chunk's times");
    if (chosen.empty() || chosen.contains(message.channel_id)) out.messages.push_back(message);
  }
  std::stable_sort(out.messages.begin(), out.messages.end(),
                   [](const McapMessage& a, const McapMessage& b) { return a.log_time_ns < b.log_time_ns; });
  return out;
}

// Returns the chunks that may hold messages of the chosen channels, by the time of their first message.
std::vector<const McapChunkIndex*> McapReader::chunks_by_time(const std::set<std::uint16_t>& chosen) const {
  std::vector<const McapChunkIndex*> to_load;
  for (const McapChunkIndex& chunk : chunks_) {
    const auto& channels = chunk.message_index;
    const bool any =
        chosen.empty() || channels.empty() ||
        std::any_of(channels.begin(), channels.end(), [&](const auto& c) { return chosen.contains(c.first); });
    if (any) to_load.push_back(&chunk);
  }
  std::stable_sort(to_load.begin(), to_load.end(), [](const McapChunkIndex* a, const McapChunkIndex* b) {
    return std::tie(a->start_time_ns, a->offset) < std::tie(b->start_time_ns, b->offset);
  });
  return to_load;
}

void McapReader::read(const std::function<bool(const McapMessage&)>& on_message, const std::set<std::uint16_t>& chosen,
                      const std::function<void(const std::string&)>& on_damage) const {
  if (!indexed()) throw McapError(index_fault_);
  const std::vector<const McapChunkIndex*> to_load = chunks_by_time(chosen);
  const auto load_or_report = [&](const McapChunkIndex& index) {
    try {
      return load_messages(index, chosen);
    } catch (const McapError& error) {
      if (!on_damage) throw;
      on_damage(error.what());
      return Loaded{};
    }
  };
  // chunks overlap in time, so several are loaded at once and a heap holds the next message of each
  using Next = std::tuple<std::uint64_t, std::uint64_t, std::size_t>;  // time, offset in the file, slot in `loaded`
  std::priority_queue<Next, std::vector<Next>, std::greater<>> heap;
  std::map<std::size_t, Loaded> loaded;
  std::uint64_t loaded_bytes = 0;
  std::size_t slot = 0;
  while (true) {
    while (slot < to_load.size() && (heap.empty() || to_load[slot]->start_time_ns <= std::get<0>(heap.top()))) {
      Loaded next = load_or_report(*to_load[slot]);
      if (!next.messages.empty()) {
        loaded_bytes += next.bytes();
        if (loaded_bytes > kMaxLoadedBytes) fail(next.chunk.offset, "too many chunks overlap in time to be sorted");
        heap.emplace(next.messages.front().log_time_ns, next.chunk.offset, slot);
        loaded.emplace(slot, std::move(next));
      }
      ++slot;
    }
    if (heap.empty()) return;
    const auto [time, offset, first] = heap.top();
    heap.pop();
    Loaded& l = loaded.at(first);
    if (!on_message(l.messages[l.next])) return;
    if (++l.next < l.messages.size()) {
      heap.emplace(l.messages[l.next].log_time_ns, offset, first);
    } else {
      loaded_bytes -= l.bytes();
      loaded.erase(first);
    }
  }
}

void McapReader::scan_message(const ByteCursor& record, Compression compression, Scan& scan) const {
  const McapMessage message = decode_message(record);
  if (!scan.channels.contains(message.channel_id)) {
    if (scan.unknown.insert(message.channel_id).second)
      scan.out.damages.push_back(path_ + ": at byte " + std::to_string(record.offset()) +
                                 ": messages of the unknown channel " + std::to_string(message.channel_id));
    return;
  }
  ++scan.out.messages;
  if (scan.visitor.message) scan.visitor.message(message, compression);
}

void McapReader::scan_record(Op op, ByteView content, std::uint64_t offset, Scan& scan) const {
  ByteCursor in(content, path_, offset + kRecordHead);
  if (op == Op::schema && scan.visitor.schema) scan.visitor.schema(decode_schema(in));
  if (op == Op::metadata && scan.visitor.metadata) scan.visitor.metadata(decode_metadata(in));
  if (op == Op::message) {
    // no checksum shields what stands outside of chunks, where palp puts no message: this is another record, damaged
    if (options_.check_crc && library_ == kMcapLibrary) fail(offset, "a message outside of any chunk");
    scan_message(in, Compression::none, scan);
  }
  if (op == Op::channel) {
    const McapChannel channel = decode_channel(in);
    scan.channels.insert(channel.id);
    if (scan.visitor.channel) scan.visitor.channel(channel);
  }
  if (op == Op::message_index) {
    in.get<std::uint16_t>();
    in.sub();
    if (in.left() != 0) in.fail("a message index says two lengths");
  }
  if (op != Op::chunk) return;
  const Chunk chunk = unpack_chunk(content, offset);
  if (scan.visitor.chunk) scan.visitor.chunk(offset);
  ByteCursor records(chunk.records, path_ + ": in the chunk at byte " + std::to_string(offset), 0);
  while (records.left() > 0) {
    const auto inner = records.get<Op>();
    const auto length = records.get<std::uint64_t>();
    const ByteView inner_content = records.take(length);
    if (inner == Op::message) {
      scan_message(ByteCursor(inner_content, path_, offset), chunk.compression, scan);
    } else if (inner == Op::schema || inner == Op::channel) {
      scan_record(inner, inner_content, offset, scan);
    }
  }
  ++scan.out.chunks;
}

McapChunkContent McapReader::read_chunk(std::uint64_t offset) const {
  const RecordHead head = head_at(offset);
  if (head.op != Op::chunk) fail(offset, "a chunk was expected");
  McapChunkContent out;
  out.records = unpack_chunk(bytes_at(offset + kRecordHead, head.length), offset).records;
  ByteCursor in(out.records, path_ + ": in the chunk at byte " + std::to_string(offset), 0);
  while (in.left() > 0) {
    const auto op = in.get<Op>();
    const ByteView record = in.take(in.get<std::uint64_t>());
    if (op == Op::message) out.messages.push_back(decode_message(ByteCursor(record, path_, offset)));
  }
  return out;
}

McapScan McapReader::scan(const McapVisitor& visitor) const {
  Scan scan{visitor, {}, {}, {}};
  McapScan& out = scan.out;
  for (const auto& [id, schema] : schemas_)
    if (visitor.schema) visitor.schema(schema);
  for (const auto& [id, channel] : channels_) {
    scan.channels.insert(id);
    if (visitor.channel) visitor.channel(channel);
  }
  std::uint32_t data_crc = crc32_of(0, bytes_at(0, data_start_));
  std::uint64_t at = data_start_;
  while (true) {
    std::uint64_t next = 0;
    try {
      if (at == size_) fail(at, "the file ends before the end of its data section");
      const RecordHead head = head_at(at);
      next = at + kRecordHead + head.length;
      const Bytes record = bytes_at(at, kRecordHead + head.length);
      const ByteView content = ByteView(record).subspan(kRecordHead);
      if (head.op == Op::data_end) {
        out.complete = true;
        const auto expected = ByteCursor(content, path_, at + kRecordHead).get<std::uint32_t>();
        if (options_.check_crc && expected != 0 && expected != data_crc && out.damages.empty())
          fail(at, "the checksum of the data section is wrong");
        return out;
      }
      data_crc = crc32_of(data_crc, record);
      if (head.op == Op::footer) fail(at, "the footer comes before the end of the data section");
      scan_record(head.op, content, at, scan);
    } catch (const McapError& error) {
      if (out.damages.size() < kMostDamages)
        out.damages.emplace_back(error.what());
      else if (out.damages.size() == kMostDamages)
        out.damages.push_back(path_ + ": further damages are not listed");
      if (out.complete) return out;
      // the length of a damaged record may be wrong: better go on at the next chunk that the index knows
      for (const McapChunkIndex& chunk : chunks_)
        if (chunk.offset > at && (next == 0 || chunk.offset < next)) next = chunk.offset;
      if (next == 0) return out;
    }
    at = next;
  }
}

}  // namespace palp
