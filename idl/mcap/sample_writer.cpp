#include "idl/mcap/sample_writer.h"

#include <algorithm>

#include "idl/idl_text.h"

namespace palp {
namespace {

constexpr std::uint64_t kFlushEveryNs = 1'000'000'000;

McapWriterOptions writer_options(bool overwrite) {
  McapWriterOptions options;
  options.overwrite = overwrite;
  return options;
}

std::string qos_of(const TopicRow& topic) {
  const auto number = [](bool value) { return value ? "true" : "false"; };
  return std::string("reliability: ") + number(topic.reliability == Reliability::reliable) +
         "\ndurability: " + number(topic.durability == Durability::transient_local) +
         "\nownership: false\nkeyed: " + number(topic.key_bytes > 0) + "\n";
}

}  // namespace

Compression compression_for(const TopicRow& topic) {
  return topic.name == std::string_view(topic_of<ParticleChunk>().name) ? Compression::none : Compression::zstd;
}

std::uint16_t add_topic(McapWriter& writer, const TopicRow& topic) {
  const std::uint16_t schema = writer.add_schema(topic.type_name, "omgidl", kPalpIdlText);
  return writer.add_channel(topic.name, schema, "cdr", {{"qos", qos_of(topic)}}, compression_for(topic));
}

SampleWriter::SampleWriter(const std::string& path, std::uint64_t session, bool overwrite)
    : writer_(path, writer_options(overwrite)), session_(session) {}

SampleWriter::Source& SampleWriter::source_of(const TopicRow& topic) {
  Source& source = sources_[static_cast<std::size_t>(&topic - kTopics.data())];
  if (source.channel == 0) source.channel = add_topic(writer_, topic);
  return source;
}

void SampleWriter::write(const Source& source, const std::vector<std::uint8_t>& payload, std::uint64_t t_ns) {
  last_time_ns_ = std::max(t_ns, last_time_ns_ + 1);
  writer_.write({source.channel, static_cast<std::uint32_t>(source.sequence), last_time_ns_, last_time_ns_, payload});
  if (last_time_ns_ < next_flush_ns_) return;
  writer_.flush();
  next_flush_ns_ = last_time_ns_ + kFlushEveryNs;
}

void SampleWriter::close(const std::map<std::string, std::string>& description) {
  McapMetadata metadata{"palp_recording", description};
  metadata.values["protocol_version"] = std::to_string(kProtocolVersion);
  writer_.add_metadata(metadata);
  writer_.close();
}

}  // namespace palp
