// How palp's topics stand in a recording, and a writer of messages that needs no bus.
#pragma once

#include <array>
#include <map>
#include <string>

#include "idl/cdr.h"
#include "idl/mcap/mcap_writer.h"

namespace palp {

// Positions do not get smaller by compression, everything else does.
Compression compression_for(const TopicRow& topic);
// Adds the schema and the channel of a topic, whose metadata tell its quality of service in the form that eProsima's
// DDS recorder writes, too. Returns the channel's id. Throws McapError.
std::uint16_t add_topic(McapWriter& writer, const TopicRow& topic);

// Writes messages as palp-record writes the samples that it hears. Same calls, same bytes of the file. The first
// message and each second of the recording are put in whole chunks, so that a writer that is killed loses no more than
// that. One thread.
class SampleWriter {
 public:
  // session: what stands in the messages' headers, not 0. Throws McapError when the file exists already, unless
  // overwrite, or cannot be created.
  SampleWriter(const std::string& path, std::uint64_t session, bool overwrite);

  // Fills in the header and writes the message as sent and heard at t_ns. No two messages of a file have the same time,
  // so that readers keep their order: one that would have is moved on by a nanosecond. Throws McapError when the disk
  // refuses.
  template <class T>
  void write(T& message, std::uint64_t t_ns) {
    Source& source = source_of(topic_of<T>());
    message.header = {kProtocolVersion, session_, ++source.sequence, static_cast<std::int64_t>(t_ns)};
    write(source, to_cdr(message), t_ns);
  }
  // Writes what is known of the recording and finishes the file. No call may follow. Throws McapError.
  void close(const std::map<std::string, std::string>& description);

  const McapStatistics& statistics() const { return writer_.statistics(); }

 private:
  struct Source {
    std::uint16_t channel = 0;  // 0: none yet
    std::uint64_t sequence = 0;
  };
  Source& source_of(const TopicRow& topic);
  void write(const Source& source, const std::vector<std::uint8_t>& payload, std::uint64_t t_ns);

  McapWriter writer_;
  std::uint64_t session_;
  std::array<Source, kTopics.size()> sources_;
  std::uint64_t last_time_ns_ = 0, next_flush_ns_ = 0;
};

}  // namespace palp
