// The CPU back end: loops by a team of threads over the same functors that the GPU runs, with stored neighbour lists.
// It is one file, because the compiler contracts products and sums as it inlines: cut in two it computes other last
// bits.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <limits>
#include <memory>
#include <new>

#include "sim_server/physics/list_team.h"
#include "sim_server/solver/make_simulation.h"
#include "sim_server/solver/simulation_on.h"
#include "sim_server/solver/stage_times.h"
#include "sim_server/threads/float_mode.h"
#include "sim_server/threads/thread_team.h"

namespace palp {
namespace {

// The instructions that this file was compiled for. Installed, it is there for more than one set; they differ in the
// last bits.
#if defined(__AVX512F__)
constexpr const char* kInstructions = "AVX-512";
#elif defined(__AVX2__)
constexpr const char* kInstructions = "AVX2";
#else
constexpr const char* kInstructions = "baseline";
#endif

// Lists of the neighbours within the support radius and a skin, made once for many sub-steps.
class NeighborLists {
 public:
  // Returns false when a particle that is awake has moved by half of the skin: then new lists are due.
  bool still_valid(const ParticleView& state, std::uint32_t n, const CellGrid& grid) const {
    if (!valid_) return false;
    const Packed* xV = state.xV;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (state.tag[i].asleep()) continue;
      Vec3 d = xV[i].xyz() - listed_at_[i];
      for (int a = 0; a < 3; ++a)
        if (std::abs(d[a]) > real(0.5) * grid.period[a]) d[a] = std::abs(d[a]) - grid.period[a];
      if (!(d.squaredNorm() < allowed2_)) return false;
    }
    return true;
  }
  void forget() { valid_ = false; }

  // Lists the neighbours of particles that are sorted into the grid's cells. Runs of particles are listed in parallel,
  // each into memory of its own that it keeps from one listing to the next.
  template <class Pair>
  void build(const ParticleView& sorted, std::uint32_t n, const CellGrid& grid, real support, real skin,
             const Pair& interacts, ThreadTeam& team) {
    allowed2_ = real(0.25) * skin * skin;
    const real reach = support + skin;
    listed_at_.resize(n);
    end_.resize(n);
    run_ = std::max<std::uint32_t>(1, (n + kRuns - 1) / kRuns);
    team.for_each(kRuns, 1, [&](std::size_t run) {
      const auto r = static_cast<std::uint32_t>(run);
      std::vector<std::uint32_t>& list = list_[r];
      std::size_t size = 0;
      for (std::uint32_t i = r * run_; i < std::min(n, (r + 1) * run_); ++i) {
        const Tag tag_i = sorted.tag[i];
        end_[i] = static_cast<std::uint32_t>(size);
        listed_at_[i] = sorted.xV[i].xyz();
        if (tag_i.inactive() || tag_i.asleep()) continue;
        for_each_run(grid, sorted.xV[i].xyz(), reach, SerialTeam{},
                     [&](std::uint32_t begin, std::uint32_t end, const Vec3& shift) {
                       if (list.size() < size + (end - begin)) list.resize(2 * (size + (end - begin)));
                       const Vec3 x = sorted.xV[i].xyz() - shift;
                       size += list_near(sorted.xV, begin, end, x, reach, list.data() + size);
                     });
        size = keep_pairs(sorted, grid, i, list.data(), i % run_ == 0 ? 0 : end_[i - 1], size, interacts);
        end_[i] = static_cast<std::uint32_t>(size);
      }
    });
    valid_ = true;
  }

  ListTeam of(std::uint32_t i) const {
    const std::uint32_t* list = list_[i / run_].data();
    return {list + (i % run_ == 0 ? 0 : end_[i - 1]), list + end_[i]};
  }

