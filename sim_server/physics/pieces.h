// Pieces: the connected components of matter that changes state, which are the bodies that merge and split (paper 3.2).
// A particle belongs to one while it is mostly solid; two belong to the same one when a chain of bonds between solid
// particles joins them.
//
// symbol   meaning
// id       number of a piece: the least slot in it
// b        by slot: the least slot of the same piece that is known so far; it only falls while a numbering lasts
// a        b[b], from the round before
//
// In a round each slot takes the least a of itself and of its partners, and hands it on to the slot a, whose number all
// slots that point there read next (FastSV: Zhang, Azad & Hu 2020). So the number of rounds grows as the logarithm of
// the longest chain. Where bonds end, only a numbering from the start finds that a piece has split, so each begins with
// every slot on its own. A numbering that has not ended after kPieceRounds goes on at the next change; until then ids
// stay as they were, but for matter that has melted.
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
  std::uint32_t* a = nullptr;          // by slot
  std::uint32_t* b = nullptr;          // by slot
  std::uint32_t* converged = nullptr;  // by round: 1 where it changed nothing
};

// Sets *at to the least of itself and of the values that all threads bring; their order does not matter.
PALP_HD inline void atomic_min(std::uint32_t* at, std::uint32_t value) {
#ifdef __CUDA_ARCH__
  atomicMin(at, value);
#else
  const std::atomic_ref<std::uint32_t> shared(*at);
  std::uint32_t now = shared.load(std::memory_order_relaxed);
  while (value < now && !shared.compare_exchange_weak(now, value, std::memory_order_relaxed)) {
  }
#endif
}

// Begins a numbering, or goes on with one that has not ended; one thread a slot.
struct BeginPieces {
  ChangeViews change;
  PieceViews pieces;

  PALP_HD void operator()(std::uint32_t k) const {
    if (pieces.converged[kPieceRounds - 1] == 0) return;
    pieces.a[k] = pieces.b[k] = change.solid[k] > kPieceSolid ? k : kNone;
  }
};

// Marks all rounds as converged, after BeginPieces; one thread a round.
struct BeginRounds {
  PieceViews pieces;
  PALP_HD void operator()(std::uint32_t round) const { pieces.converged[round] = 1; }
};

// Takes the least number of a slot and its partners; one thread a slot.
struct JoinPieces {
  ChangeViews change;
  PieceViews pieces;
  std::uint32_t round;

  PALP_HD void operator()(std::uint32_t k) const {
    if (round > 0 && pieces.converged[round - 1] != 0) return;
    const std::uint32_t mine = pieces.a[k];
    if (mine == kNone || !(change.solid[k] > kPieceSolid)) return;
    const std::size_t row = std::size_t(k) * kMaxBonds;
    std::uint32_t lowest = mine;
    for (std::uint32_t n = 0; n < change.bonds[k]; ++n) {
      const std::uint32_t j = change.bond[row + n];
      if (change.solid[j] > kPieceSolid && pieces.a[j] < lowest) lowest = pieces.a[j];
    }
    atomic_min(pieces.b + k, lowest);
    if (lowest == mine) return;
    atomic_min(pieces.b + mine, lowest);
    atomic_min(pieces.converged + round, 0);
  }
};

// Goes on to the number of one's number (pointer jumping); one thread a slot.
struct JumpPieces {
  PieceViews pieces;
  std::uint32_t round;

  PALP_HD void operator()(std::uint32_t k) const {
    if (pieces.converged[round] != 0 || pieces.b[k] == kNone) return;
    pieces.a[k] = pieces.b[pieces.b[k]];
  }
};

// Writes the ids after the last round; one thread a slot.
struct NamePieces {
  ChangeViews change;
  PieceViews pieces;

  PALP_HD void operator()(std::uint32_t k) const {
    if (!(change.solid[k] > kPieceSolid))
      change.piece[k] = kNone;
    else if (pieces.converged[kPieceRounds - 1] != 0)
      change.piece[k] = pieces.a[k];
  }
};

// Makes forces use the pieces that the last change found, which has given those that it joined their bonds; one thread
// a particle.
struct ApplyPieces {
  ParticleView state;
  ChangeViews change;

  PALP_HD void operator()(std::uint32_t i) const {
    const std::uint32_t k = slot_of(change, state.tag[i], state.id[i]);
    if (k == kNone) return;
    change.acting[k] = state.solid[i].piece = change.piece[k];
  }
};

}  // namespace palp
