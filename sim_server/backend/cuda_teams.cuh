// The GPU's division of work: the teams that the physics' functors see, and the kernels that call them.
#pragma once

#include "sim_server/physics/cell_grid.h"
#include "sim_server/physics/particles.h"

namespace palp {

// Waits until the work in front has ended: a kernel may be started before that (Cuda::launch). Nothing that work in
// front writes may be touched before this.
PALP_HD inline void wait_for_previous_kernel() {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 900
  cudaGridDependencySynchronize();
#endif
}

// The neighbours of each particle within the support radius and a skin, listed once for many sub-steps. Of the
// candidates that a warp tests together few are in reach; a pass that worked on them while it searched would do each
// one's work with most lanes idle. The lanes of a particle's team take its neighbours in turns. Neighbouring lanes'
// entries lie side by side, so a lane's next entry is a lane of every particle further on.
struct DeviceLists {
  std::uint32_t* entry = nullptr;
  std::uint32_t* count = nullptr;              // per particle
  std::uint32_t* neighbor_overflow = nullptr;  // in the host's memory: times that a particle had more than room
  std::uint32_t room = 0;                      // entries per particle
  std::uint32_t lanes = 1;                     // lanes per particle, a power of two
  const Tag* tag = nullptr;                    // of the particles as they are sorted; null where none may sleep

  PALP_HD bool asleep(std::uint32_t i) const { return tag != nullptr && tag[i].asleep(); }

