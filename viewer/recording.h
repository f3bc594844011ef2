// A recording that is open for playing: its index, and any state of it, read from the file when it is asked for.
#pragma once

#include <algorithm>
#include <cstddef>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "idl/cdr.h"
#include "idl/particle_frame.h"
#include "viewer/recording_index.h"

namespace palp {

// One thread.
class Recording {
 public:
  // Throws McapError with one sentence when nothing can be shown of the file.
  explicit Recording(const std::string& file);

  const RecordingIndex& index() const { return index_; }
  // Returns the place in index().frames of the newest frame at that time [s] of playing, the first one before it.
  std::size_t frame_at(double time) const;
  // Returns a frame of index().frames; null when the file has changed since it was opened.
  std::shared_ptr<const ParticleFrame> frame(std::size_t i);
  // Returns the sample at that place; nothing when the file has changed.
  template <class T>
  std::optional<T> sample(SamplePlace place) {
    T out;
    if (from_cdr(payload(place), out) != Fault::none) return std::nullopt;
    return out;
  }

 private:
  ByteView payload(SamplePlace place);  // valid until the next call; empty: it cannot be read

  McapReader reader_;
  RecordingIndex index_;
  std::list<std::pair<std::uint32_t, McapChunkContent>> chunks_;  // unpacked, the one used last in front
  std::list<std::pair<std::size_t, std::shared_ptr<const ParticleFrame>>> frames_;  // likewise
};

// Returns the newest of samples that are ordered by time, at `time` or before it; the end where there is none.
template <class Samples>
auto newest_at(const Samples& samples, double time) {
  const auto after = std::upper_bound(samples.begin(), samples.end(), time,
                                      [](double t, const auto& sample) { return t < sample.time; });
  return after == samples.begin() ? samples.end() : after - 1;
}

}  // namespace palp
