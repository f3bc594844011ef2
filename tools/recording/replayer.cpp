#include "tools/recording/replayer.h"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <stdexcept>
#include <thread>

#include "idl/clock.h"
#include "idl/histogram.h"
#include "tools/recording/topic_choice.h"

namespace palp {
namespace {

using namespace std::chrono_literals;

constexpr auto kSettle = 1000ms;  // a writer may know its reader before the reader knows the writer
constexpr auto kLinger = 300ms;   // a Fast DDS reader drops what it has not taken yet when the writer goes
constexpr std::int64_t kLongestSleepNs = 50'000'000;  // so that a stop is noticed
constexpr double kMostNs = 1e18;                      // no recording is longer, whatever its stamps say

class Replay {
 public:
  Replay(const ReplayOptions& options, const ReplayHooks& hooks)
      : options_(options), hooks_(hooks), file_(options.path), bus_(open_raw_bus(options.bus)) {
    if (!file_.indexed()) throw McapError(file_.index_fault());
    for (const auto& [id, channel] : file_.channels()) {
      const TopicRow* topic = find_topic(channel.topic);
      if (topic == nullptr || std::find(options_.topics.begin(), options_.topics.end(), topic) == options_.topics.end())
        continue;
      check_type(channel, *topic);
      if (!writers_.contains(topic)) writers_[topic].writer = bus_->writer(*topic);
      channels_[id] = topic;
    }
    if (channels_.empty()) throw std::runtime_error(options_.path + ": none of the chosen topics is in the recording");
    for (const auto& [id, topic] : channels_) chosen_.insert(id);
  }

  ReplayCounts run() {
    wait_for_readers();
    do {
      ++counts_.rounds;
      play_round();
    } while (options_.loop && !stopped_ && counts_.messages > 0);
    for (auto& [topic, out] : writers_)
      if (!stopped_ && topic->reliability == Reliability::reliable) out.writer->wait_acknowledged(1000ms);
    if (!stopped_) std::this_thread::sleep_for(kLinger);
    counts_.lateness_p50_us = lateness_.quantile_us(0.5);
    counts_.lateness_p99_us = lateness_.quantile_us(0.99);
    counts_.lateness_max_us = lateness_.max_us();
    return counts_;
  }

 private:
  struct Out {
    std::unique_ptr<RawWriter> writer;
    std::int64_t last_write_ns = 0;
  };

  void check_type(const McapChannel& channel, const TopicRow& topic) const {
    const auto schema = file_.schemas().find(channel.schema_id);
    if (channel.encoding != "cdr" || schema == file_.schemas().end() || schema->second.name != topic.type_name)
      throw std::runtime_error(fmt::format("{}: {} holds {} as {}, expected {} as cdr", options_.path, channel.topic,
                                           schema == file_.schemas().end() ? "no type" : schema->second.name,
                                           channel.encoding, topic.type_name));
  }

  int matched() const {
    int sum = 0;
    for (const auto& [topic, out] : writers_) sum += out.writer->matched_readers();
    return sum;
  }

  // Then until no further reader has come for a while.
  void wait_for_readers() {
    if (options_.wait_readers == 0) return;
    const std::int64_t give_up = now_ns() + static_cast<std::int64_t>(options_.wait_seconds * 1e9);
    int known = -1;
    std::int64_t known_since = 0;
    while (!hooks_.stop()) {
      const int now_matched = matched();
      if (now_matched != known) {
        known = now_matched;
        known_since = now_ns();
      }
      if (known >= options_.wait_readers && now_ns() - known_since >= std::chrono::nanoseconds(kSettle).count()) return;
      if (known < options_.wait_readers && now_ns() > give_up)
        throw std::runtime_error(
            fmt::format("{} of {} readers came within {:g} s: start them, or give --wait-readers 0", known,
                        options_.wait_readers, options_.wait_seconds));
      std::this_thread::sleep_for(20ms);
    }
    stopped_ = true;
  }

  // The first message of each transient-local topic, and those behind it that are older than the recording, go first: a
  // reader of a live system has them before the rest, too. One that comes behind a younger message of its topic stays
  // there, so that each topic keeps its order.
  std::set<std::uint64_t> play_kept_messages() {
    std::set<std::uint64_t> played;  // by log time
    std::set<std::uint16_t> kept;
    for (const auto& [id, topic] : channels_)
      if (topic->durability == Durability::transient_local) kept.insert(id);
    if (kept.empty()) return played;
    const std::uint64_t begin = file_.statistics() ? file_.statistics()->start_time_ns : 0;
    std::set<std::uint16_t> met, begun;  // begun: that have met a message of the recording's own time
    file_.read(
        [&](const McapMessage& m) {
          if (!met.insert(m.channel_id).second && m.publish_time_ns >= begin) begun.insert(m.channel_id);
          if (begun.contains(m.channel_id)) return !hooks_.stop();
          if (options_.step == Step::message && !next_step()) return false;
          send(m);
          played.insert(m.log_time_ns);
          return !hooks_.stop();
        },
        kept, [this](const std::string& damage) { report(damage); });
    return played;
  }

