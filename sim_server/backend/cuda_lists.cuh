// Sorting by cell, neighbour lists, and the check whether they still hold.
#pragma once

#include <cooperative_groups.h>

#include <cub/block/block_reduce.cuh>
#include <cub/block/block_scan.cuh>

#include "sim_server/backend/cuda_teams.cuh"
#include "sim_server/physics/outside.h"

namespace palp {

// The arrays with which particles are sorted and listed.
struct ListWork {
  std::uint32_t n = 0;
  ParticleView from, to;
  CellGrid grid;
  real reach = 0;                                                     // support radius and skin of the lists [m]
  std::uint32_t *cell = nullptr, *slot = nullptr, *member = nullptr;  // per particle
  std::uint32_t *count = nullptr, *start = nullptr, *part = nullptr;  // per cell; per block
  Packed* listed_at = nullptr;                                        // positions that the lists are for
  std::uint32_t* due = nullptr;                                       // not zero when lists have to be made anew
  DeviceLists lists;
};

inline constexpr int kListThreads = 256;

// Returns the number of entries of the cells' arrays: each cell, that of inactive particles, and the end.
__device__ inline std::uint32_t cell_entries(const ListWork& w) { return w.grid.cells() + 2; }

// Calls f(item) for a thread's share of count items.
template <class F>
__device__ inline void for_share(std::uint32_t count, F&& f) {
  for (std::uint32_t i = blockIdx.x * kListThreads + threadIdx.x; i < count; i += gridDim.x * kListThreads) f(i);
}

// Computes the start of each cell: each block adds up a part of the cells, then numbers them, after it has read the
// sums of the parts before.
__device__ inline void number_cells(const ListWork& w, const cooperative_groups::grid_group& all) {
  using Reduce = cub::BlockReduce<std::uint32_t, kListThreads>;
  using Scan = cub::BlockScan<std::uint32_t, kListThreads>;
  __shared__ union {
    typename Reduce::TempStorage reduce;
    typename Scan::TempStorage scan;
  } memory;
  const std::uint32_t cells = cell_entries(w);
  const std::uint32_t share = (cells + gridDim.x - 1) / gridDim.x, begin = min(cells, blockIdx.x * share),
                      end = min(cells, begin + share);
  std::uint32_t sum = 0;
  for (std::uint32_t c = begin + threadIdx.x; c < end; c += kListThreads) sum += w.count[c];
  sum = Reduce(memory.reduce).Sum(sum);
  if (threadIdx.x == 0) w.part[blockIdx.x] = sum;
  all.sync();
  __shared__ std::uint32_t before;
  sum = 0;
  for (std::uint32_t b = threadIdx.x; b < blockIdx.x; b += kListThreads) sum += w.part[b];
  sum = Reduce(memory.reduce).Sum(sum);
  if (threadIdx.x == 0) before = sum;
  __syncthreads();
  std::uint32_t next = before;
  for (std::uint32_t c = begin; c < end; c += kListThreads) {
    std::uint32_t value = c + threadIdx.x < end ? w.count[c + threadIdx.x] : 0, total = 0;
    Scan(memory.scan).ExclusiveSum(value, value, total);
    if (c + threadIdx.x < end) w.start[c + threadIdx.x] = next + value;
    next += total;
    __syncthreads();
  }
}

// Sorts the particles by cell, by a stable counting sort. Atomics hand out the slots of a cell in any order; each
// particle then finds its place among the slots of its cell by comparing indices, so that the result does not depend on
// that order.
__device__ inline void sort_particles(const ListWork& w, const cooperative_groups::grid_group& all) {
  for_share(cell_entries(w), [&](std::uint32_t c) { w.count[c] = 0; });
  all.sync();
  for_share(w.n, [&](std::uint32_t i) {
    w.cell[i] = sort_cell(w.grid, w.from.tag[i], w.from.xV[i]);
    w.slot[i] = atomicAdd(&w.count[w.cell[i]], 1u);
  });
  all.sync();
  number_cells(w, all);
  all.sync();
  for_share(w.n, [&](std::uint32_t i) { w.member[w.start[w.cell[i]] + w.slot[i]] = i; });
  all.sync();
  for_share(w.n, [&](std::uint32_t s) {
    const std::uint32_t i = w.member[s], c = w.cell[i], begin = w.start[c], end = w.start[c + 1];
    std::uint32_t place = begin;
    for (std::uint32_t t = begin; t < end; ++t) place += w.member[t] < i ? 1u : 0u;
    copy_particle(w.from, i, w.to, place);
    w.listed_at[place] = w.from.xV[i];
  });
}

// The team of a search: each lane goes through all the rows of cells around a particle.
struct SearchTeam {
  PALP_HD int group() const { return 0; }
  PALP_HD int groups() const { return 1; }
};

// Returns all four, by one load, of a value that this kernel itself may have written.
__device__ inline Packed fetch_written(const Packed* p) {
  Packed v;
  asm volatile("ld.global.v4.f32 {%0, %1, %2, %3}, [%4];" : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w) : "l"(p));
  return v;
}

// Writes the list of a particle by one thread for a team of four that reads it: four entries lie side by side and are
// written at once.
struct FourWriter {
  const ListWork& w;
  std::uint32_t i, count = 0;
  uint4 last{};

  __device__ void put(std::uint32_t j) {
    last = {last.y, last.z, last.w, j};
    ++count;
    if (count % 4 == 0 && count <= w.lists.room)
      *reinterpret_cast<uint4*>(&w.lists.entry[w.lists.index(w.n, i, count - 4)]) = last;
  }
  // Fills up the last four and returns the number listed.
  __device__ std::uint32_t finish() {
    const std::uint32_t listed = count;
    while (count % 4 != 0) put(0);
    return listed;
  }
};

