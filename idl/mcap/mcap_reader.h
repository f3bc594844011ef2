// Reads MCAP files: in the order of time through the index, or from front to end without one, which also reads what a
// killed recorder left. No byte is trusted: lengths are checked before use, checksums before content is handed on.
// One thread.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "idl/mcap/compression.h"
#include "idl/mcap/mcap_format.h"

namespace palp {

class ByteCursor;

struct McapReaderOptions {
  bool check_crc = true;  // false only for tests that must reach what a checksum shields
};

// Functions that get what a scan meets. Any may be left empty. A schema or channel may come more than once. A McapError
// of theirs counts as damage of the file, any other exception ends the scan.
struct McapVisitor {
  std::function<void(const McapSchema&)> schema;
  std::function<void(const McapChannel&)> channel;
  std::function<void(std::uint64_t offset)> chunk;  // the messages that follow stand in the chunk at this byte
  std::function<void(const McapMessage&, Compression)> message;
  std::function<void(const McapMetadata&)> metadata;
};

// The messages of one chunk in the order of the file. They point into `records`.
struct McapChunkContent {
  Bytes records;
  std::vector<McapMessage> messages;
};

struct McapScan {
  std::uint64_t messages = 0;
  std::uint64_t chunks = 0;
  bool complete = false;             // reached the end of the data section
  std::vector<std::string> damages;  // each: file, byte offset, what; empty for a whole file
};

class McapReader {
 public:
  // Opens the file and reads its summary. Throws McapError when it cannot be read or is no MCAP file. A missing or
  // damaged summary is no error: see indexed().
  explicit McapReader(std::string path, McapReaderOptions options = {});
  ~McapReader();
  McapReader(const McapReader&) = delete;
  McapReader& operator=(const McapReader&) = delete;

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  const std::string& library() const { return library_; }
  bool indexed() const { return index_fault_.empty(); }
  const std::string& index_fault() const { return index_fault_; }  // why not and what to do, one sentence

  // From the summary; empty without an index.
  const std::map<std::uint16_t, McapSchema>& schemas() const { return schemas_; }
  const std::map<std::uint16_t, McapChannel>& channels() const { return channels_; }
  const std::vector<McapChunkIndex>& chunks() const { return chunks_; }
  const std::optional<McapStatistics>& statistics() const { return statistics_; }
  // Reads the metadata records. Throws McapError on damage.
  std::vector<McapMetadata> metadata() const;

  // Hands over the messages of the chosen channels (empty: all) in the order of log time, messages of one time in the
  // order of the file, until `on_message` returns false. A damaged chunk is left out and `on_damage` gets one sentence
  // on it; without `on_damage` it throws McapError. Throws McapError without an index.
  void read(const std::function<bool(const McapMessage&)>& on_message, const std::set<std::uint16_t>& chosen = {},
            const std::function<void(const std::string&)>& on_damage = {}) const;
  // Reads from front to end, leaves out what is damaged and says so. Needs no index, but finds its way behind damage
  // with one.
  McapScan scan(const McapVisitor& visitor) const;
  // Reads the chunk at this byte, as a scan told of it. Throws McapError when there is no sound one.
  McapChunkContent read_chunk(std::uint64_t offset) const;

 private:
  struct RecordHead {
    Op op;
    std::uint64_t length;
  };
  Bytes bytes_at(std::uint64_t offset, std::uint64_t length) const;
  RecordHead head_at(std::uint64_t offset) const;
  void read_summary();
  void check_chunk_index(const McapChunkIndex& chunk) const;
  struct Chunk;
  struct Loaded;
  struct Scan {  // a scan in progress
    const McapVisitor& visitor;
    McapScan out;
    std::set<std::uint16_t> channels;  // known so far
    std::set<std::uint16_t> unknown;   // met without their channel record
  };
  Chunk unpack_chunk(ByteView content, std::uint64_t offset) const;
  Chunk load(const McapChunkIndex& index) const;
  std::vector<const McapChunkIndex*> chunks_by_time(const std::set<std::uint16_t>& chosen) const;
  Loaded load_messages(const McapChunkIndex& index, const std::set<std::uint16_t>& chosen) const;
  void scan_message(const ByteCursor& record, Compression compression, Scan& scan) const;
  void scan_record(Op op, ByteView content, std::uint64_t offset, Scan& scan) const;
  [[noreturn]] void fail(std::uint64_t offset, const std::string& what) const;

  std::string path_;
  McapReaderOptions options_;
  int file_ = -1;
  std::uint64_t size_ = 0;
  std::uint64_t data_start_ = 0;  // after the header
  std::string library_;
  std::string index_fault_;
  std::map<std::uint16_t, McapSchema> schemas_;
  std::map<std::uint16_t, McapChannel> channels_;
  std::vector<McapChunkIndex> chunks_;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> metadata_at_;  // offset, length
  std::optional<McapStatistics> statistics_;
};

}  // namespace palp
