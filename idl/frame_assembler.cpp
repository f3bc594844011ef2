#include "idl/frame_assembler.h"

#include <algorithm>

namespace palp {
namespace {

// Puts runs of values, stored in the order of arrival, in the order of their chunks.
template <class T>
void sort_runs(std::vector<T>& values, std::size_t width, const std::vector<std::uint32_t>& order,
               std::uint32_t particle_count, std::vector<T>& scratch) {
  scratch.resize(values.size());
  std::size_t from = 0;
  for (const std::uint32_t chunk : order) {
    const std::size_t n = width * particles_in_chunk(particle_count, chunk);
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(from), n,
                scratch.begin() + static_cast<std::ptrdiff_t>(width * chunk * kChunkParticles));
    from += n;
  }
  std::swap(values, scratch);
}

}  // namespace

bool FrameAssembler::add(const ParticleChunk& chunk, std::int64_t t_receive_ns) {
  if (!well_placed(chunk)) {
    ++counts_.refused;
    return false;
  }
  if (!follow_session(chunk)) {
    ++counts_.late;
    return false;
  }
  Open* open = open_for(chunk);
  if (!open) return false;

  if (open->seen[chunk.chunk]) {
    ++counts_.duplicate;
    return false;
  }
  open->touched = ++clock_;
  open->seen[chunk.chunk] = true;
  open->in_order = open->in_order && chunk.chunk == open->arrived;
  open->order.push_back(chunk.chunk);
  ++open->arrived;
  ParticleFrame& frame = open->frame;
  frame.positions.insert(frame.positions.end(), chunk.positions.begin(), chunk.positions.end());
  frame.scalars.insert(frame.scalars.end(), chunk.scalars.begin(), chunk.scalars.end());
  frame.solid.insert(frame.solid.end(), chunk.solid.begin(), chunk.solid.end());
  frame.t_receive_ns = t_receive_ns;
  if (open->arrived < chunk.chunk_count) return false;

  if (!open->in_order) sort(*open);
  std::swap(newest_, frame);
  open->used = false;
  newest_frame_ = newest_.frame;
  fresh_ = any_ = true;
  ++counts_.complete;
  for (Open& other : open_) {
    if (other.used && other.frame.frame < newest_frame_) give_up(other);
  }
  return true;
}

bool FrameAssembler::take(ParticleFrame& out) {
  if (!fresh_) return false;
  fresh_ = false;
  std::swap(out, newest_);
  return true;
}

// False if the chunk is of a session that a newer one replaced.
bool FrameAssembler::follow_session(const ParticleChunk& chunk) {
  const std::uint64_t session = chunk.header.session;
  if (session != session_) {
    if (std::find(past_sessions_.begin(), past_sessions_.end(), session) != past_sessions_.end()) return false;
    past_sessions_[next_past_++ % kPastSessions] = session_;
    session_ = session;
    restart();
  }
  if (any_ && chunk.frame < newest_frame_ && newest_frame_ - chunk.frame > kRestart) restart();
  return true;
}

// The open frame of this chunk, begun if need be. Null, and counted, if the chunk is too late or contradicts its frame.
FrameAssembler::Open* FrameAssembler::open_for(const ParticleChunk& chunk) {
  if (any_ && chunk.frame <= newest_frame_) {
    ++counts_.late;
    return nullptr;
  }
  Open* place = nullptr;
  for (Open& open : open_) {
    if (open.used && open.frame.frame == chunk.frame) {
      const bool fits = open.particle_count == chunk.particle_count && open.frame.field == chunk.field &&
                        open.frame.sim_time == chunk.sim_time && open.with_solid == !chunk.solid.empty();
      if (!fits) ++counts_.refused;
      return fits ? &open : nullptr;
    }
    // the best place is a free one, else the one that was silent longest: the highest frame numbers must not be able to
    // hold all places for ever
    if (!place || (place->used && (!open.used || open.touched < place->touched))) place = &open;
  }
  if (place->used) give_up(*place);
  begin(*place, chunk);
  return place;
}

void FrameAssembler::begin(Open& open, const ParticleChunk& chunk) {
  open.used = true;
  open.particle_count = chunk.particle_count;
  open.with_solid = !chunk.solid.empty();
  open.arrived = 0;
  open.in_order = true;
  open.order.clear();
  open.seen.assign(chunk.chunk_count, false);
  ParticleFrame& frame = open.frame;
  frame.frame = chunk.frame;
  frame.sim_time = chunk.sim_time;
  frame.field = chunk.field;
  frame.positions.clear();
  frame.scalars.clear();
  frame.solid.clear();
  frame.session = chunk.header.session;
  frame.t_send_ns = chunk.header.t_send_ns;
}

void FrameAssembler::sort(Open& open) {
  sort_runs(open.frame.positions, 3, open.order, open.particle_count, scratch_);
  if (open.frame.field != ScalarField::none) {
    sort_runs(open.frame.scalars, 1, open.order, open.particle_count, scratch_);
  }
  if (open.with_solid) sort_runs(open.frame.solid, 1, open.order, open.particle_count, scratch_bytes_);
}

void FrameAssembler::give_up(Open& open) {
  open.used = false;
  ++counts_.incomplete;
}

void FrameAssembler::restart() {
  for (Open& open : open_) {
    if (open.used) give_up(open);
  }
  any_ = false;
  newest_frame_ = 0;
}

}  // namespace palp
