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

template <int L, class F>
PALP_HD inline void for_neighbors(const CellGrid& g, const Packed* xV, const Vec3& x_i, real support, LaneTeam<L> team,
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
    const Packed xV_j = fetch(xV + j);
    Vec3 d = x_i - xV_j.xyz();
    for (int a = 0; a < 3; ++a) d[a] -= g.period[a] * ((d[a] * inv_period[a] + kRound) - kRound);
    const real r2 = d.squaredNorm();
    if (r2 < support2) f(j, xV_j, d, r2);
  }
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
};

inline constexpr int kTeamThreads = 128;

template <class F>
__global__ void run_each(std::uint32_t n, F f, const Tag* sleepers) {
  wait_for_previous_kernel();
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < n && (sleepers == nullptr || !sleepers[i].asleep())) f(i);
}

template <int L, class F>
__global__ void __launch_bounds__(kTeamThreads) run_team(std::uint32_t n, DeviceLists lists, F f) {
  wait_for_previous_kernel();
  const std::uint32_t t = blockIdx.x * kTeamThreads + threadIdx.x, i = t / L;
  if (i < n && !lists.asleep(i)) f(i, LaneTeam<L>{lists.entry + t, lists.count[i], std::size_t(n) * L});
}

template <int L, class F>
__global__ void __launch_bounds__(kTeamThreads) run_group(std::uint32_t n, F f, const Tag* sleepers) {
  wait_for_previous_kernel();
  const std::uint32_t t = blockIdx.x * kTeamThreads + threadIdx.x, i = t / L;
  if (i < n && (sleepers == nullptr || !sleepers[i].asleep())) f(i, GroupTeam<L>{});
}

template <int kThreads, class F>
__global__ void __launch_bounds__(kThreads) run_block(F f) {
  wait_for_previous_kernel();
  f(blockIdx.x, BlockTeam<kThreads>{});
}

}  // namespace palp
