// Threads that share out loops.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>

#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>

#include "sim_server/threads/float_mode.h"
#include "sim_server/threads/thread_team.h"
#include "tests/support/eventually.h"
#include "tests/support/seed.h"

namespace palp::test::thread_team_test {
namespace {

constexpr auto kNap = std::chrono::milliseconds(2);

// A loop of 8 chunks whose helpers nap in each of theirs. Returns whether any helper took part.
bool nap_in_helpers(ThreadTeam& team, bool nap) {
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<int> helped{0};
  team.for_each(8, 1, [&](std::size_t) {
    std::this_thread::sleep_for(std::chrono::microseconds(100));
    if (std::this_thread::get_id() == caller) return;
    ++helped;
    if (nap) std::this_thread::sleep_for(10 * kNap);
  });
  return helped > 0;
}

TEST(ThreadTeam, DoesEachOnceWhateverTheChunks) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  for (const int threads : {1, 2, 5, 16}) {
    ThreadTeam team(threads);
    EXPECT_EQ(team.threads(), threads);
    for (int round = 0; round < 300; ++round) {
      const std::size_t n = random() % 3000, chunk = 1 + random() % 400;
      std::vector<int> done(n, 0);
      team.for_each(n, chunk, [&](std::size_t i) { ++done[i]; });
      EXPECT_EQ(std::accumulate(done.begin(), done.end(), std::size_t{0}), n);
      EXPECT_EQ(std::count(done.begin(), done.end(), 1), static_cast<std::ptrdiff_t>(n));
      team.in_chunks(n, chunk, [&](std::size_t begin, std::size_t end) {
        EXPECT_TRUE(begin % chunk == 0 && end - begin <= chunk) << begin << " " << end;
      });
      team.adapt();
    }
  }
}

// Else the caller waits for a helper that waits for a processor.
TEST(ThreadTeam, HelpersAreAsNiceAsTheirCaller) {
  std::thread caller([] {
    const int nicer = std::min(getpriority(PRIO_PROCESS, 0) + 3, 19);
    ThreadTeam team(3);
    ASSERT_EQ(setpriority(PRIO_PROCESS, 0, nicer), 0);
    const std::thread::id own = std::this_thread::get_id();
    EXPECT_TRUE(eventually([&] {
      std::atomic<int> alike{0};
      team.for_each(8, 1, [&](std::size_t) {
        std::this_thread::sleep_for(std::chrono::microseconds(100));
        if (std::this_thread::get_id() != own && getpriority(PRIO_PROCESS, 0) == nicer) ++alike;
      });
      team.adapt();
      return alike > 0;
    }));
  });
  caller.join();
}

void keep_busy(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) {
  }
}

// The share of the loops that a helper took part in before which it had slept. step_ends: after each loop.
double share_slept(bool step_ends) {
  ThreadTeam team(2);
  const std::thread::id own = std::this_thread::get_id();
  int loops = 0;
  long first = -1, last = 0;  // how often it had slept
  for (int loop = 0; loop < 200; ++loop) {
    bool helped = false;
    team.for_each(8, 1, [&](std::size_t) {
      keep_busy(std::chrono::microseconds(20));
      if (std::this_thread::get_id() == own) return;
      helped = true;
      rusage used;
      getrusage(RUSAGE_THREAD, &used);
      last = used.ru_nvcsw;
      if (first < 0) first = last;
    });
    loops += helped ? 1 : 0;
    if (step_ends) team.adapt();
    keep_busy(std::chrono::microseconds(200));  // longer than threads are patient between steps
  }
  return loops > 50 ? static_cast<double>(last - first) / loops : 0.5;
}

// To be woken takes as long as a small loop, and what computes beside a step comes in when one of its threads sleeps.
TEST(ThreadTeam, HelpersSleepBetweenStepsAndNotWithinThem) {
  EXPECT_TRUE(eventually([] { return share_slept(false) < 0.2; }));
  EXPECT_TRUE(eventually([] { return share_slept(true) > 0.8; }));
}

TEST(ThreadTeam, HelpersTakePart) {
  ThreadTeam team(3);
  EXPECT_TRUE(eventually([&] { return nap_in_helpers(team, false); }));
}

