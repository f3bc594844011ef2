#include "tools/recording/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <utility>

#include "idl/clock.h"
#include "idl/mcap/sample_writer.h"

namespace palp {
namespace {

constexpr auto kFlushEvery = std::chrono::seconds(1);  // at most so much is lost with a killed recorder
// Between two polls; a recorder that is held up longer than this many samples loses some, as DDS then counts.
constexpr int kControlDepth = 4096;
constexpr std::size_t kRecordOverhead = 128;  // of the queue, so that tiny samples cannot fill the memory

std::uint64_t realtime_ns() {
  timespec t{};
  clock_gettime(CLOCK_REALTIME, &t);
  return static_cast<std::uint64_t>(t.tv_sec) * 1'000'000'000u + static_cast<std::uint64_t>(t.tv_nsec);
}

bool is_particles(const TopicRow& topic) { return topic.name == std::string_view(topic_of<ParticleChunk>().name); }

McapWriterOptions writer_options(const RecorderOptions& options) {
  McapWriterOptions out;
  out.overwrite = options.overwrite;
  return out;
}

}  // namespace

TopicCounts RecordingCounts::total() const {
  TopicCounts sum;
  for (const auto& [topic, counts] : topics) {
    sum.messages += counts.messages;
    sum.bytes += counts.bytes;
    sum.dropped += counts.dropped;
    sum.lost += counts.lost;
  }
  return sum;
}

Recorder::Recorder(RecorderOptions options)
    : options_(std::move(options)),
      start_time_ns_(realtime_ns()),
      started_ns_(now_ns()),
      bus_(open_raw_bus(options_.bus)),
      writer_(options_.path, writer_options(options_)) {
  for (const TopicRow* topic : options_.topics) {
    Source source;
    source.topic = topic;
    source.reader = bus_->reader(*topic, is_particles(*topic) ? kParticleReaderDepth : kControlDepth);
    if (const auto it = options_.decimation.find(topic); it != options_.decimation.end())
      source.keep_every = it->second;
    sources_.push_back(std::move(source));
  }
  channels_.assign(sources_.size(), 0);
  sequences_.assign(sources_.size(), 0);
  thread_ = std::thread([this] { write_loop(); });
}

Recorder::~Recorder() { stop_writing(); }

// Both vendors hand over what waits key by key; the senders' stamps put it back in order, also between topics.
void Recorder::poll(std::chrono::milliseconds timeout) {
  if (!bus_->wait(timeout)) return;
  for (std::size_t i = 0; i < sources_.size(); ++i)
    sources_[i].reader->take([&](Payload payload, std::int64_t source_time_ns) {
      if (!wanted(sources_[i], payload)) return;
      const std::uint64_t now = start_time_ns_ + static_cast<std::uint64_t>(now_ns() - started_ns_);
      taken_.push_back({i, now, source_time_ns > 0 ? static_cast<std::uint64_t>(source_time_ns) : now,
                        Bytes(payload.begin(), payload.end())});
    });
  std::stable_sort(taken_.begin(), taken_.end(),
                   [](const Record& a, const Record& b) { return a.publish_time_ns < b.publish_time_ns; });
  for (Record& record : taken_) {
    // no two log times are equal, so that readers of the file keep this order
    last_log_time_ns_ = record.log_time_ns = std::max(record.log_time_ns, last_log_time_ns_ + 1);
    if (sources_[record.source].topic == &topic_of<Status>()) servers_.add(record.payload, record.log_time_ns);
    queue(std::move(record));
  }
  taken_.clear();
}

// Particles are thinned out by whole frames: their number stands behind the header, which is 32 bytes long.
bool Recorder::wanted(Source& source, Payload payload) const {
  if (source.keep_every == 1) return true;
  constexpr std::size_t kFrameAt = 4 + 32;
  if (!is_particles(*source.topic)) return source.seen++ % source.keep_every == 0;
  if (payload.size() < kFrameAt + 8) return true;
  std::uint64_t frame = 0;
  std::memcpy(&frame, payload.data() + kFrameAt, sizeof frame);
  return frame % source.keep_every == 0;
}

void Recorder::queue(Record record) {
  TopicCounts& counts = sources_[record.source].counts;
  const std::size_t payload_bytes = record.payload.size();
  {
    const std::lock_guard lock(mutex_);
    if (payload_bytes > kMaxMessageBytes || queued_bytes_ + payload_bytes + kRecordOverhead > options_.queue_bytes) {
      ++counts.dropped;
      return;
    }
    queued_bytes_ += payload_bytes + kRecordOverhead;
    queue_.push_back(std::move(record));
  }
  ++counts.messages;
  counts.bytes += payload_bytes;
  queue_filled_.notify_one();
}

void Recorder::write(const Record& record) {
  std::uint16_t& channel = channels_[record.source];
  if (channel == 0) channel = add_topic(writer_, *sources_[record.source].topic);
  writer_.write({channel, ++sequences_[record.source], record.log_time_ns, record.publish_time_ns, record.payload});
}

void Recorder::write_loop() {
  auto next_flush = std::chrono::steady_clock::now() + kFlushEvery;
  std::deque<Record> batch;
  bool ending = false;
  try {
    while (!ending) {
      {
        std::unique_lock lock(mutex_);
        queue_filled_.wait_until(lock, next_flush, [&] { return ending_ || !queue_.empty(); });
        batch.swap(queue_);
        ending = ending_;
      }
      for (const Record& record : batch) {
        write(record);
        const std::lock_guard lock(mutex_);
        queued_bytes_ -= record.payload.size() + kRecordOverhead;
      }
      batch.clear();
      if (std::chrono::steady_clock::now() >= next_flush) {
        writer_.flush();
        next_flush += kFlushEvery;
      }
    }
  } catch (const std::exception& error) {
    failure_ = error.what();
    failed_ = true;
  }
}

void Recorder::stop_writing() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  queue_filled_.notify_one();
  thread_.join();
}

RecordingCounts Recorder::counts() const {
  RecordingCounts out;
  for (const Source& source : sources_) {
    TopicCounts& counts = out.topics[source.topic] = source.counts;
    counts.lost = source.reader->lost();
  }
  return out;
}

int Recorder::writers() const {
  int sum = 0;
  for (const Source& source : sources_) sum += source.reader->matched_writers();
  return sum;
}

McapMetadata Recorder::description() const {
  const auto start = static_cast<std::time_t>(start_time_ns_ / 1'000'000'000u);
  std::tm utc{};
  gmtime_r(&start, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  McapMetadata out{"palp_recording", {}};
  out.values["started"] = text.data();
  out.values["dds"] = to_string(options_.bus.vendor);
  out.values["domain"] = std::to_string(options_.bus.domain);
  out.values["protocol_version"] = std::to_string(kProtocolVersion);
  for (const auto& [topic, counts] : counts().topics) {
    out.values[fmt::format("dropped {}", topic->name)] = std::to_string(counts.dropped);
    out.values[fmt::format("lost {}", topic->name)] = std::to_string(counts.lost);
  }
  for (const auto& [topic, n] : options_.decimation)
    out.values[fmt::format("every {}", topic->name)] = std::to_string(n);
  return out;
}

void Recorder::finish() {
  stop_writing();
  if (failed_) throw McapError(failure_);
  writer_.add_metadata(description());
  writer_.close();
}

}  // namespace palp
