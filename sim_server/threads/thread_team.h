// Threads that share out loops. On a machine whose cores have other work the caller is never slower with them than
// alone: it takes what nobody has begun, waits for nobody who has not begun, and leaves the others asleep for a while
// when waiting for them costs more than they bring.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace palp {

// Returns how many processors this thread may run on, 1 or more: on a machine whose processors are shared out, by
// taskset or a container's set of them, fewer than it has.
int usable_processors();

// Returns the number of threads to use: OMP_NUM_THREADS where that is set, else usable_processors().
int available_threads();

// Particles that a thread takes at once, where the work on each is small and much the same.
inline constexpr std::size_t kParticlesAtOnce = 512;

// One thread makes a team and calls it. What is computed does not depend on who computes it, so that results are the
// same bits for any number of threads.
class ThreadTeam {
 public:
  explicit ThreadTeam(int threads = available_threads());
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  int threads() const { return static_cast<int>(helpers_.size()) + 1; }

  // Calls f(begin, end) for runs of `chunk` values, the last one shorter, that together cover 0 to n; each run by one
  // thread. Throws the first exception that f throws.
  template <class F>
  void in_chunks(std::size_t n, std::size_t chunk, const F& f) {
    const auto call = [](const void* work, std::size_t begin, std::size_t end) {
      (*static_cast<const F*>(work))(begin, end);
    };
    share_out({call, &f, n, chunk});
  }

  // Calls f(i) for each i below n, in the same way.
  template <class F>
  void for_each(std::size_t n, std::size_t chunk, const F& f) {
    in_chunks(n, chunk, [&f](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) f(i);
    });
  }

  // To be called after each step: judges by the loops since the last call how many helpers are worth their cost, and
  // makes them as nice as the caller is, for whose work it waits when something else runs in their place. Until the
  // next loop helpers may sleep; within a step they stay awake from one loop to the next.
  void adapt();

 private:
  struct Job {
    void (*call)(const void* work, std::size_t begin, std::size_t end) = nullptr;
    const void* work = nullptr;
    std::size_t n = 0, chunk = 1;
    unsigned mode = 0;  // float_mode() of the caller
  };

  void share_out(const Job& job);
  bool run_chunk();  // false: none is left
  void help(int index);
  void run(std::uint64_t chunk);
  void wait_for_helpers(std::uint32_t chunks);

  Job job_;
  std::atomic<std::uint64_t> left_{0};    // number of the loop in the upper half; chunks that nobody has begun
  std::atomic<std::uint32_t> loop_{0};    // number of the loop; helpers sleep on it
  std::atomic<std::uint32_t> helped_{0};  // chunks of this loop that helpers have done
  std::atomic<int> invited_{0};           // helpers that take part
  std::atomic<int> niceness_{0};          // of the caller
  std::atomic<bool> within_step_{false};  // a loop has begun since the last call of adapt()
  std::atomic<bool> stop_{false};
  std::mutex failure_mutex_;
  std::exception_ptr failure_;
  double gained_ = 0, lost_ = 0;  // time that helpers saved, and that the caller waited for them: sums that fade [s]
  int pause_ = 0;                 // calls of adapt() until more helpers are tried again
  int next_pause_ = 0;
  int good_ = 0;  // calls of adapt() since helpers were last sent to sleep
  std::vector<std::thread> helpers_;
};

}  // namespace palp