// Returns whether a helper took part in a loop, all of whose products of two small numbers were subnormal (or, where
// they are flushed, zero).
bool multiply_in_helpers(ThreadTeam& team, bool flushed) {
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<int> helped{0};
  team.for_each(8, 1, [&](std::size_t) {
    volatile float small = 1e-30F;
    const float product = small * 1e-10F;
    EXPECT_EQ(product == 0.0F, flushed);
    std::this_thread::sleep_for(std::chrono::microseconds(100));
    if (std::this_thread::get_id() != caller) ++helped;
  });
  return helped > 0;
}

TEST(ThreadTeam, HelpersTreatSubnormalNumbersAsTheCallerDoes) {
#if !defined(__SSE2__)
  GTEST_SKIP() << "subnormal numbers are left as they are";
#endif
  ThreadTeam team(3);
  EXPECT_TRUE(eventually([&] { return multiply_in_helpers(team, false); }));
  {
    const FlushSubnormals flush;
    EXPECT_TRUE(eventually([&] { return multiply_in_helpers(team, true); }));
  }
  EXPECT_TRUE(eventually([&] { return multiply_in_helpers(team, false); }));
}

TEST(ThreadTeam, LeavesOutHelpersThatAreInTheWayAndTriesThemAgain) {
  ThreadTeam team(3);
  ASSERT_TRUE(eventually([&] {
    team.adapt();
    return nap_in_helpers(team, true);
  }));
  // with each pause helpers take part in a smaller share of the loops
  int helped = 0;
  constexpr int kLoops = 400;
  for (int loop = 0; loop < kLoops; ++loop) {
    helped += nap_in_helpers(team, true) ? 1 : 0;
    team.adapt();
  }
  EXPECT_LT(helped, kLoops / 10);
  EXPECT_TRUE(eventually([&] {
    team.adapt();
    return nap_in_helpers(team, false);
  }));
}

TEST(ThreadTeam, PassesAnExceptionOnAndGoesOn) {
  ThreadTeam team(4);
  for (int round = 0; round < 50; ++round) {
    const auto fail = [](std::size_t i) {
      if (i % 50 == 7) throw std::runtime_error("7");
    };
    EXPECT_THROW(team.for_each(1000, 10, fail), std::runtime_error);
    int sum = 0;
    team.for_each(100, 100, [&](std::size_t) { ++sum; });
    EXPECT_EQ(sum, 100);
  }
}

// The states of this process's threads: R runs, S sleeps.
std::multiset<char> thread_states() {
  std::multiset<char> states;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream file(task.path() / "stat");
    std::string line;
    std::getline(file, line);
    if (const std::size_t at = line.rfind(") "); at != std::string::npos) states.insert(line[at + 2]);
  }
  return states;
}

// A thread that spins keeps a core from whom it waits for.
TEST(ThreadTeam, SleepsWhereThereIsNothingToDo) {
  ThreadTeam team(5);
  team.for_each(1000, 1, [](std::size_t) {});
  // this one alone runs; a sanitizer has threads of its own, which sleep, too
  EXPECT_TRUE(eventually([] { return thread_states().count('R') == 1; }));
}

TEST(AvailableThreads, AreThoseThatTheUserAsksFor) {
  const char* before = std::getenv("OMP_NUM_THREADS");
  const std::string kept = before != nullptr ? before : "";
  setenv("OMP_NUM_THREADS", "3", 1);
  EXPECT_EQ(available_threads(), 3);
  setenv("OMP_NUM_THREADS", "none", 1);
  EXPECT_GE(available_threads(), 1);
  if (before != nullptr)
    setenv("OMP_NUM_THREADS", kept.c_str(), 1);
  else
    unsetenv("OMP_NUM_THREADS");
}

// taskset and containers leave a process some of a machine's processors; more threads than those get in each other's
// way.
TEST(AvailableThreads, AreNoMoreThanTheProcessorsThatMayBeUsed) {
  cpu_set_t before, one;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  CPU_ZERO(&one);
  CPU_SET(sched_getcpu(), &one);
  ASSERT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
  const int usable = usable_processors();
  ASSERT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
  EXPECT_EQ(usable, 1);
  EXPECT_EQ(usable_processors(), CPU_COUNT(&before));
}

}  // namespace
}  // namespace palp::test::thread_team_test
