#include "viewer/recording.h"

#include <algorithm>

#include <spdlog/spdlog.h>

namespace palp {
namespace {

constexpr std::size_t kMostChunks = 8;  // kept unpacked: those of particles and of the rest around the time shown
constexpr std::size_t kMostFrames = 3;

// Moves the element with that key to the front and returns it; null if there is none.
template <class List, class Key>
auto* look_up(List& list, const Key& key) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const auto& entry) { return entry.first == key; });
  if (found == list.end()) return static_cast<decltype(&list.front().second)>(nullptr);
  list.splice(list.begin(), list, found);
  return &list.front().second;
}

}  // namespace

Recording::Recording(const std::string& file) : reader_(file), index_(index_recording(reader_)) {}

std::size_t Recording::frame_at(double time) const {
  const auto found = newest_at(index_.frames, time);
  return found == index_.frames.end() ? 0 : static_cast<std::size_t>(found - index_.frames.begin());
}

ByteView Recording::payload(SamplePlace place) {
  const McapChunkContent* content = look_up(chunks_, place.chunk);
  if (content == nullptr) {
    try {
      chunks_.emplace_front(place.chunk, reader_.read_chunk(index_.chunks[place.chunk]));
    } catch (const McapError& error) {
      spdlog::error("{}", error.what());
      return {};
    }
    if (chunks_.size() > kMostChunks) chunks_.pop_back();
    content = &chunks_.front().second;
  }
  return place.message < content->messages.size() ? content->messages[place.message].data : ByteView{};
}

std::shared_ptr<const ParticleFrame> Recording::frame(std::size_t i) {
  if (const auto* known = look_up(frames_, i)) return *known;
  const RecordedFrame& recorded = index_.frames[i];
  auto out = std::make_shared<ParticleFrame>();
  for (std::uint32_t k = 0; k < recorded.chunks; ++k) {
    const auto chunk = sample<ParticleChunk>(index_.frame_places[recorded.first + k]);
    if (!chunk || chunk->chunk != k) return nullptr;
    if (k == 0) {
      out->frame = chunk->frame;
      out->sim_time = chunk->sim_time;
      out->field = chunk->field;
      out->session = chunk->header.session;
    }
    if (chunk->field != out->field) return nullptr;
    out->positions.insert(out->positions.end(), chunk->positions.begin(), chunk->positions.end());
    out->scalars.insert(out->scalars.end(), chunk->scalars.begin(), chunk->scalars.end());
    out->solid.insert(out->solid.end(), chunk->solid.begin(), chunk->solid.end());
  }
  if (3 * out->solid.size() != out->positions.size()) out->solid.clear();
  frames_.emplace_front(i, out);
  if (frames_.size() > kMostFrames) frames_.pop_back();
  return out;
}

}  // namespace palp
