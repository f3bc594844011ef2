#include "tools/recording/info.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "idl/roster.h"
#include "idl/topics.h"
#include "tools/recording/mcap_reader.h"

namespace palp {
namespace {

struct Span {
  std::uint64_t first_ns = 0, last_ns = 0;
};

template <class T>
T value_at(ByteView bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

// Returns when each server of the recording spoke, by session.
std::map<std::uint64_t, Span> servers_in(const McapReader& reader) {
  // behind the encapsulation: the key, the version that fills eight bytes, the session
  constexpr std::size_t kKeyAt = 4, kSessionAt = kKeyAt + 16;
  std::set<std::uint16_t> statuses;
  for (const auto& [id, channel] : reader.channels())
    if (channel.topic == topic_of<Status>().name) statuses.insert(id);
  std::map<std::uint64_t, Span> servers;
  if (statuses.empty()) return servers;
  reader.read(
      [&](const McapMessage& m) {
        if (m.data.size() < kSessionAt + 8 || value_at<std::uint64_t>(m.data, kKeyAt) != process_key(kServerName))
          return true;
        const auto [server, is_new] = servers.try_emplace(value_at<std::uint64_t>(m.data, kSessionAt));
        if (is_new) server->second.first_ns = m.log_time_ns;
        server->second.last_ns = m.log_time_ns;
        return true;
      },
      statuses, [](const std::string&) {});
  return servers;
}

// Returns a warning if two servers spoke at one time, else nothing.
std::string describe_servers(const McapReader& reader) {
  const std::map<std::uint64_t, Span> servers = servers_in(reader);
  std::size_t together = 0;
  for (const auto& [session, span] : servers)
    together += std::any_of(servers.begin(), servers.end(), [&, here = session, at = span](const auto& other) {
      return other.first != here && other.second.first_ns < at.last_ns && at.first_ns < other.second.last_ns;
    });
  if (together == 0) return "";
  return fmt::format(
      "  {} servers spoke at one time: what is recorded of the simulation is of all of them, told apart by the session "
      "of each sample\n",
      together);
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
