// A whole frame of particles, and how it is cut into chunks for the wire.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "idl/messages.h"

namespace palp {

struct ParticleFrame {
  std::uint64_t frame = 0;
  double sim_time = 0;  // [s]
  ScalarField field = ScalarField::none;
  std::vector<float> positions;     // [m], x y z per particle, in the order of the scene
  std::vector<float> scalars;       // one per particle, or empty
  std::vector<std::uint8_t> solid;  // how much of each is solid, in 255ths, or empty
  // known after receipt only:
  std::uint64_t session = 0;      // of the sender
  std::int64_t t_send_ns = 0;     // of the first chunk to arrive, on the sender's clock
  std::int64_t t_receive_ns = 0;  // of the last chunk, on this host's clock
};

// Returns the number of chunks of a frame: one at least, so that a scene of bodies without particles has frames, too.
constexpr std::uint32_t chunks_of(std::uint32_t particle_count) {
  return std::max(1u, particle_count / kChunkParticles + (particle_count % kChunkParticles != 0 ? 1 : 0));
}

// How many particles chunk number i of such a frame holds: kChunkParticles, the last one the rest. i < chunks_of(...).
constexpr std::uint32_t particles_in_chunk(std::uint32_t particle_count, std::uint32_t i) {
  return std::min(kChunkParticles, particle_count - i * kChunkParticles);
}

// Makes a chunk part i of a frame with these values, scalars and solid of one per particle or none; frame, sim_time and
// field are the caller's. Allocates only where the chunk's vectors are too small.
inline void fill_chunk(std::uint32_t i, std::span<const float> positions, std::span<const float> scalars,
                       std::span<const std::uint8_t> solid, ParticleChunk& chunk) {
  chunk.particle_count = static_cast<std::uint32_t>(positions.size() / 3);
  chunk.chunk_count = chunks_of(chunk.particle_count);
  chunk.chunk = i;
  chunk.first = i * kChunkParticles;
  const auto first = static_cast<std::ptrdiff_t>(chunk.first);
  const auto n = static_cast<std::ptrdiff_t>(particles_in_chunk(chunk.particle_count, i));
  chunk.positions.assign(positions.begin() + 3 * first, positions.begin() + 3 * (first + n));
  chunk.scalars.clear();
  if (!scalars.empty()) chunk.scalars.assign(scalars.begin() + first, scalars.begin() + first + n);
  chunk.solid.clear();
  if (!solid.empty()) chunk.solid.assign(solid.begin() + first, solid.begin() + first + n);
}

// Returns whether a chunk says consistently which part of its frame it is, and holds as many values as it says.
inline bool well_placed(const ParticleChunk& c) {
  if (c.chunk_count != chunks_of(c.particle_count) || c.chunk >= c.chunk_count) return false;
  const std::size_t n = particles_in_chunk(c.particle_count, c.chunk);
  return c.first == c.chunk * kChunkParticles && c.positions.size() == 3 * n &&
         c.scalars.size() == (c.field == ScalarField::none ? 0 : n) && (c.solid.empty() || c.solid.size() == n);
}

}  // namespace palp