 private:
  // Writes those of the particles [begin, end) that are within reach of x to a list with room for all of them, and
  // returns how many they are. Distances come by lanes and choices without branches, because a processor cannot predict
  // which candidates are in reach.
  static std::size_t list_near(const Packed* xV, std::uint32_t begin, std::uint32_t end, const Vec3& x, real reach,
                               std::uint32_t* list) {
    const Vec3Of<Lanes> from = x.cast<Lanes>();
    std::size_t size = 0;
    std::uint32_t j = begin;
    for (; end - j >= kLanes; j += kLanes) {
      LaneIndex at;
      for (std::uint32_t k = 0; k < kLanes; ++k) at.of[k] = j + k;
      real r2[kLanes];
      Lanes((from - fetch<Lanes>(xV, at).xyz()).squaredNorm()).v.copy_to(r2, std::experimental::element_aligned);
      for (std::uint32_t k = 0; k < kLanes; ++k) {
        list[size] = j + k;
        size += r2[k] < reach * reach ? 1 : 0;
      }
    }
    for (; j < end; ++j) {
      list[size] = j;
      size += (x - xV[j].xyz()).squaredNorm() < reach * reach ? 1 : 0;
    }
    return size;
  }

  // Keeps of the entries [begin, end) of a list, near particle i, those that interact with it and are in its sight, and
  // returns their end.
  template <class Pair>
  static std::size_t keep_pairs(const ParticleView& sorted, const CellGrid& grid, std::uint32_t i, std::uint32_t* list,
                                std::size_t begin, std::size_t end, const Pair& interacts) {
    const Vec3 x = sorted.xV[i].xyz();
    const Tag tag_i = sorted.tag[i];
    const auto clear = interacts.clear_around(tag_i, x);
    std::size_t kept = begin;
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t j = list[k];
      const Tag tag_j = sorted.tag[j];
      if (interacts(tag_i, tag_j) && interacts.in_sight(tag_j, x, separation(grid, x, sorted.xV[j]), clear))
        list[kept++] = j;
    }
    return kept;
  }

  static constexpr std::uint32_t kRuns = 64;
  std::array<std::vector<std::uint32_t>, kRuns> list_;
  std::vector<std::uint32_t> end_;  // end of each particle's neighbours in its run's list
  std::vector<Vec3> listed_at_;
  std::uint32_t run_ = 1;
  real allowed2_ = 0;
  bool valid_ = false;
};

class Cpu {
 public:
  // This skin is wide enough to keep lists for tens of sub-steps of a stirred fluid, and narrow enough that few of
  // their pairs are idle.
  static constexpr double kSkinOverSpacing = 0.2;
  static constexpr int kCellsPerReach = 1;
  static constexpr std::size_t kTiledFrom = std::numeric_limits<std::size_t>::max();

  template <class T>
  struct Mirror {
    T* host = nullptr;
    T* device = nullptr;
    std::size_t count = 0;
  };

  // The smallest scenes are stepped by one thread. Two take half the time of one from 512 particles on (a cube of
  // fluid, 357 us of 714), with 216 as much (253 of 254); where cores are busy the team itself leaves helpers out.
  explicit Cpu(std::size_t particles) : team_(particles < kSingleThreadBelow ? 1 : available_threads()) {}

  std::string name() const {
    return fmt::format("cpu ({}), {} thread{}, {}", kInstructions, team_.threads(), team_.threads() > 1 ? "s" : "",
                       sizeof(real) == 4 ? "float" : "double");
  }
  std::string gpu() const { return {}; }
  void take_gpu() {}
  const std::vector<std::pair<std::string, std::size_t>>& arrays() const { return arrays_; }
  const std::vector<std::string>& launches() const { return launches_; }