  // A chunk is met again in every round, and twice when it holds what is played first.
  void report(const std::string& damage) {
    if (!damages_.insert(damage).second) return;
    ++counts_.lost_chunks;
    if (hooks_.on_damage) hooks_.on_damage(damage);
  }

  // Returns how many messages of the chosen channels the index promises.
  std::uint64_t promised() const {
    std::uint64_t sum = 0;
    if (!file_.statistics()) return sum;
    for (const auto& [id, count] : file_.statistics()->channel_messages)
      if (chosen_.contains(id)) sum += count;
    return sum;
  }

  void play_round() {
    const std::set<std::uint64_t> played = play_kept_messages();
    bool step_begins = true;
    std::uint64_t first_log_ns = 0;
    std::int64_t start_ns = 0;
    std::uint64_t read = 0;
    file_.read(
        [&](const McapMessage& m) {
          ++read;
          const TopicRow& topic = *channels_.at(m.channel_id);
          if (hooks_.stop()) stopped_ = true;
          if (stopped_) return false;
          if (topic.durability == Durability::transient_local && played.contains(m.log_time_ns)) return true;
          if (options_.step != Step::none) {
            if (step_begins && !next_step()) return false;
            step_begins = options_.step == Step::message || &topic == &topic_of<ProxySample>();
          } else if (options_.rate > 0) {
            if (start_ns == 0) {
              first_log_ns = m.log_time_ns;
              start_ns = now_ns();
            }
            const double since = static_cast<double>(m.log_time_ns - first_log_ns) / options_.rate;
            if (!sleep_until(start_ns + static_cast<std::int64_t>(std::min(since, kMostNs)))) return false;
          }
          send(m);
          return true;
        },
        chosen_, [this](const std::string& damage) { report(damage); });
    if (!stopped_ && !damages_.empty()) counts_.lost_messages = promised() - std::min(promised(), read);
  }

  bool next_step() {
    if (!hooks_.wait_for_step()) stopped_ = true;
    return !stopped_;
  }

  bool sleep_until(std::int64_t due_ns) {
    while (true) {
      const std::int64_t now = now_ns();
      if (now >= due_ns) {
        lateness_.add(now - due_ns);
        return true;
      }
      const timespec t = to_timespec(std::min(due_ns, now + kLongestSleepNs));
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr);
      if (hooks_.stop()) {
        stopped_ = true;
        return false;
      }
    }
  }

  void send(const McapMessage& m) {
    const TopicRow& topic = *channels_.at(m.channel_id);
    Out& out = writers_.at(&topic);
    // a writer keeps few samples: reliable ones that come in a burst wait until the readers have the last
    if (topic.reliability == Reliability::reliable && now_ns() - out.last_write_ns < 50'000'000)
      out.writer->wait_acknowledged(100ms);
    out.last_write_ns = now_ns();
    const bool ok = counts_.rounds < 2 ? out.writer->write(m.data) : out.writer->write(renewed(m.data, topic));
    ++(ok ? counts_.messages : counts_.refused);
  }

  // From the second round on the sequence numbers begin again; the sender's session changes with the round, so that
  // readers take it for a restart and not for old samples.
  Payload renewed(Payload payload, const TopicRow& topic) {
    const std::size_t session_at = 4 + (topic.key_bytes > 0 ? 8 : 0) + 8;  // behind encapsulation, key and version
    again_.assign(payload.begin(), payload.end());
    if (again_.size() < session_at + 8) return payload;
    std::uint64_t session = 0;
    std::memcpy(&session, again_.data() + session_at, sizeof session);
    session += counts_.rounds - 1;
    std::memcpy(again_.data() + session_at, &session, sizeof session);
    return again_;
  }

  const ReplayOptions& options_;
  const ReplayHooks& hooks_;
  McapReader file_;
  std::unique_ptr<RawBus> bus_;
  std::map<const TopicRow*, Out> writers_;
  std::map<std::uint16_t, const TopicRow*> channels_;
  std::set<std::uint16_t> chosen_;
  bool stopped_ = false;
  ReplayCounts counts_;
  std::set<std::string> damages_;
  Histogram lateness_;
  Bytes again_;
};

}  // namespace

ReplayCounts replay(const ReplayOptions& options, const ReplayHooks& hooks) { return Replay(options, hooks).run(); }

}  // namespace palp
