// Writes an MCAP file: chunks with checksums and compression, message and chunk index, statistics, metadata, summary.
// While it is written the file is called NAME.tmp~ and is whole up to the last chunk, so that a killed recorder loses
// no more than its open chunks; close() adds the summary and gives the file its name.
//
// Messages of channels with the same compression share a chunk, so particles need not pass through zstd.
// One thread.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "idl/mcap/compression.h"
#include "idl/mcap/mcap_format.h"

namespace palp {

inline constexpr const char* kUnfinishedSuffix = ".tmp~";

struct McapWriterOptions {
  std::size_t chunk_bytes = 1 << 20;  // a chunk is closed once its messages reach this size
  std::string library = kMcapLibrary;
  bool overwrite = false;  // else an existing file, finished or not, is an error
  std::string unfinished_suffix = kUnfinishedSuffix;
  bool keep_unfinished = true;  // false: what was not closed is removed, as its source still exists
};

class McapWriter {
 public:
  // Throws McapError when the file exists (see overwrite) or cannot be created.
  McapWriter(std::string path, McapWriterOptions options = {});
  // Unless close() was called, leaves the unfinished file where it is, if there is a message in it.
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  // Return the id. Throw McapError when the disk refuses or there are 65535 of them.
  std::uint16_t add_schema(const std::string& name, const std::string& encoding, const std::string& data);
  std::uint16_t add_channel(const std::string& topic, std::uint16_t schema_id, const std::string& encoding,
                            const std::map<std::string, std::string>& metadata, Compression compression);
  void add_metadata(const McapMetadata& metadata);

  // Throws McapError when the disk refuses; from then on the file stays as it is, whole up to its last good record, and
  // every further call but the destructor throws the same error. std::invalid_argument for an unknown channel.
  void write(const McapMessage& message);
  // Closes the open chunks, so that all messages so far are in the file.
  void flush();
  // Finishes the file and renames it. No call may follow.
  void close();

  const std::string& unfinished_path() const { return unfinished_path_; }
  std::uint64_t bytes_written() const { return offset_; }  // to the disk, so far
  const McapStatistics& statistics() const { return statistics_; }

 private:
  struct OpenChunk {
    Bytes records;
    std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> index;  // channel: time, offset
    std::uint64_t start_time_ns = 0;
    std::uint64_t end_time_ns = 0;
  };

  void append(ByteView bytes);
  void append_record(Op op, ByteView content);
  [[noreturn]] void fail(const std::string& what);
  void close_chunk(Compression compression);
  Bytes summary(std::uint64_t start) const;

  std::string path_;
  std::string unfinished_path_;
  McapWriterOptions options_;
  int file_ = -1;
  std::string failure_;  // not empty: the disk refused
  std::uint64_t offset_ = 0;
  std::uint32_t data_crc_ = 0;
  std::vector<McapSchema> schemas_;
  std::vector<McapChannel> channels_;
  std::vector<Compression> channel_compression_;
  std::map<Compression, OpenChunk> open_;
  std::vector<McapChunkIndex> chunks_;
  struct MetadataIndex {
    std::uint64_t offset;
    std::uint64_t length;
    std::string name;
  };
  std::vector<MetadataIndex> metadata_;
  McapStatistics statistics_;
};

}  // namespace palp
