// The CUDA back end: the whole haptic step, sub-steps included, is one graph, and the host waits once for its results.
#include <cub/device/device_scan.cuh>

#include <algorithm>
#include <atomic>
#include <functional>
#include <stdexcept>

#include "sim_server/backend/cuda_lists.cuh"
#include "sim_server/backend/make.h"
#include "sim_server/simulation_on.h"

namespace palp {
namespace {

void check(cudaError_t error, const char* what) {
  if (error != cudaSuccess)
    throw std::runtime_error(std::string("CUDA: ") + what + " failed: " + cudaGetErrorString(error));
}

// Whether this toolkit lets the device decide, within a graph, to make new neighbour lists. Otherwise they are made at
// each sub-step.
#if CUDART_VERSION >= 13000
constexpr bool kDeviceDecides = true;
#else
constexpr bool kDeviceDecides = false;
#endif

class Cuda {
 public:
  static constexpr double kSkinOverSpacing = kDeviceDecides ? 0.3 : 0;
  static constexpr std::array<int, 3> kCellsPerReach{2, 2, 2};

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
    check(cudaStreamCreateWithFlags(&branch_, cudaStreamNonBlocking), "creating a stream");
    check(cudaEventCreateWithFlags(&packed_, cudaEventDisableTiming), "creating an event");
    check(cudaEventCreateWithFlags(&copied_, cudaEventDisableTiming), "creating an event");
  }
  Cuda(const Cuda&) = delete;
  Cuda& operator=(const Cuda&) = delete;
  ~Cuda() {
    cudaStreamSynchronize(stream_);
    cudaStreamSynchronize(copy_stream_);
    if (graph_ != nullptr) cudaGraphExecDestroy(graph_);
    for (void* p : device_blocks_) cudaFree(p);
    for (void* p : host_blocks_) cudaFreeHost(p);
    cudaEventDestroy(packed_);
    cudaEventDestroy(copied_);
    cudaStreamDestroy(stream_);
    cudaStreamDestroy(copy_stream_);
    cudaStreamDestroy(branch_);
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
    lists_hold_ = false;
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

  // Captures the work into a graph the first time; then launches it and waits for it.
  template <class F>
  void execute(F&& work) {
    if (graph_ == nullptr) {
      cudaGraph_t graph = nullptr;
      record_ = true;
      check(cudaStreamBeginCapture(stream_, cudaStreamCaptureModeThreadLocal), "capturing the step");
      work();
      check(cudaStreamEndCapture(stream_, &graph), "capturing the step");
      record_ = false;
      check(cudaGraphInstantiate(&graph_, graph, 0), "building the step's graph");
      cudaGraphDestroy(graph);
    }
    if (kDeviceDecides && !lists_hold_) list_anew_(stream_);
    lists_hold_ = true;
    check(cudaGraphLaunch(graph_, stream_), "launching the step");
    check(cudaStreamSynchronize(stream_), "running the step");
  }

  // The captured step no longer holds: capture it again at the next.
  void forget() {
    if (graph_ != nullptr) check(cudaGraphExecDestroy(graph_), "dropping the step's graph");
    graph_ = nullptr;
    lists_hold_ = false;
    launches_.clear();
  }

  template <class F>
  void for_each(const char* name, std::uint32_t n, const F& f) {
    note(name);
    launch(name, run_each<F>, n, 256, n, f);
  }
  template <class F>
  void for_each_team(const char* name, std::uint32_t n, const F& f) {
    note(name);
    with_lanes(n, [&]<int L>() { launch(name, run_team<L, F>, std::uint64_t(n) * L, kTeamThreads, n, lists_, f); });
  }
  template <class F>
  void for_each_block(const char* name, std::uint32_t n, const F& f) {
    note(name);
    launch(name, run_block<F>, std::uint64_t(n) * BlockTeam::kThreads, BlockTeam::kThreads, f);
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
    with_lanes(particles, [&]<int L>() { lists_.lanes = L; });
    // three times the lattice's neighbours, and whole rows of entries
    lists_.room = (static_cast<std::uint32_t>(3 * neighbors) / 32 + 1) * 32;
    lists_.entry = allocate<std::uint32_t>("list entries", std::size_t(particles) * lists_.room);
    lists_.count = allocate<std::uint32_t>("list counts", particles);
    lists_.crowded = crowded_.device;
    listed_at_ = allocate<Packed>("listed at", particles);
    return start_;
  }
  void pull_crowded() { pull(crowded_); }
  // How often a particle had more neighbours than room since the last reset.
  std::uint32_t crowded() const { return *crowded_.host; }

  // The device decides when to sort and list anew, at the end of a sub-step (move). Before a graph's first launch, and
  // after states were uploaded, the host asks for it (execute).
  template <class Pair>
  void sort_into_cells(const ParticleView& from, const ParticleView& to, std::uint32_t n, const CellGrid& grid,
                       real support, real skin, const Pair& interacts) {
    note("sort");
    list_anew_ = [=, this](cudaStream_t stream) {
      const unsigned size = blocks(n, 256);
      const std::uint32_t cells = grid.cells();
      check(cudaMemsetAsync(count_, 0, (cells + 1) * sizeof(std::uint32_t), stream), "clearing the cells");
      count_cells<<<size, 256, 0, stream>>>(n, from.xV, grid, cell_, slot_, count_);
      check(cub::DeviceScan::ExclusiveSum(scan_, scan_bytes_, count_, start_, static_cast<int>(cells + 1), stream),
            "scanning the cells");
      fill_slots<<<size, 256, 0, stream>>>(n, cell_, slot_, start_, member_);
      reorder<<<size, 256, 0, stream>>>(n, cell_, start_, member_, from, to);
      constexpr int kLanes = 8;
      list_neighbors<kLanes><<<blocks(std::uint64_t(n) * kLanes, kTeamThreads), kTeamThreads, 0, stream>>>(
          n, to.xV, to.tag, grid, support + skin, interacts, lists_, listed_at_);
      check(cudaGetLastError(), "sorting");
    };
    if (!kDeviceDecides) list_anew_(stream_);
    sorted_ = to;
    grid_ = grid;
    skin_ = skin;
  }

  // f moves the particles of the state.
  template <class F>
  void move(const char* name, std::uint32_t n, const F& f, const ParticleView& state) {
#if CUDART_VERSION >= 13000
    note(name);
    cudaGraphConditionalHandle due{};
    check(cudaGraphConditionalHandleCreate(&due, captured().graph, 0, cudaGraphCondAssignDefault), "making a branch");
    launch(name, run_move<F>, n, 256, n, f, state, sorted_, grid_, skin_, listed_at_, due);
    cudaGraphNodeParams branch{};
    branch.type = cudaGraphNodeTypeConditional;
    branch.conditional.handle = due;
    branch.conditional.type = cudaGraphCondTypeIf;
    branch.conditional.size = 1;
    const Captured front = captured();
    cudaGraphNode_t node = nullptr;
    check(cudaGraphAddNode(&node, front.graph, front.nodes, front.edges, front.count, &branch), "adding a branch");
    check(cudaStreamBeginCaptureToGraph(branch_, branch.conditional.phGraph_out[0], nullptr, nullptr, 0,
                                        cudaStreamCaptureModeThreadLocal),
          "capturing a branch");
    list_anew_(branch_);
    check(cudaStreamEndCapture(branch_, nullptr), "capturing a branch");
    check(cudaStreamUpdateCaptureDependencies(stream_, &node, nullptr, 1, cudaStreamSetCaptureDependencies),
          "adding a branch");
#else
    (void)state;
    for_each(name, n, f);
#endif
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
#if CUDART_VERSION >= 13000
  // The graph that the stream's work goes to, and what the next node will wait for.
  struct Captured {
    cudaGraph_t graph = nullptr;
    const cudaGraphNode_t* nodes = nullptr;
    const cudaGraphEdgeData* edges = nullptr;
    std::size_t count = 0;
  };
  Captured captured() const {
    Captured c;
    cudaStreamCaptureStatus status{};
    check(cudaStreamGetCaptureInfo(stream_, &status, nullptr, &c.graph, &c.nodes, &c.edges, &c.count),
          "looking at the capture");
    return c;
  }
#endif
  // The kernel may be started before the work in front of it has ended: it waits by itself (wait_for_work_in_front).
  template <class... P, class... A>
  void launch(const char* name, void (*kernel)(P...), std::uint64_t threads, unsigned size, const A&... arguments) {
    cudaLaunchAttribute early{};
    early.id = cudaLaunchAttributeProgrammaticStreamSerialization;
    early.val.programmaticStreamSerializationAllowed = 1;
    cudaLaunchConfig_t config{};
    config.gridDim = blocks(threads, size);
    config.blockDim = size;
    config.stream = stream_;
    config.attrs = &early;
    config.numAttrs = 1;
    check(cudaLaunchKernelEx(&config, kernel, arguments...), name);
  }
  static unsigned blocks(std::uint64_t threads, unsigned size) {
    return static_cast<unsigned>((threads + size - 1) / size);
  }
  void note(const char* name) {
    if (record_) launches_.emplace_back(name);
  }

  std::string name_;
  cudaStream_t stream_ = nullptr, copy_stream_ = nullptr, branch_ = nullptr;
  cudaEvent_t packed_ = nullptr, copied_ = nullptr;
  cudaGraphExec_t graph_ = nullptr;
  std::vector<void*> device_blocks_, host_blocks_;
  std::vector<std::pair<std::string, std::size_t>> arrays_;
  std::vector<std::string> launches_;
  bool record_ = false;
  std::uint32_t *cell_ = nullptr, *slot_ = nullptr, *member_ = nullptr, *count_ = nullptr, *start_ = nullptr;
  NeighborLists lists_;
  Packed* listed_at_ = nullptr;  // positions that the lists were made for
  bool lists_hold_ = false;      // at a step's begin
  std::function<void(cudaStream_t)> list_anew_;
  ParticleView sorted_;
  CellGrid grid_;
  real skin_ = 0;
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
