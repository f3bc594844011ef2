// Runs a test that bounds times, and once more where the machine itself, not palp, stood still meanwhile.
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sched.h>

namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

// Finds the longest time that any core kept a thread waiting that goes before all others. Where a process may not go
// before others, a busy machine counts as one that stands still.
class Witness {
 public:
  Witness() {
    for (unsigned core = 0; core < std::max(1U, std::thread::hardware_concurrency()); ++core)
      threads_.emplace_back([this, core] { watch(core); });
  }
  ~Witness() {
    stop_ = true;
    for (std::thread& t : threads_) t.join();
  }
  Witness(const Witness&) = delete;
  Witness& operator=(const Witness&) = delete;
  std::chrono::duration<double, std::milli> longest() const { return steady_clock::duration(longest_.load()); }

 private:
  void watch(unsigned core) {
    cpu_set_t mine;
    CPU_ZERO(&mine);
    CPU_SET(core, &mine);
    sched_setaffinity(0, sizeof mine, &mine);
    const sched_param first{90};
    sched_setscheduler(0, SCHED_FIFO, &first);
    while (!stop_) {
      const auto due = steady_clock::now() + 2ms;
      std::this_thread::sleep_until(due);
      const steady_clock::rep late = (steady_clock::now() - due).count();
      for (steady_clock::rep before = longest_; late > before && !longest_.compare_exchange_weak(before, late);) {
      }
    }
  }

  std::atomic<bool> stop_{false};
  std::atomic<steady_clock::rep> longest_{0};
  std::vector<std::thread> threads_;
};

// A stand-still of this length spoils a test: what these tests measure has bounds of a few milliseconds, and two
// virtual machines that share a core take each other's time by tens.
constexpr auto kStill = 10ms;
constexpr int kTrials = 3;
constexpr const char* kTrial = "PALP_TEST_TRIAL";

}  // namespace

int main(int argc, char** argv) {
  const std::vector<char*> as_called(argv, argv + argc + 1);
  testing::InitGoogleTest(&argc, argv);
  int failed = 0;
  double still_ms = 0;
  {
    const Witness witness;
    failed = RUN_ALL_TESTS();
    still_ms = witness.longest().count();
  }
  if (failed == 0) return 0;
  std::cout << "the machine stood still for up to " << still_ms << " ms meanwhile" << std::endl;
  const char* before = std::getenv(kTrial);
  const int trial = before == nullptr ? 1 : std::atoi(before);
  if (still_ms < std::chrono::duration<double, std::milli>(kStill).count() || trial >= kTrials) return failed;
  std::cout << "that is too long to judge by: once more, trial " << trial + 1 << " of " << kTrials << std::endl;
  setenv(kTrial, std::to_string(trial + 1).c_str(), 1);
  execv("/proc/self/exe", as_called.data());
  return failed;
}
