// The index of a recording: what it holds and where, laid out along the time that it is played in.
//
// That time is simulated time [s]. Where the simulation was paused it stands still, too; where it began anew, by a
// reset or as another server, it goes on from where the run before ended.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "idl/mcap/mcap_reader.h"
#include "idl/messages.h"

namespace palp {

// Where a sample stands: the chunk, by its place in RecordingIndex::chunks, and which message of it.
struct SamplePlace {
  std::uint32_t chunk = 0, message = 0;
};

struct TimedSample {
  double time = 0;  // [s] of playing
  SamplePlace place;
  std::uint32_t run = 0;  // in RecordingIndex::runs; of what a process says of itself: 0
};

struct TimedEvent {
  double time = 0;  // [s] of playing
  Event event;
};

// One server's simulation, from its start or a reset to its end or the next reset.
struct RecordedRun {
  std::uint64_t session = 0;
  double first = 0, last = 0;  // [s] of playing
  double offset = 0;           // [s] time of playing minus simulated time
  std::shared_ptr<const SceneDescription> scene;
};

// A frame of particles of which all chunks are there.
struct RecordedFrame {
  double time = 0;                      // [s] of playing
  std::uint32_t run = 0;                // in RecordingIndex::runs
  std::uint32_t first = 0, chunks = 0;  // its places in RecordingIndex::frame_places
};

struct RecordingIndex {
  std::vector<std::uint64_t> chunks;  // bytes of the file at which they stand
  std::vector<RecordedRun> runs;
  std::vector<RecordedFrame> frames;  // by time, as all that follows
  std::vector<SamplePlace> frame_places;
  std::vector<TimedSample> poses;
  std::array<std::vector<TimedSample>, kMaxDevices> proxies;
  std::vector<TimedSample> statuses;
  std::vector<TimedEvent> events;

  std::uint64_t lost_frames = 0;     // of which chunks are missing
  std::uint64_t refused = 0;         // samples that were malformed or of another protocol version
  std::vector<std::string> remarks;  // what could not be read, one sentence each
};

// Reads the whole file once. What is damaged is left out and told of in remarks. Throws McapError with one sentence
// when nothing can be shown of it.
RecordingIndex index_recording(const McapReader& reader);

}  // namespace palp
