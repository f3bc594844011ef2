// Plays a recording back onto the bus: the same bytes in the same order, at the pace at which they were recorded,
// faster, slower, or in steps that someone asks for.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "idl/mcap/mcap_reader.h"
#include "tools/recording/raw_bus.h"

namespace palp {

enum class Step { none, message, time };

struct ReplayOptions {
  BusOptions bus;
  std::string path;
  std::vector<const TopicRow*> topics;
  double rate = 1;         // of the original pace; 0: without any pause
  Step step = Step::none;  // wait_for_step before every message, or before every haptic step
  bool loop = false;
  int wait_readers = 1;      // so many readers, over all topics, must be there before the first message
  double wait_seconds = 10;  // for them
};

struct ReplayCounts {
  std::uint64_t messages = 0;
  std::uint64_t refused = 0;  // by the vendor
  std::uint64_t rounds = 0;
  std::uint64_t lost_chunks = 0;    // damaged ones, left out
  std::uint64_t lost_messages = 0;  // in these, by the index; counted when a round has ended
  double lateness_p50_us = 0;       // behind the recording's pace
  double lateness_p99_us = 0;
  double lateness_max_us = 0;
};

// The replay asks its caller through these.
struct ReplayHooks {
  std::function<bool()> stop;           // true: end as soon as possible
  std::function<bool()> wait_for_step;  // returns when the next step is wanted; false: end
  // Gets one sentence for each damaged chunk, before what follows it is played.
  std::function<void(const std::string&)> on_damage;
};

// Goes on behind a damaged chunk. Throws McapError for a recording without an index, std::runtime_error when the bus
// cannot be opened, no chosen topic is in the file, a channel is not of palp's types, or the readers do not come.
ReplayCounts replay(const ReplayOptions& options, const ReplayHooks& hooks);

}  // namespace palp