  PALP_HD std::size_t index(std::uint32_t n, std::uint32_t i, std::uint32_t k) const {
    return (std::size_t(k / lanes) * n + i) * lanes + k % lanes;
  }
};

// A team of L neighbouring lanes of a warp that share one particle's list.
template <int L>
struct LaneTeam {
  using Real = real;
  const std::uint32_t* list;  // this lane's first entry
  std::uint32_t count;        // number of the whole team's entries
  std::size_t stride;
  PALP_HD std::uint32_t member() const {
#ifdef __CUDA_ARCH__
    return threadIdx.x % L;
#else
    return 0;
#endif
  }
  PALP_HD bool leader() const { return member() == 0; }
  template <class Op>
  PALP_HD real reduce(real value, Op op) const {
#ifdef __CUDA_ARCH__
    const unsigned mask = L == 32 ? 0xffffffffu : ((1u << L) - 1u) << (threadIdx.x % 32 / L * L);
    for (int step = L / 2; step > 0; step /= 2) value = op(value, __shfl_xor_sync(mask, value, step, L));
#endif
    return value;
  }
  PALP_HD real sum(real value) const {
    return reduce(value, [](real a, real b) { return a + b; });
  }
  PALP_HD Vec3 sum(const Vec3& v) const { return {sum(v.x()), sum(v.y()), sum(v.z())}; }
  PALP_HD real max(real value) const {
    return reduce(value, [](real a, real b) { return a < b ? b : a; });
  }
};

// As for_neighbors(), in a domain with periodic axes or without.
template <bool kPeriodic, int L, class F>
PALP_HD inline void for_listed(const CellGrid& g, const Packed* xV, const Vec3& x_i, real support, LaneTeam<L> team,
                               F&& f) {
  const real support2 = support * support;
  // adding and taking away this number rounds to a whole one: the nearest image without branches
  constexpr real kRound = real(12582912);
  Vec3 inv_period;
  for (int a = 0; a < 3; ++a) inv_period[a] = g.periodic(a) ? real(1) / g.period[a] : real(0);
  // an entry is read a round ahead of its use, so that a round waits for one gather less
  const std::uint32_t* entry = team.list;
  std::uint32_t next = team.member() < team.count ? *entry : 0;
  for (std::uint32_t k = team.member(); k < team.count; k += L) {
    const std::uint32_t j = next;
    entry += team.stride;
    if (k + L < team.count) next = *entry;
    const Packed xV_j = fetch(xV, j);
    Vec3 d = x_i - xV_j.xyz();
    if constexpr (kPeriodic)
      for (int a = 0; a < 3; ++a) d[a] -= g.period[a] * ((d[a] * inv_period[a] + kRound) - kRound);
    const real r2 = d.squaredNorm();
    if (r2 < support2) f(j, xV_j, d, r2);
  }
}

template <int L, class F>
PALP_HD inline void for_neighbors(const CellGrid& g, const Packed* xV, const Vec3& x_i, real support, LaneTeam<L> team,
                                  F&& f) {
  if (g.periodic(0) || g.periodic(1) || g.periodic(2))
    for_listed<true>(g, xV, x_i, support, team, f);
  else
    for_listed<false>(g, xV, x_i, support, team, f);
}

// A team of L neighbouring lanes of a warp that share one item.
template <int L>
struct GroupTeam {
  PALP_HD std::uint32_t lane() const { return LaneTeam<L>{}.member(); }
  PALP_HD std::uint32_t size() const { return L; }
  PALP_HD bool leader() const { return lane() == 0; }
  PALP_HD real sum(real value) const { return LaneTeam<L>{}.sum(value); }
  PALP_HD Vec3 sum(const Vec3& v) const { return LaneTeam<L>{}.sum(v); }
};

// A team of all threads of a block, which share one item.
template <int kThreads>
struct BlockTeam {
  PALP_HD std::uint32_t lane() const {
#ifdef __CUDA_ARCH__
    return threadIdx.x;
#else
    return 0;
#endif
  }
  PALP_HD std::uint32_t size() const { return kThreads; }
  PALP_HD bool leader() const { return lane() == 0; }
  // Combines in a fixed order, so that the same input gives the same bits.
  template <class T, class Op>
  PALP_HD T reduce(T value, Op op) const {
#ifdef __CUDA_ARCH__
    constexpr int kWarps = kThreads / 32;
    __shared__ T part[kWarps];
    for (int step = 16; step > 0; step /= 2) value = op(value, __shfl_xor_sync(0xffffffffu, value, step));
    __syncthreads();
    if (threadIdx.x % 32 == 0) part[threadIdx.x / 32] = value;
    __syncthreads();
    value = part[threadIdx.x % kWarps];
    for (int step = kWarps / 2; step > 0; step /= 2) value = op(value, __shfl_xor_sync(0xffffffffu, value, step));
#endif
    return value;
  }
  template <class T>
  PALP_HD T sum(T value) const {
    return reduce(value, [](T a, T b) { return a + b; });
  }
  PALP_HD Vec3 sum(const Vec3& v) const { return {sum(v.x()), sum(v.y()), sum(v.z())}; }
  PALP_HD real max(real value) const {
    return reduce(value, [](real a, real b) { return a < b ? b : a; });
  }
  // Calls f(i) for those i of [begin, end) of which test(i) is true. Each warp tests a stretch of its own and then
  // shares out what it found there, so that a long f does not keep all lanes waiting for one of them.
  template <class Test, class F>
  PALP_HD void for_those(std::uint32_t begin, std::uint32_t end, Test&& test, F&& f) const {
#ifdef __CUDA_ARCH__
    constexpr std::uint32_t kWarps = kThreads / 32;
    __shared__ std::uint8_t found[kWarps][kLongestStretch];
    const std::uint32_t warp = threadIdx.x / 32, lane = threadIdx.x % 32, stretch = (end - begin + kWarps - 1) / kWarps,
                        first = min(begin + warp * stretch, end), last = min(first + stretch, end);
    // all tests first, so that none waits for what another one loads
    constexpr std::uint32_t kRounds = kLongestStretch / 32;
    bool hit[kRounds];
#pragma unroll
    for (std::uint32_t r = 0; r < kRounds; ++r) {
      const std::uint32_t i = first + r * 32 + lane;
      hit[r] = i < last && test(i);
    }
    std::uint32_t count = 0;
#pragma unroll
    for (std::uint32_t r = 0; r < kRounds; ++r) {
      const unsigned hits = __ballot_sync(0xffffffffu, hit[r]);
      if (hit[r]) found[warp][count + __popc(hits & ((1u << lane) - 1u))] = static_cast<std::uint8_t>(r * 32 + lane);
      count += __popc(hits);
    }
    __syncwarp();
    for (std::uint32_t k = lane; k < count; k += 32) f(first + found[warp][k]);
    __syncwarp();
#endif
  }
  static constexpr std::uint32_t kLongestStretch = 128;
};

// Threads in a block of teams. Many particles lie in tiles (CellGrid::tiled), of which a large block shares more.
template <int L>
inline constexpr int kTeamThreads = L == 4 ? 256 : 128;

template <class F>
__global__ void run_each(std::uint32_t n, F f, const Tag* sleepers) {
  wait_for_previous_kernel();
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < n && (sleepers == nullptr || !sleepers[i].asleep())) f(i);
}

struct Nothing {
  __device__ void operator()(std::uint32_t) const {}
};

template <int L, class F>
__global__ void __launch_bounds__(kTeamThreads<L>, L == 4 ? 6 : 1) run_team(std::uint32_t n, DeviceLists lists, F f) {
  wait_for_previous_kernel();
  const std::uint32_t t = blockIdx.x * kTeamThreads<L> + threadIdx.x, i = t / L;
  if (i < n && !lists.asleep(i)) f(i, LaneTeam<L>{lists.entry + t, lists.count[i], std::size_t(n) * L});
}

template <int L, class F>
__global__ void __launch_bounds__(kTeamThreads<L>) run_group(std::uint32_t n, F f, const Tag* sleepers) {
  wait_for_previous_kernel();
  const std::uint32_t t = blockIdx.x * kTeamThreads<L> + threadIdx.x, i = t / L;
  if (i < n && (sleepers == nullptr || !sleepers[i].asleep())) f(i, GroupTeam<L>{});
}

// Blocks of 128 are those of work that needs many registers (Cuda::for_each_part): at least four run at once.
template <int kThreads, class F>
__global__ void __launch_bounds__(kThreads, kThreads == 128 ? 4 : 1) run_block(F f) {
  wait_for_previous_kernel();
  f(blockIdx.x, BlockTeam<kThreads>{});
}

}  // namespace palp