  template <class T>
  T* allocate(const std::string& name, std::size_t count) {
    const std::size_t bytes = std::max<std::size_t>(1, count) * sizeof(T);
    arrays_.emplace_back(name, bytes);
    blocks_.emplace_back(static_cast<std::byte*>(::operator new(bytes, kAlign)));
    T* p = reinterpret_cast<T*>(blocks_.back().get());
    std::uninitialized_default_construct_n(p, std::max<std::size_t>(1, count));
    std::memset(static_cast<void*>(p), 0, bytes);  // Eigen's types construct themselves without a value
    return p;
  }
  template <class T>
  Mirror<T> mirror(const std::string& name, std::size_t count) {
    T* p = allocate<T>(name, count);
    return {p, p, count};
  }
  template <class T>
  void upload(T* to, const std::vector<T>& from) {
    lists_.forget();
    std::copy(from.begin(), from.end(), to);
  }
  template <class T>
  void download(std::vector<T>& to, const T* from) {
    std::copy(from, from + to.size(), to.begin());
  }
  template <class T>
  void push(const Mirror<T>&) {}
  template <class T>
  void pull(const Mirror<T>&) {}
  template <class... A>
  void begin_transfer(const Mirror<A>&...) {}
  bool transfer_done() const { return true; }

  // Runs one haptic step of `variants` that differ in their stages; the last one has all stages.
  template <class F>
  void execute(int variant, int variants, F&& work) {
    const FlushSubnormals flush;
    record_ = launches_.empty() || (variant + 1 == variants && !complete_);
    if (record_) launches_.clear();
    complete_ = complete_ || variant + 1 == variants;
    work(variant);
    if (times_ != nullptr) end_stage();
    team_.adapt();
    record_ = false;
  }
  // Adds the time of each stage up from here on; null: no longer.
  void time_stages(StageTimes* times) {
    times_ = times;
    stage_ = nullptr;
  }
  void forget() {
    launches_.clear();
    complete_ = false;
  }

  // Runs stages that those up to join() need not wait for: here, before them.
  template <class F>
  void beside(F&& stages) {
    stages();
  }
  void join() {}

  // sleepers: tags of the items, of which those that sleep are passed over; null: all are awake.
  template <class F>
  void for_each(const char* name, std::uint32_t n, const F& f, const Tag* sleepers = nullptr) {
    if (n == 0) return;
    note(name);
    team_.for_each(n, kCheapChunk, [&f, sleepers](std::size_t i) {
      if (sleepers == nullptr || !sleepers[i].asleep()) f(static_cast<std::uint32_t>(i));
    });
  }
  template <class F>
  void for_each_team(const char* name, std::uint32_t n, const F& f) {
    if (n == 0) return;
    note(name);
    team_.for_each(n, kChunk, [this, &f](std::size_t k) {
      const auto i = static_cast<std::uint32_t>(k);
      if (!asleep(i)) f(i, lists_.of(i));
    });
  }
  template <class F>
  void for_each_group(const char* name, std::uint32_t n, const F& f, const Tag* sleepers = nullptr) {
    if (n == 0) return;
    note(name);
    team_.for_each(n, kChunk, [&f, sleepers](std::size_t i) {
      if (sleepers == nullptr || !sleepers[i].asleep()) f(static_cast<std::uint32_t>(i), SerialTeam{});
    });
  }
  template <class F>
  void for_each_block(const char* name, std::uint32_t n, const F& f) {
    if (n == 0) return;
    note(name);
    team_.for_each(n, 1, [&f](std::size_t i) { f(static_cast<std::uint32_t>(i), SerialTeam{}); });
  }
  template <class F>
  void for_each_part(const char* name, std::uint32_t n, const F& f) {
    for_each_block(name, n, f);
  }
  template <class F>
  void for_each_large(const char* name, std::uint32_t n, const F& f) {
    for_each_block(name, n, f);
  }

  const std::uint32_t* allocate_sort(std::uint32_t particles, std::uint32_t cells, double) {
    cell_ = allocate<std::uint32_t>("sort cell", particles);
    start_ = allocate<std::uint32_t>("sort start", cells + 2);
    due_ = allocate<std::uint32_t>("lists due", 1);
    return start_;
  }
  // Returns the flag that asks for new lists.
  std::uint32_t* lists_due() const { return due_; }
  // Makes the stages of particles pass over those that sleep; `sorted` are the tags as sorting writes them.
  void let_sleep(const Tag* sorted) { tag_ = sorted; }

  static std::uint32_t neighbor_overflow() { return 0; }  // lists grow as needed

