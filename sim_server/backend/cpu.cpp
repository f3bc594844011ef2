// The CPU back end: OpenMP loops over the same functors that the GPU runs.
#include <omp.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <new>

#include <fmt/format.h>

#include "sim_server/backend/make.h"
#include "sim_server/simulation_on.h"

namespace palp {
namespace {

class Cpu {
 public:
  template <class T>
  struct Mirror {
    T* host = nullptr;
    T* device = nullptr;
    std::size_t count = 0;
  };

  std::string name() const {
    return fmt::format("cpu, {} threads, {}", omp_get_max_threads(), sizeof(real) == 4 ? "float" : "double");
  }
  const std::vector<std::pair<std::string, std::size_t>>& arrays() const { return arrays_; }
  const std::vector<std::string>& launches() const { return launches_; }

  template <class T>
  T* allocate(const std::string& name, std::size_t count) {
    constexpr std::size_t kAlign = 64;
    const std::size_t bytes = std::max<std::size_t>(1, count) * sizeof(T);
    arrays_.emplace_back(name, bytes);
    blocks_.emplace_back(static_cast<std::byte*>(::operator new (bytes, std::align_val_t{kAlign})));
    T* p = reinterpret_cast<T*>(blocks_.back().get());
    std::uninitialized_value_construct_n(p, std::max<std::size_t>(1, count));
    return p;
  }
  template <class T>
  Mirror<T> mirror(const std::string& name, std::size_t count) {
    T* p = allocate<T>(name, count);
    return {p, p, count};
  }
  template <class T>
  void upload(T* to, const std::vector<T>& from) {
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
  template <class A>
  void begin_transfer(const Mirror<A>&, const Mirror<A>&) {}
  bool transfer_done() const { return true; }

  template <class F>
  void execute(F&& work) {
    record_ = launches_.empty();
    work();
    record_ = false;
  }

  void forget() {}

  template <class F>
  void for_each(const char* name, std::uint32_t n, const F& f) {
    note(name);
#pragma omp parallel for schedule(static) if (n > kSerial)
    for (std::int64_t i = 0; i < std::int64_t(n); ++i) f(static_cast<std::uint32_t>(i));
  }
  template <class F>
  void for_each_team(const char* name, std::uint32_t n, const F& f) {
    note(name);
#pragma omp parallel for schedule(dynamic, 64) if (n > kSerial)
    for (std::int64_t i = 0; i < std::int64_t(n); ++i) f(static_cast<std::uint32_t>(i), SerialTeam{});
  }
  template <class F>
  void for_each_block(const char* name, std::uint32_t n, const F& f) {
    note(name);
    for (std::uint32_t i = 0; i < n; ++i) f(i, SerialTeam{});
  }

  const std::uint32_t* allocate_sort(std::uint32_t particles, std::uint32_t cells) {
    cell_ = allocate<std::uint32_t>("sort cell", particles);
    place_ = allocate<std::uint32_t>("sort place", particles);
    start_ = allocate<std::uint32_t>("sort start", cells + 1);
    return start_;
  }

  // Stable counting sort by cell.
  void sort_into_cells(const ParticleView& from, const ParticleView& to, std::uint32_t n, const CellGrid& grid) {
    note("sort");
    const std::uint32_t cells = grid.cells();
    std::fill(start_, start_ + cells + 1, 0u);
    for (std::uint32_t i = 0; i < n; ++i) {
      cell_[i] = grid.index_of(from.xV[i].xyz());
      ++start_[cell_[i] + 1];
    }
    for (std::uint32_t c = 0; c < cells; ++c) start_[c + 1] += start_[c];
    for (std::uint32_t i = 0; i < n; ++i) place_[i] = start_[cell_[i]]++;
    // start_[c] now is the end of cell c, that is the start of c + 1
    for (std::uint32_t c = cells; c > 0; --c) start_[c] = start_[c - 1];
    start_[0] = 0;
    for (std::uint32_t i = 0; i < n; ++i) copy_particle(from, i, to, place_[i]);
  }

 private:
  static constexpr std::uint32_t kSerial = 256;  // below this, waking the other threads costs more than it brings

  void note(const char* name) {
    if (record_) launches_.emplace_back(name);
  }
  struct Free {
    void operator()(std::byte* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  std::vector<std::pair<std::string, std::size_t>> arrays_;
  std::vector<std::unique_ptr<std::byte, Free>> blocks_;
  std::vector<std::string> launches_;
  bool record_ = false;
  std::uint32_t *cell_ = nullptr, *place_ = nullptr, *start_ = nullptr;
};

}  // namespace

std::unique_ptr<Simulation> make_cpu_simulation(const Scene& scene) {
  return std::make_unique<SimulationOn<Cpu>>(scene);
}

}  // namespace palp
