// The CUDA back end: the whole haptic step, sub-steps included, is one graph, and the host waits once for its results.
#include <cub/device/device_scan.cuh>

#include <algorithm>
#include <atomic>
#include <stdexcept>

#include "sim_server/backend/make.h"
#include "sim_server/simulation_on.h"

namespace palp {
namespace {

void check(cudaError_t error, const char* what) {
  if (error != cudaSuccess)
    throw std::runtime_error(std::string("CUDA: ") + what + " failed: " + cudaGetErrorString(error));
}

constexpr int kTeamThreads = 128;

// Each particle's neighbours in reach, listed once per sub-step for all passes. Of the candidates that a warp tests
// together few are in reach; a pass that worked on them while it searched would do each one's work with most lanes
// idle. Lane m of particle i owns the entries k * lanes * particles + i * lanes + m, so that neighbouring lanes read
// side by side.
struct NeighborLists {
  std::uint32_t* entry = nullptr;
  std::uint32_t* count = nullptr;    // per lane
  std::uint32_t* crowded = nullptr;  // lanes that found more than they have room for
  std::uint32_t room = 0;            // entries per lane
};

// L neighbouring lanes of a warp share one particle's neighbour loop. While they search, at most four lanes share a row
// of cells, which holds few particles, and the rows are shared among groups of them.
template <int L>
struct LaneTeam {
  static constexpr int kPerRow = L < 4 ? L : (L == 8 ? 2 : 4);
  const std::uint32_t* list;  // this lane's first entry
  std::uint32_t count, stride;
  PALP_HD int member() const {
#ifdef __CUDA_ARCH__
    return threadIdx.x % L;
#else
    return 0;
#endif
  }
  PALP_HD int group() const { return member() / kPerRow; }
  PALP_HD int groups() const { return L / kPerRow; }
  PALP_HD std::uint32_t lane() const { return member() % kPerRow; }
  PALP_HD std::uint32_t size() const { return kPerRow; }
  PALP_HD bool leader() const { return member() == 0; }
  PALP_HD real sum(real value) const {
#ifdef __CUDA_ARCH__
    const unsigned mask = L == 32 ? 0xffffffffu : ((1u << L) - 1u) << (threadIdx.x % 32 / L * L);
    for (int step = L / 2; step > 0; step /= 2) value += __shfl_xor_sync(mask, value, step, L);
#endif
    return value;
  }
  PALP_HD Vec3 sum(const Vec3& v) const { return {sum(v.x()), sum(v.y()), sum(v.z())}; }
};

template <int L, class F>
PALP_HD inline void for_neighbors(const CellGrid& g, const Packed* xV, const Vec3& x_i, real, LaneTeam<L> team, F&& f) {
  for (std::uint32_t k = 0; k < team.count; ++k) {
    const std::uint32_t j = team.list[std::size_t(k) * team.stride];
    const Vec3 d = separation(g, x_i, xV[j]);
    f(j, d, d.squaredNorm());
  }
}

// A block of threads shares one item.
struct BlockTeam {
  static constexpr int kThreads = 256;
  PALP_HD std::uint32_t lane() const {
#ifdef __CUDA_ARCH__
    return threadIdx.x;
#else
    return 0;
#endif
  }
  PALP_HD std::uint32_t size() const { return kThreads; }
  PALP_HD bool leader() const { return lane() == 0; }
  // A tree of fixed shape, so the same input gives the same bits.
  template <class T, class Op>
  PALP_HD T reduce(T value, Op op) const {
#ifdef __CUDA_ARCH__
    __shared__ T part[kThreads];
    __syncthreads();
    part[threadIdx.x] = value;
    __syncthreads();
    for (int half = kThreads / 2; half > 0; half /= 2) {
      if (int(threadIdx.x) < half) part[threadIdx.x] = op(part[threadIdx.x], part[threadIdx.x + half]);
      __syncthreads();
    }
    value = part[0];
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

template <class F>
__global__ void run_each(std::uint32_t n, F f) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < n) f(i);
}

template <int L, class F>
__global__ void __launch_bounds__(kTeamThreads) run_team(std::uint32_t n, NeighborLists lists, F f) {
  const std::uint32_t t = blockIdx.x * kTeamThreads + threadIdx.x;
  if (t / L < n) f(t / L, LaneTeam<L>{lists.entry + t, lists.count[t], n * L});
}

template <int L, class Pair>
__global__ void __launch_bounds__(kTeamThreads)
    list_neighbors(std::uint32_t n, const Packed* xV, const Tag* tag, CellGrid grid, real support, Pair interacts,
                   NeighborLists lists) {
  const std::uint32_t t = blockIdx.x * kTeamThreads + threadIdx.x, i = t / L;
  if (i >= n) return;
  const LaneTeam<L> team{};
  const Vec3 x_i = xV[i].xyz();
  const Tag tag_i = tag[i];
  const real support2 = support * support;
  std::uint32_t count = 0;
  for_each_run(grid, x_i, support, team, [&](std::uint32_t begin, std::uint32_t end, const Vec3& shift) {
    const Vec3 x = x_i - shift;
    for (std::uint32_t j = begin + team.lane(); j < end; j += team.size()) {
      const Packed x_j = xV[j];
      if (Vec3(x.x() - x_j.x, x.y() - x_j.y, x.z() - x_j.z).squaredNorm() >= support2 || !interacts(tag_i, tag[j]))
        continue;
      if (count < lists.room) lists.entry[std::size_t(count) * n * L + t] = j;
      ++count;
    }
  });
  if (count > lists.room) {
    atomicAdd(lists.crowded, 1u);
    count = lists.room;
  }
  lists.count[t] = count;
}

template <class F>
__global__ void __launch_bounds__(BlockTeam::kThreads) run_block(F f) {
  f(blockIdx.x, BlockTeam{});
}

// Stable counting sort by cell in four kernels. Atomics hand out the slots of a cell in any order; each particle then
// finds its place among the slots of its cell by comparing indices, so that the result does not depend on that order.
__global__ void count_cells(std::uint32_t n, const Packed* xV, CellGrid grid, std::uint32_t* cell, std::uint32_t* slot,
                            std::uint32_t* count) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= n) return;
  cell[i] = grid.index_of(xV[i].xyz());
  slot[i] = atomicAdd(&count[cell[i]], 1u);
}