  // Sorts and lists neighbours anew when that is due; else copies in place.
  template <class Pair>
  void sort_into_cells(const ParticleView& from, const ParticleView& to, std::uint32_t n, const CellGrid& grid,
                       real support, real skin, const Pair& interacts) {
    note("sort");
    if (*due_ == 0 && lists_.still_valid(from, n, grid)) {
      team_.for_each(n, kCheapChunk, [&](std::size_t k) {
        const auto i = static_cast<std::uint32_t>(k);
        if (!from.tag[i].asleep()) copy_particle(from, i, to, i);
      });
      return;
    }
    *due_ = 0;
    sort(from, to, n, grid);
    lists_.build(to, n, grid, support, skin, interacts, team_);
  }

  template <class F>
  void move(const char* name, std::uint32_t n, const F& f) {
    for_each(name, n, f, tag_);
  }

 private:
  static constexpr std::size_t kSingleThreadBelow = 400;
  // Particles that a thread takes at once: some 10 us of work, so that little is left to wait for, with neighbours and
  // without.
  static constexpr std::size_t kChunk = 64, kCheapChunk = 1024;
  static constexpr std::align_val_t kAlign{64};

  bool asleep(std::size_t i) const { return tag_ != nullptr && tag_[i].asleep(); }

  // Sorts the particles by cell, by a stable counting sort; inactive particles have a cell of their own. What lasts of
  // them is put back into the state, and all of what sleeps, since no stage does that.
  void sort(const ParticleView& from, const ParticleView& to, std::uint32_t n, const CellGrid& grid) {
    const std::uint32_t cells = grid.cells() + 1;
    std::fill(start_, start_ + cells + 1, 0u);
    for (std::uint32_t i = 0; i < n; ++i) {
      cell_[i] = sort_cell(grid, from.tag[i], from.xV[i]);
      ++start_[cell_[i] + 1];
    }
    for (std::uint32_t c = 0; c < cells; ++c) start_[c + 1] += start_[c];
    for (std::uint32_t i = 0; i < n; ++i) copy_particle(from, i, to, start_[cell_[i]]++);
    for (std::uint32_t i = 0; i < n; ++i) {
      copy_lasting(to, i, from, i);
      if (to.tag[i].asleep()) copy_changing(to, i, from, i);
    }
    // start_[c] now is the end of cell c, that is the start of c + 1
    for (std::uint32_t c = cells; c > 0; --c) start_[c] = start_[c - 1];
    start_[0] = 0;
  }

  // Every stage calls this as it begins.
  void note(const char* name) {
    if (record_) launches_.emplace_back(name);
    if (times_ == nullptr) return;
    end_stage();
    stage_ = name;
  }
  void end_stage() {
    const auto now = std::chrono::steady_clock::now();
    if (stage_ != nullptr) add_launch(*times_, stage_, std::chrono::duration<double>(now - stage_begin_).count());
    stage_ = nullptr;
    stage_begin_ = now;
  }
  struct Free {
    void operator()(std::byte* p) const { ::operator delete(p, kAlign); }
  };
  ThreadTeam team_;
  std::vector<std::pair<std::string, std::size_t>> arrays_;
  std::vector<std::unique_ptr<std::byte, Free>> blocks_;
  std::vector<std::string> launches_;
  bool record_ = false;
  bool complete_ = false;  // true: launches_ are those of the last variant, which has all stages
  StageTimes* times_ = nullptr;
  const char* stage_ = nullptr;  // the one that runs while times are taken
  std::chrono::steady_clock::time_point stage_begin_;
  std::uint32_t *cell_ = nullptr, *start_ = nullptr, *due_ = nullptr;
  const Tag* tag_ = nullptr;  // of the particles as they are sorted; null where none may sleep
  NeighborLists lists_;
};

}  // namespace

std::unique_ptr<Simulation> make_cpu_simulation(const Scene& scene) {
  return std::make_unique<SimulationOn<Cpu>>(scene);
}

}  // namespace palp