// Lists the particles within reach of particle i by one thread, in the order of the cells, and returns their number.
template <class Pair>
__device__ inline std::uint32_t list_by_thread(const ListWork& w, std::uint32_t i, const Pair& interacts) {
  const Vec3 x_i = w.to.xV[i].xyz();
  const Tag tag_i = w.to.tag[i];
  const auto clear = interacts.clear_around(tag_i, x_i);
  FourWriter writer{w, i};
  for_each_run(w.grid, x_i, w.reach, SearchTeam{}, [&](std::uint32_t begin, std::uint32_t end, const Vec3& shift) {
    const Vec3 x = x_i - shift;
    for (std::uint32_t j = begin; j < end; ++j) {
      const Vec3 x_ij = x - fetch_written(w.to.xV + j).xyz();
      const Tag tag_j = w.to.tag[j];
      if (x_ij.squaredNorm() < w.reach * w.reach && interacts(tag_i, tag_j) &&
          interacts.in_sight(tag_j, x_i, x_ij, clear))
        writer.put(j);
    }
  });
  return writer.finish();
}

// The lanes that search for one particle's neighbours together.
inline constexpr int kSearchLanes = 8;

// Lists the same by kSearchLanes lanes that go through a run of particles side by side.
template <class Pair>
__device__ inline std::uint32_t list_by_lanes(const ListWork& w, std::uint32_t i, const Pair& interacts) {
  const std::uint32_t lane = threadIdx.x % kSearchLanes, first = threadIdx.x % 32 - lane;
  const unsigned team = ((1u << kSearchLanes) - 1u) << first, before = ((1u << lane) - 1u) << first;
  const Vec3 x_i = w.to.xV[i].xyz();
  const Tag tag_i = w.to.tag[i];
  const auto clear = interacts.clear_around(tag_i, x_i);
  std::uint32_t count = 0;
  for_each_run(w.grid, x_i, w.reach, SearchTeam{}, [&](std::uint32_t begin, std::uint32_t end, const Vec3& shift) {
    const Vec3 x = x_i - shift;
    for (; begin < end; begin += kSearchLanes) {
      const std::uint32_t j = begin + lane;
      bool listed = false;
      if (j < end) {
        const Vec3 x_ij = x - fetch_written(w.to.xV + j).xyz();
        const Tag tag_j = w.to.tag[j];
        listed = x_ij.squaredNorm() < w.reach * w.reach && interacts(tag_i, tag_j) &&
                 interacts.in_sight(tag_j, x_i, x_ij, clear);
      }
      const unsigned hits = __ballot_sync(team, listed);
      const std::uint32_t k = count + __popc(hits & before);
      count += __popc(hits & team);
      if (listed && k < w.lists.room) w.lists.entry[w.lists.index(w.n, i, k)] = j;
    }
  });
  return count;
}

// Sorts the particles and lists their neighbours if that is due. What lasts of them is put back into the state, and all
// of what sleeps, which needs no list: no stage does that. One kernel, whose blocks all run at once and wait for
// each other: one that finds nothing to do costs 1.6 us, a conditional node that is not taken 4.5 (tools/results).
template <bool kOneThread, class Pair>
__global__ void __launch_bounds__(kListThreads) rebuild_lists(ListWork w, Pair interacts) {
  wait_for_previous_kernel();
  if (*w.due == 0) return;
  const cooperative_groups::grid_group all = cooperative_groups::this_grid();
  sort_particles(w, all);
  all.sync();
  for_share(w.n, [&](std::uint32_t i) { copy_lasting(w.to, i, w.from, i); });
  if (blockIdx.x == 0 && threadIdx.x == 0) *w.due = 0;
  constexpr std::uint32_t kLanes = kOneThread ? 1 : kSearchLanes, kAtOnce = kListThreads / kLanes;
  for (std::uint32_t i = blockIdx.x * kAtOnce + threadIdx.x / kLanes; i < w.n; i += gridDim.x * kAtOnce) {
    std::uint32_t count = 0;
    if (w.to.tag[i].inactive() || w.to.tag[i].asleep()) {
      if (threadIdx.x % kLanes == 0) w.lists.count[i] = 0;
      if (threadIdx.x % kLanes == 0 && w.to.tag[i].asleep()) copy_particle(w.to, i, w.from, i);
      continue;
    }
    if constexpr (kOneThread)
      count = list_by_thread(w, i, interacts);
    else
      count = list_by_lanes(w, i, interacts);
    if (threadIdx.x % kLanes > 0) continue;
    w.lists.count[i] = min(count, w.lists.room);
    if (count > w.lists.room) atomicAdd(w.lists.neighbor_overflow, 1u);
  }
}

// Moves the particles, copies what has changed to where the next sub-step looks for it, and asks for new lists when one
// has moved by half of the skin since they were made, or to nowhere.
template <class F>
__global__ void run_move(F f, ListWork w, real skin) {
  wait_for_previous_kernel();
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  bool due = false;
  if (i < w.n && !w.lists.asleep(i)) {
    f(i);
    copy_changing(w.from, i, w.to, i);
    due = !(real(4) * separation(w.grid, w.from.xV[i].xyz(), w.listed_at[i]).squaredNorm() < skin * skin);
  }
  if (__syncthreads_or(due) && threadIdx.x == 0) *w.due = 1;
}

}  // namespace palp
