// Sorting by cell, neighbour lists, and the check whether they still hold.
#pragma once

#include "sim_server/backend/cuda_teams.cuh"
#include "sim_server/physics/particles.h"

namespace palp {

// Stable counting sort by cell in four kernels. Atomics hand out the slots of a cell in any order; each particle then
// finds its place among the slots of its cell by comparing indices, so that the result does not depend on that order.
static __global__ void count_cells(std::uint32_t n, const Packed* xV, CellGrid grid, std::uint32_t* cell,
                                   std::uint32_t* slot, std::uint32_t* count) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= n) return;
  cell[i] = grid.index_of(xV[i].xyz());
  slot[i] = atomicAdd(&count[cell[i]], 1u);
}

static __global__ void fill_slots(std::uint32_t n, const std::uint32_t* cell, const std::uint32_t* slot,
                                  const std::uint32_t* start, std::uint32_t* member) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < n) member[start[cell[i]] + slot[i]] = i;
}

static __global__ void reorder(std::uint32_t n, const std::uint32_t* cell, const std::uint32_t* start,
                               const std::uint32_t* member, ParticleView from, ParticleView to) {
  const std::uint32_t s = blockIdx.x * blockDim.x + threadIdx.x;
  if (s >= n) return;
  const std::uint32_t i = member[s], c = cell[i];
  std::uint32_t place = start[c];
  for (std::uint32_t t = start[c]; t < start[c + 1]; ++t) place += member[t] < i ? 1u : 0u;
  copy_particle(from, i, to, place);
}

// L lanes go through the cells around a particle side by side.
template <int L>
struct SearchTeam {
  PALP_HD int group() const { return 0; }
  PALP_HD int groups() const { return 1; }
};

// Lists the particles within reach, in the order of the cells, and remembers where the particles are.
template <int L, class Pair>
__global__ void __launch_bounds__(kTeamThreads)
    list_neighbors(std::uint32_t n, const Packed* xV, const Tag* tag, CellGrid grid, real reach, Pair interacts,
                   NeighborLists lists, Packed* listed_at) {
  const std::uint32_t t = blockIdx.x * kTeamThreads + threadIdx.x, i = t / L, lane = t % L;
  if (i >= n) return;
  const unsigned first = threadIdx.x % 32 / L * L;
  const unsigned team = L == 32 ? 0xffffffffu : ((1u << L) - 1u) << first, before = ((1u << lane) - 1u) << first;
  const Packed xV_i = xV[i];
  const Tag tag_i = tag[i];
  std::uint32_t count = 0;
  for_each_run(
      grid, xV_i.xyz(), reach, SearchTeam<L>{}, [&](std::uint32_t begin, std::uint32_t end, const Vec3& shift) {
        const Vec3 x = xV_i.xyz() - shift;
        for (; begin < end; begin += L) {
          const std::uint32_t j = begin + lane;
          const bool listed = j < end && (x - xV[j].xyz()).squaredNorm() < reach * reach && interacts(tag_i, tag[j]);
          const unsigned hits = __ballot_sync(team, listed);
          const std::uint32_t k = count + __popc(hits & before);
          if (listed && k < lists.room) lists.entry[lists.index(n, i, k)] = j;
          count += __popc(hits & team);
        }
      });
  if (lane > 0) return;
  if (count > lists.room) {
    atomicAdd(lists.crowded, 1u);
    count = lists.room;
  }
  lists.count[i] = count;
  listed_at[i] = xV_i;
}

// Moves the particles, copies what has changed to where the next sub-step looks for it, and asks for new lists when one
// has moved by half of the skin since they were made, or to nowhere.
template <class F>
__global__ void run_move(std::uint32_t n, F f, ParticleView state, ParticleView sorted, CellGrid grid, real skin,
                         const Packed* listed_at, cudaGraphConditionalHandle new_lists) {
  wait_for_work_in_front();
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  bool due = false;
  if (i < n) {
    f(i);
    const Packed xV = state.xV[i];
    sorted.xV[i] = xV;
    sorted.vp[i] = state.vp[i];
    due = !(real(4) * separation(grid, xV.xyz(), listed_at[i]).squaredNorm() < skin * skin);
  }
  if (__syncthreads_or(due) && threadIdx.x == 0) cudaGraphSetConditional(new_lists, 1);
}

}  // namespace palp
