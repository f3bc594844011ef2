// Records topics to an MCAP file: the caller's thread takes samples from the bus into a bounded queue, a thread of the
// recorder's own compresses and writes them. A disk that is too slow costs samples, which are counted, and never makes
// the take thread wait.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "idl/mcap/mcap_writer.h"
#include "tools/recording/raw_bus.h"
#include "tools/recording/servers_heard.h"

namespace palp {

struct RecorderOptions {
  BusOptions bus;
  std::string path;
  bool overwrite = false;
  std::vector<const TopicRow*> topics;
  std::map<const TopicRow*, unsigned> decimation;    // keep every n-th (particles: frame)
  std::size_t queue_bytes = std::size_t{256} << 20;  // between the two threads
};

struct TopicCounts {
  std::uint64_t messages = 0;  // put in the queue
  std::uint64_t bytes = 0;     // of their payloads
  std::uint64_t dropped = 0;   // because the queue was full, or the message too large
  std::uint64_t lost = 0;      // before they reached us, as far as the vendor knows
};

struct RecordingCounts {
  std::map<const TopicRow*, TopicCounts> topics;
  TopicCounts total() const;
};

class Recorder {
 public:
  // Opens the bus and creates the file. Throws std::runtime_error with one sentence.
  explicit Recorder(RecorderOptions options);
  // Without finish() the file stays unfinished, as after a kill.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Waits at most so long for samples and queues what has come.
  void poll(std::chrono::milliseconds timeout);
  // Returns whether the disk refused: finish() will say why.
  bool failed() const { return failed_.load(); }
  RecordingCounts counts() const;
  // Returns how many writers it hears now; what they said before it knew them is not in the recording.
  int writers() const;
  // Returns how many servers it has heard at one time; 0 while there is one, or none, or statuses are not recorded.
  std::size_t servers_at_once() const { return servers_.together(); }
  // Writes what is queued, the drop counts and the summary. Throws McapError if the disk refuses now or did before.
  void finish();

 private:
  struct Source {
    const TopicRow* topic;
    std::unique_ptr<RawReader> reader;
    TopicCounts counts;
    unsigned keep_every = 1;
    std::uint64_t seen = 0;
  };
  struct Record {
    std::size_t source;
    std::uint64_t log_time_ns;
    std::uint64_t publish_time_ns;
    Bytes payload;
  };
  void queue(Record record);
  bool wanted(Source& source, Payload payload) const;
  void write_loop();
  void write(const Record& record);
  void stop_writing();
  McapMetadata description() const;

  RecorderOptions options_;
  // log times go on from here by the monotonic clock: who sets the other one does not reorder or bunch them
  std::uint64_t start_time_ns_;
  std::int64_t started_ns_;
  std::unique_ptr<RawBus> bus_;
  McapWriter writer_;
  std::vector<Source> sources_;
  std::vector<Record> taken_;  // in one poll
  ServersHeard servers_;
  std::uint64_t last_log_time_ns_ = 0;

  std::mutex mutex_;  // of the queue
  std::condition_variable queue_filled_;
  std::deque<Record> queue_;
  std::size_t queued_bytes_ = 0;
  bool ending_ = false;

  // of the writing thread
  std::vector<std::uint16_t> channels_;  // by source; 0: not yet
  std::vector<std::uint32_t> sequences_;
  std::string failure_;
  std::atomic<bool> failed_ = false;
  std::thread thread_;
};

}  // namespace palp
