// Which particles of what changes state hang together: pieces, the bodies that merge and split (paper 3.2). A particle
// belongs to one while it is mostly solid; two belong to the same one when a chain of bonds between such joins them.
//
// symbol   meaning
// id       of a piece: the least slot in it
// b        by slot: a slot of the same piece that is no greater, as far as is known; only falls while a numbering lasts
// a        b[b], from the round before
//
// A round: each slot takes the least a of itself and of its partners, and hands it on to the slot a, at whose number
// all that point there look next (FastSV: Zhang, Azad & Hu 2020). So the rounds that it takes grow as the logarithm of
// the longest chain. As bonds end, a piece can only be found to have split from the start, so each numbering begins
// with every slot on its own. What has not ended after kPieceRounds goes on at the next change; until then ids stay as
// they were, but for what has melted.
#pragma once

#include <atomic>

#include "sim_server/physics/state_change.h"

namespace palp {

// In random order, a lump of 27,000 particles takes one change, a chain of 10,000 two, one of 100,000 three
// (tests/sim_server/physics/pieces_test.cpp).
inline constexpr std::uint32_t kPieceRounds = 8;

// Solid fraction above which a particle counts as solid.
inline constexpr real kPieceSolid = real(0.5);

struct PieceViews {
  std::uint32_t* a = nullptr;      // by slot
  std::uint32_t* b = nullptr;      // by slot
  std::uint32_t* still = nullptr;  // by round: whether it changed nothing
};

// *at becomes the least of itself and of what any thread brings, the same whatever their order.
PALP_HD inline void lower(std::uint32_t* at, std::uint32_t value) {
#ifdef __CUDA_ARCH__
  atomicMin(at, value);
#else
  const std::atomic_ref<std::uint32_t> shared(*at);
  std::uint32_t now = shared.load(std::memory_order_relaxed);
  while (value < now && !shared.compare_exchange_weak(now, value, std::memory_order_relaxed)) {
  }
#endif
}

// Begins a numbering, or goes on with one that has not ended. Over the slots.
struct BeginPieces {
  ChangeViews change;
  PieceViews pieces;

  PALP_HD void operator()(std::uint32_t k) const {
    if (pieces.still[kPieceRounds - 1] == 0) return;
    pieces.a[k] = pieces.b[k] = change.solid[k] > kPieceSolid ? k : kNone;
  }
};

// Over the rounds, once the numbering has begun.
struct BeginRounds {
  PieceViews pieces;
  PALP_HD void operator()(std::uint32_t round) const { pieces.still[round] = 1; }
};

// Over the slots.
struct JoinPieces {
  ChangeViews change;
  PieceViews pieces;
  std::uint32_t round;

  PALP_HD void operator()(std::uint32_t k) const {
    if (round > 0 && pieces.still[round - 1] != 0) return;
    const std::uint32_t mine = pieces.a[k];
    if (mine == kNone || !(change.solid[k] > kPieceSolid)) return;
    const std::size_t row = std::size_t(k) * kMaxBonds;
    std::uint32_t least = mine;
    for (std::uint32_t n = 0; n < change.bonds[k]; ++n) {
      const std::uint32_t j = change.bond[row + n];
      if (change.solid[j] > kPieceSolid && pieces.a[j] < least) least = pieces.a[j];
    }
    lower(pieces.b + k, least);
    if (least == mine) return;
    lower(pieces.b + mine, least);
    lower(pieces.still + round, 0);
  }
};

// Over the slots.
struct JumpPieces {
  PieceViews pieces;
  std::uint32_t round;

  PALP_HD void operator()(std::uint32_t k) const {
    if (pieces.still[round] != 0 || pieces.b[k] == kNone) return;
    pieces.a[k] = pieces.b[pieces.b[k]];
  }
};

// Over the slots, after the last round.
struct NamePieces {
  ChangeViews change;
  PieceViews pieces;

  PALP_HD void operator()(std::uint32_t k) const {
    if (!(change.solid[k] > kPieceSolid))
      change.piece[k] = kNone;
    else if (pieces.still[kPieceRounds - 1] != 0)
      change.piece[k] = pieces.a[k];
  }
};

// From now on forces go by what the last change found; what it joined has its bonds by then. Over the particles.
struct ActPieces {
  ParticleView state;
  ChangeViews change;

  PALP_HD void operator()(std::uint32_t i) const {
    const std::uint32_t k = slot_of(change, state.tag[i], state.id[i]);
    if (k == kNone) return;
    change.acting[k] = state.solid[i].piece = change.piece[k];
  }
};

}  // namespace palp