__global__ void fill_slots(std::uint32_t n, const std::uint32_t* cell, const std::uint32_t* slot,
                           const std::uint32_t* start, std::uint32_t* member) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < n) member[start[cell[i]] + slot[i]] = i;
}

__global__ void reorder(std::uint32_t n, const std::uint32_t* cell, const std::uint32_t* start,
                        const std::uint32_t* member, ParticleView from, ParticleView to) {
  const std::uint32_t s = blockIdx.x * blockDim.x + threadIdx.x;
  if (s >= n) return;
  const std::uint32_t i = member[s], c = cell[i];
  std::uint32_t place = start[c];
  for (std::uint32_t t = start[c]; t < start[c + 1]; ++t) place += member[t] < i ? 1u : 0u;
  copy_particle(from, i, to, place);
}

class Cuda {
 public:
  static constexpr double kSkinOverSpacing = 0;
  static constexpr int kCellsPerReach = 2;

  template <class T>
  struct Mirror {
    T* host = nullptr;
    T* device = nullptr;
    std::size_t count = 0;
  };

  explicit Cuda(std::size_t) {
    int device = 0;
    check(cudaGetDevice(&device), "choosing the device");
    cudaDeviceProp properties{};
    check(cudaGetDeviceProperties(&properties, device), "reading the device's properties");
    name_ = std::string("cuda, ") + properties.name + ", float";
    check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "creating a stream");
    check(cudaStreamCreateWithFlags(&copy_stream_, cudaStreamNonBlocking), "creating a stream");
    check(cudaEventCreateWithFlags(&packed_, cudaEventDisableTiming), "creating an event");
    check(cudaEventCreateWithFlags(&copied_, cudaEventDisableTiming), "creating an event");
  }
  Cuda(const Cuda&) = delete;
  Cuda& operator=(const Cuda&) = delete;
  ~Cuda() {
    cudaStreamSynchronize(stream_);
    cudaStreamSynchronize(copy_stream_);
    for (cudaGraphExec_t graph : graphs_) cudaGraphExecDestroy(graph);
    for (void* p : device_blocks_) cudaFree(p);
    for (void* p : host_blocks_) cudaFreeHost(p);
    cudaEventDestroy(packed_);
    cudaEventDestroy(copied_);
    cudaStreamDestroy(stream_);
    cudaStreamDestroy(copy_stream_);
  }

  std::string name() const { return name_; }
  const std::vector<std::pair<std::string, std::size_t>>& arrays() const { return arrays_; }
  const std::vector<std::string>& launches() const { return launches_; }

  template <class T>
  T* allocate(const std::string& name, std::size_t count) {
    const std::size_t bytes = std::max<std::size_t>(1, count) * sizeof(T);
    void* p = nullptr;
    if (cudaMalloc(&p, bytes) != cudaSuccess)
      throw std::runtime_error("the GPU has no " + std::to_string(bytes / 1000000 + 1) + " MB for the array '" + name +
                               "': use fewer particles or another GPU");
    device_blocks_.push_back(p);
    arrays_.emplace_back(name, bytes);
    check(cudaMemset(p, 0, bytes), "clearing an array");
    return static_cast<T*>(p);
  }
  template <class T>
  Mirror<T> mirror(const std::string& name, std::size_t count) {
    void* p = nullptr;
    check(cudaMallocHost(&p, std::max<std::size_t>(1, count) * sizeof(T)), "allocating pinned memory");
    host_blocks_.push_back(p);
    return {static_cast<T*>(p), allocate<T>(name, count), count};
  }
  template <class T>
  void upload(T* to, const std::vector<T>& from) {
    if (crowded_.device != nullptr) check(cudaMemset(crowded_.device, 0, sizeof(std::uint32_t)), "clearing a count");
    if (!from.empty())
      check(cudaMemcpy(to, from.data(), from.size() * sizeof(T), cudaMemcpyHostToDevice), "copying to the GPU");
  }
  template <class T>
  void download(std::vector<T>& to, const T* from) {
    check(cudaStreamSynchronize(stream_), "waiting for the GPU");
    if (!to.empty())
      check(cudaMemcpy(to.data(), from, to.size() * sizeof(T), cudaMemcpyDeviceToHost), "copying from the GPU");
  }
  template <class T>
  void push(const Mirror<T>& m) {
    check(cudaMemcpyAsync(m.device, m.host, m.count * sizeof(T), cudaMemcpyHostToDevice, stream_),
          "copying to the GPU");
  }
  template <class T>
  void pull(const Mirror<T>& m) {
    check(cudaMemcpyAsync(m.host, m.device, m.count * sizeof(T), cudaMemcpyDeviceToHost, stream_),
          "copying from the GPU");
  }

  // The packed arrays travel on a stream of their own, behind the step that filled them.
  template <class A>
  void begin_transfer(const Mirror<A>& a, const Mirror<A>& b) {
    check(cudaEventRecord(packed_, stream_), "recording an event");
    check(cudaStreamWaitEvent(copy_stream_, packed_, 0), "waiting for an event");
    for (const Mirror<A>& m : {a, b})
      if (m.count > 0)
        check(cudaMemcpyAsync(m.host, m.device, m.count * sizeof(A), cudaMemcpyDeviceToHost, copy_stream_),
              "copying a frame");
    check(cudaEventRecord(copied_, copy_stream_), "recording an event");
  }
  bool transfer_done() const {
    const cudaError_t error = cudaEventQuery(copied_);
    if (error != cudaErrorNotReady) check(error, "copying a frame");
    return error == cudaSuccess;
  }

  // One haptic step of `variants` that differ in their stages; the last has them all. Captures the work of each into a
  // graph the first time; then launches the one asked for and waits for it.
  template <class F>
  void execute(int variant, int variants, F&& work) {
    for (int k = static_cast<int>(graphs_.size()); k < variants; ++k) {
      cudaGraph_t graph = nullptr;
      record_ = k + 1 == variants;
      check(cudaStreamBeginCapture(stream_, cudaStreamCaptureModeThreadLocal), "capturing the step");
      work(k);
      check(cudaStreamEndCapture(stream_, &graph), "capturing the step");
      record_ = false;
      cudaGraphExec_t ready = nullptr;
      check(cudaGraphInstantiate(&ready, graph, 0), "building the step's graph");
      graphs_.push_back(ready);
      cudaGraphDestroy(graph);
    }
    check(cudaGraphLaunch(graphs_[static_cast<std::size_t>(variant)], stream_), "launching the step");
    check(cudaStreamSynchronize(stream_), "running the step");
  }

  // The captured step no longer holds: capture it again at the next.
  void forget() {
    for (cudaGraphExec_t graph : graphs_) check(cudaGraphExecDestroy(graph), "dropping the step's graph");
    graphs_.clear();
    launches_.clear();
  }

  template <class F>
  void for_each(const char* name, std::uint32_t n, const F& f) {
    note(name);
    run_each<<<blocks(n, 256), 256, 0, stream_>>>(n, f);
    check(cudaGetLastError(), name);
  }
  template <class F>
  void for_each_team(const char* name, std::uint32_t n, const F& f) {
    note(name);
    with_lanes(n, [&]<int L>() {
      run_team<L><<<blocks(std::uint64_t(n) * L, kTeamThreads), kTeamThreads, 0, stream_>>>(n, lists_, f);
    });
    check(cudaGetLastError(), name);
  }
  template <class F>
  void for_each_block(const char* name, std::uint32_t n, const F& f) {
    note(name);
    run_block<<<n, BlockTeam::kThreads, 0, stream_>>>(f);
    check(cudaGetLastError(), name);
  }

  // neighbors: how many a particle has on its lattice.
  const std::uint32_t* allocate_sort(std::uint32_t particles, std::uint32_t cells, double neighbors) {
    cell_ = allocate<std::uint32_t>("sort cell", particles);
    slot_ = allocate<std::uint32_t>("sort slot", particles);
    member_ = allocate<std::uint32_t>("sort member", particles);
    count_ = allocate<std::uint32_t>("sort count", cells + 1);
    start_ = allocate<std::uint32_t>("sort start", cells + 1);
    check(cub::DeviceScan::ExclusiveSum(nullptr, scan_bytes_, count_, start_, static_cast<int>(cells + 1)),
          "sizing the scan");
    scan_ = allocate<std::byte>("sort scan", scan_bytes_);
    crowded_ = mirror<std::uint32_t>("list crowded", 1);
    with_lanes(particles, [&]<int L>() {
      // twice the lattice's neighbours, and again when lanes share: some rows are fuller than others
      lists_.room = static_cast<std::uint32_t>((L > 1 ? 4 : 2) * neighbors / L) + 16;
      lists_.entry = allocate<std::uint32_t>("list entries", std::size_t(particles) * L * lists_.room);
      lists_.count = allocate<std::uint32_t>("list counts", std::size_t(particles) * L);
      lists_.crowded = crowded_.device;
    });
    return start_;
  }
  void pull_crowded() { pull(crowded_); }
  // Lanes that had more neighbours than room since the last reset.
  std::uint32_t crowded() const { return *crowded_.host; }

  // Sorts and lists neighbours at every sub-step.
  template <class Pair>
  void sort_into_cells(const ParticleView& from, const ParticleView& to, std::uint32_t n, const CellGrid& grid,
                       real support, real, const Pair& interacts) {
    note("sort");
    const std::uint32_t cells = grid.cells();
    check(cudaMemsetAsync(count_, 0, (cells + 1) * sizeof(std::uint32_t), stream_), "clearing the cells");
    count_cells<<<blocks(n, 256), 256, 0, stream_>>>(n, from.xV, grid, cell_, slot_, count_);
    check(cub::DeviceScan::ExclusiveSum(scan_, scan_bytes_, count_, start_, static_cast<int>(cells + 1), stream_),
          "scanning the cells");
    fill_slots<<<blocks(n, 256), 256, 0, stream_>>>(n, cell_, slot_, start_, member_);
    reorder<<<blocks(n, 256), 256, 0, stream_>>>(n, cell_, start_, member_, from, to);
    with_lanes(n, [&]<int L>() {
      list_neighbors<L><<<blocks(std::uint64_t(n) * L, kTeamThreads), kTeamThreads, 0, stream_>>>(
          n, to.xV, to.tag, grid, support, interacts, lists_);
    });
    check(cudaGetLastError(), "sorting");
  }

 private:
  // Where one thread a particle would leave the GPU idle, several share a particle. The bounds were measured on an H100
  // (tools/results).
  template <class G>
  static void with_lanes(std::uint32_t n, G&& g) {
    if (n <= 4000)
      g.template operator()<32>();
    else if (n <= 120000)
      g.template operator()<8>();
    else
      g.template operator()<1>();
  }
  static unsigned blocks(std::uint64_t threads, unsigned size) {
    return static_cast<unsigned>((threads + size - 1) / size);
  }
  void note(const char* name) {
    if (record_) launches_.emplace_back(name);
  }

  std::string name_;
  cudaStream_t stream_ = nullptr, copy_stream_ = nullptr;
  cudaEvent_t packed_ = nullptr, copied_ = nullptr;
  std::vector<cudaGraphExec_t> graphs_;  // by variant
  std::vector<void*> device_blocks_, host_blocks_;
  std::vector<std::pair<std::string, std::size_t>> arrays_;
  std::vector<std::string> launches_;
  bool record_ = false;
  std::uint32_t *cell_ = nullptr, *slot_ = nullptr, *member_ = nullptr, *count_ = nullptr, *start_ = nullptr;
  NeighborLists lists_;
  Mirror<std::uint32_t> crowded_;
  std::byte* scan_ = nullptr;
  std::size_t scan_bytes_ = 0;
};

}  // namespace

std::string cuda_unavailable() {
  int devices = 0;
  const cudaError_t error = cudaGetDeviceCount(&devices);
  if (error != cudaSuccess)
    return std::string("no CUDA device can be used (") + cudaGetErrorString(error) + "): use --backend cpu";
  return devices > 0 ? "" : "this host has no CUDA device: use --backend cpu";
}

std::unique_ptr<Simulation> make_cuda_simulation(const Scene& scene) {
  if (const std::string why = cuda_unavailable(); !why.empty()) throw std::runtime_error(why);
  return std::make_unique<SimulationOn<Cuda>>(scene);
}

}  // namespace palp
