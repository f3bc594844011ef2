// The CUDA back end: the whole haptic step, sub-steps included, is one graph, and the host waits once for its results.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "idl/gpu_page.h"
#include "sim_server/backend/cuda_lists.cuh"
#include "sim_server/solver/stage_times.h"

namespace palp {

inline void check(cudaError_t error, const char* what) {
  if (error != cudaSuccess)
    throw std::runtime_error(std::string("CUDA: ") + what + " failed: " + cudaGetErrorString(error));
}

class Cuda {
 public:
  // This skin is wide enough to keep lists for five sub-steps of a stirred fluid, and narrow enough that a quarter of
  // their pairs at most are idle (tools/results).
  static constexpr double kSkinOverSpacing = 0.2;
  static constexpr int kCellsPerReach = 2;
  // Particles from which on cells are numbered by tiles: fewer are better off with rows of cells that are not cut.
  static constexpr std::size_t kTiledFrom = 100000;

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
    processors_ = properties.multiProcessorCount;
    early_launch_ = properties.major >= 9;
    name_ = std::string("cuda, ") + properties.name + ", float";
    gpu_ = gpu_identity(properties.uuid.bytes);
    check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "creating a stream");
    check(cudaStreamCreateWithFlags(&copy_stream_, cudaStreamNonBlocking), "creating a stream");
    check(cudaStreamCreateWithFlags(&side_stream_, cudaStreamNonBlocking), "creating a stream");
    check(cudaEventCreateWithFlags(&forked_, cudaEventDisableTiming), "creating an event");
    check(cudaEventCreateWithFlags(&joined_, cudaEventDisableTiming), "creating an event");
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
    for (cudaEvent_t event : {packed_, copied_, forked_, joined_}) cudaEventDestroy(event);
    for (const Mark& mark : marks_) cudaEventDestroy(mark.event);
    cudaStreamDestroy(stream_);
    cudaStreamDestroy(copy_stream_);
    cudaStreamDestroy(side_stream_);
  }

  std::string name() const { return name_; }
  std::string gpu() const { return gpu_; }
  // A GPU works for one process at a time, and turns to one when that has work for it: a kernel that does nothing is
  // enough.
  void take_gpu() {
    run_each<<<1, 1, 0, stream_>>>(0, Nothing{}, nullptr);
    check(cudaGetLastError(), "taking the GPU");
  }
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
    check(cudaMemsetAsync(p, 0, bytes, stream_), "clearing an array");
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
    request_lists();
    if (work_.lists.neighbor_overflow != nullptr) *work_.lists.neighbor_overflow = 0;
    if (!from.empty())
      check(cudaMemcpyAsync(to, from.data(), from.size() * sizeof(T), cudaMemcpyHostToDevice, stream_),
            "copying to the GPU");
    check(cudaStreamSynchronize(stream_), "copying to the GPU");
  }
  template <class T>
  void download(std::vector<T>& to, const T* from) {
    if (!to.empty())
      check(cudaMemcpyAsync(to.data(), from, to.size() * sizeof(T), cudaMemcpyDeviceToHost, stream_),
            "copying from the GPU");
    check(cudaStreamSynchronize(stream_), "waiting for the GPU");
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
  template <class... A>
  void begin_transfer(const Mirror<A>&... arrays) {
    check(cudaEventRecord(packed_, stream_), "recording an event");
    check(cudaStreamWaitEvent(copy_stream_, packed_, 0), "waiting for an event");
    const auto begin = [this](const auto& m) {
      if (m.count > 0)
        check(cudaMemcpyAsync(m.host, m.device, m.count * sizeof *m.host, cudaMemcpyDeviceToHost, copy_stream_),
              "copying a frame");
    };
    (begin(arrays), ...);
    check(cudaEventRecord(copied_, copy_stream_), "recording an event");
  }
  bool transfer_done() const {
    const cudaError_t error = cudaEventQuery(copied_);
    if (error != cudaErrorNotReady) check(error, "copying a frame");
    return error == cudaSuccess;
  }

  // Runs one haptic step of `variants` that differ in their stages; the last one has all stages. Captures the work of
  // each into a graph the first time; then launches the one asked for and waits for it.
  template <class F>
  void execute(int variant, int variants, F&& work) {
    if (times_ != nullptr) return execute_timed([&] { work(variant); });
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

  // Adds the time of each stage up from here on, of steps that are launched one by one, without their graph; null: no
  // longer.
  void time_stages(StageTimes* times) { times_ = times; }

  // Drops the captured step, which no longer holds; the next step captures it again.
  void forget() {
    for (cudaGraphExec_t graph : graphs_) check(cudaGraphExecDestroy(graph), "dropping the step's graph");
    graphs_.clear();
    request_lists();
    launches_.clear();
  }

  // Runs stages beside those that follow until join(), neither of which may write what the others touch.
  template <class F>
  void beside(F&& stages) {
    if (times_ != nullptr) return stages();
    check(cudaEventRecord(forked_, stream_), "recording an event");
    check(cudaStreamWaitEvent(side_stream_, forked_, 0), "waiting for an event");
    std::swap(stream_, side_stream_);
    after_event_ = true;
    stages();
    check(cudaEventRecord(joined_, stream_), "recording an event");
    std::swap(stream_, side_stream_);
    after_event_ = false;
    forks_ = true;
  }
  // Waits, on the device, for what runs beside.
  void join() {
    if (!forks_) return;
    check(cudaStreamWaitEvent(stream_, joined_, 0), "waiting for an event");
    forks_ = false;
    after_event_ = true;
  }

  // sleepers: tags of the items, of which those that sleep are passed over; null: all are awake.
  template <class F>
  void for_each(const char* name, std::uint32_t n, const F& f, const Tag* sleepers = nullptr) {
    if (n == 0) return;
    note(name);
    launch(name, run_each<F>, n, 256, n, f, sleepers);
  }
  template <class F>
  void for_each_team(const char* name, std::uint32_t n, const F& f) {
    if (n == 0) return;
    note(name);
    with_lanes(
        n, [&]<int L>() { launch(name, run_team<L, F>, std::uint64_t(n) * L, kTeamThreads<L>, n, work_.lists, f); });
  }
  template <class F>
  void for_each_group(const char* name, std::uint32_t n, const F& f, const Tag* sleepers = nullptr) {
    if (n == 0) return;
    note(name);
    with_lanes(n,
               [&]<int L>() { launch(name, run_group<L, F>, std::uint64_t(n) * L, kTeamThreads<L>, n, f, sleepers); });
  }
  template <class F, int Threads = 256>
  void for_each_block(const char* name, std::uint32_t n, const F& f) {
    if (n == 0) return;
    note(name);
    launch(name, run_block<Threads, F>, std::uint64_t(n) * Threads, Threads, f);
  }
  // For parts of the particles, and work of which each thread needs so many registers that few run at once.
  template <class F>
  void for_each_part(const char* name, std::uint32_t n, const F& f) {
    for_each_block<F, 128>(name, n, f);
  }
  // For few items of which each may have as many parts as the scene has particles.
  template <class F>
  void for_each_large(const char* name, std::uint32_t n, const F& f) {
    for_each_block<F, 1024>(name, n, f);
  }

  // neighbors: the number that a particle has on its lattice.
  const std::uint32_t* allocate_sort(std::uint32_t particles, std::uint32_t cells, double neighbors) {
    work_.n = particles;
    work_.cell = allocate<std::uint32_t>("sort cell", particles);
    work_.slot = allocate<std::uint32_t>("sort slot", particles);
    work_.member = allocate<std::uint32_t>("sort member", particles);
    work_.count = allocate<std::uint32_t>("sort count", cells + 2);
    work_.start = allocate<std::uint32_t>("sort start", cells + 2);
    work_.part = allocate<std::uint32_t>("sort part", kMaxListBlocks);
    work_.listed_at = allocate<Packed>("listed at", particles);
    work_.due = allocate<std::uint32_t>("lists due", 1);
    DeviceLists& lists = work_.lists;
    with_lanes(particles, [&]<int L>() { lists.lanes = L; });
    // three times the lattice's neighbours, and whole rows of entries
    lists.room = (static_cast<std::uint32_t>(3 * neighbors) / 32 + 1) * 32;
    lists.entry = allocate<std::uint32_t>("list entries", std::size_t(particles) * lists.room);
    lists.count = allocate<std::uint32_t>("list counts", particles);
    // the device counts in the host's memory: that is rare, and copying the count was not
    check(cudaMallocHost(reinterpret_cast<void**>(&lists.neighbor_overflow), sizeof(std::uint32_t)),
          "allocating pinned memory");
    host_blocks_.push_back(lists.neighbor_overflow);
    *lists.neighbor_overflow = 0;
    return work_.start;
  }
  // Returns the flag that asks for new lists.
  std::uint32_t* lists_due() const { return work_.due; }
  // Makes the stages of particles pass over those that sleep; `sorted` are the tags as sorting writes them.
  void let_sleep(const Tag* sorted) { work_.lists.tag = sorted; }
  // Returns the number of times that a particle had more neighbours than room since the last reset.
  std::uint32_t neighbor_overflow() const {
    return work_.lists.neighbor_overflow != nullptr ? *work_.lists.neighbor_overflow : 0;
  }

  // Sorts and lists neighbours anew when that is due, which the device knows; else leaves the copies that move() made.
  template <class Pair>
  void sort_into_cells(const ParticleView& from, const ParticleView& to, std::uint32_t n, const CellGrid& grid,
                       real support, real skin, const Pair& interacts) {
    note("sort");
    work_.from = from;
    work_.to = to;
    work_.grid = grid;
    work_.reach = support + skin;
    skin_ = skin;
    if (work_.lists.lanes == 4)
      launch_lists<true>(interacts);
    else
      launch_lists<false>(interacts);
  }

  // f moves the particles of the state.
  template <class F>
  void move(const char* name, std::uint32_t n, const F& f) {
    note(name);
    launch(name, run_move<F>, n, 256, f, work_, skin_);
  }

 private:
  static constexpr unsigned kMaxListBlocks = 4096;
  // Calls g with the number of lanes that share a particle: several where one thread a particle would leave the GPU
  // idle. The bounds were measured on an H100 (tools/results).
  template <class G>
  static void with_lanes(std::uint32_t n, G&& g) {
    if (n <= 5000)
      g.template operator()<32>();
    else if (n <= 20000)
      g.template operator()<16>();
    else if (n <= 50000)
      g.template operator()<8>();
    else
      g.template operator()<4>();
  }
  void request_lists() {
    if (work_.due != nullptr) check(cudaMemsetAsync(work_.due, 1, sizeof(std::uint32_t), stream_), "asking for lists");
  }
  // Launches the kernel that sorts and lists, whose blocks must all fit on the device at once.
  template <bool kOneThread, class Pair>
  void launch_lists(const Pair& interacts) {
    int fit = 0;
    check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&fit, rebuild_lists<kOneThread, Pair>, kListThreads, 0),
          "sizing the lists");
    cudaLaunchAttribute together{};
    together.id = cudaLaunchAttributeCooperative;
    together.val.cooperative = 1;
    cudaLaunchConfig_t config{};
    config.gridDim = std::min({blocks(std::uint64_t(work_.n) * (kOneThread ? 1 : kSearchLanes), kListThreads),
                               static_cast<unsigned>(fit * processors_), kMaxListBlocks});
    config.blockDim = kListThreads;
    config.stream = stream_;
    config.attrs = &together;
    config.numAttrs = 1;
    check(cudaLaunchKernelEx(&config, rebuild_lists<kOneThread, Pair>, work_, interacts), "sorting");
  }
  // Launches a kernel. It may be started before the work in front of it on its stream has ended, for it waits by itself
  // (wait_for_previous_kernel).
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
    config.numAttrs = early_launch_ && !after_event_ ? 1 : 0;
    after_event_ = false;
    check(cudaLaunchKernelEx(&config, kernel, arguments...), name);
  }
  static unsigned blocks(std::uint64_t threads, unsigned size) {
    return static_cast<unsigned>((threads + size - 1) / size);
  }
  void note(const char* name) {
    if (record_) launches_.emplace_back(name);
    if (times_ != nullptr) mark(name);
  }
  // Records the moment at which the device comes to a stage.
  void mark(const char* name) {
    if (marked_ == marks_.size()) {
      marks_.emplace_back();
      check(cudaEventCreate(&marks_.back().event), "creating an event");
    }
    marks_[marked_].name = name;
    check(cudaEventRecord(marks_[marked_++].event, stream_), "recording an event");
  }
  template <class F>
  void execute_timed(F&& work) {
    marked_ = 0;
    work();
    mark("");
    check(cudaStreamSynchronize(stream_), "running the step");
    for (std::size_t k = 0; k + 1 < marked_; ++k) {
      float ms = 0;
      check(cudaEventElapsedTime(&ms, marks_[k].event, marks_[k + 1].event), "reading an event");
      add_launch(*times_, marks_[k].name, 1e-3 * ms);
    }
  }

  struct Mark {
    cudaEvent_t event = nullptr;
    const char* name = "";
  };

  std::string name_, gpu_;
  cudaStream_t stream_ = nullptr, copy_stream_ = nullptr, side_stream_ = nullptr;
  cudaEvent_t packed_ = nullptr, copied_ = nullptr, forked_ = nullptr, joined_ = nullptr;
  std::vector<cudaGraphExec_t> graphs_;  // by variant
  std::vector<void*> device_blocks_, host_blocks_;
  std::vector<std::pair<std::string, std::size_t>> arrays_;
  std::vector<std::string> launches_;
  bool record_ = false;
  StageTimes* times_ = nullptr;
  std::vector<Mark> marks_;
  std::size_t marked_ = 0;  // marks of the step that is being timed
  int processors_ = 1;
  bool early_launch_ = false;
  bool forks_ = false;        // something runs beside
  bool after_event_ = false;  // what is launched next waits for another stream
  ListWork work_;
  real skin_ = 0;
};

}  // namespace palp
