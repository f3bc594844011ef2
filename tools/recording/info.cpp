#include "tools/recording/info.h"

#include <fmt/format.h>

#include "idl/mcap/mcap_reader.h"
#include "idl/topics.h"
#include "tools/recording/servers_heard.h"

namespace palp {
namespace {

// Returns a warning if two servers spoke at one time, else nothing.
std::string describe_servers(const McapReader& reader) {
  std::set<std::uint16_t> statuses;
  for (const auto& [id, channel] : reader.channels())
    if (channel.topic == topic_of<Status>().name) statuses.insert(id);
  if (statuses.empty()) return "";
  ServersHeard servers;
  const auto add = [&](const McapMessage& m) {
    servers.add(m.data, m.log_time_ns);
    return true;
  };
  reader.read(add, statuses, [](const std::string&) {});
  if (servers.together() == 0) return "";
  return fmt::format("  {} servers spoke at one time: {}\n", servers.together(), kServersTogether);
}

}  // namespace

std::string describe_recording(const std::string& path) {
  const McapReader reader(path);
  if (!reader.indexed()) throw McapError(reader.index_fault());
  const McapStatistics statistics = reader.statistics().value_or(McapStatistics{});
  const double seconds = static_cast<double>(statistics.end_time_ns - statistics.start_time_ns) * 1e-9;
  std::string out =
      fmt::format("{}\n  {:.1f} MB, {:.3f} s, {} messages, {} chunks\n", path,
                  static_cast<double>(reader.size()) * 1e-6, seconds, statistics.messages, statistics.chunks);
  std::map<std::string, std::string> values;
  for (const McapMetadata& metadata : reader.metadata())
    if (metadata.name == "palp_recording") values = metadata.values;
  const auto value = [&](const std::string& key) { return values.contains(key) ? values.at(key) : std::string("?"); };
  if (!values.empty())
    out +=
        fmt::format("  started {}, recorded with {} in domain {}\n", value("started"), value("dds"), value("domain"));
  out += fmt::format("  {:20} {:32} {:>9} {:>9} {:>8} {:>8}\n", "topic", "type", "messages", "rate", "dropped", "lost");
  for (const auto& [id, channel] : reader.channels()) {
    const auto count = statistics.channel_messages.find(id);
    const std::uint64_t messages = count == statistics.channel_messages.end() ? 0 : count->second;
    const auto schema = reader.schemas().find(channel.schema_id);
    out += fmt::format("  {:20} {:32} {:>9} {:>9} {:>8} {:>8}\n", channel.topic,
                       schema == reader.schemas().end() ? "" : schema->second.name, messages,
                       seconds > 0 ? fmt::format("{:.1f} Hz", static_cast<double>(messages) / seconds) : "",
                       value("dropped " + channel.topic), value("lost " + channel.topic));
  }
  return out + describe_servers(reader);
}

}  // namespace palp
