// The flight log of a process that dies at a bad moment.
#include "haptic_bridge/log/crash_log.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "haptic_bridge/log/rerun.h"
#include "tests/support/files.h"

namespace palp::test::crash_log_test {
namespace {

// Allocates and frees until it is killed, so that a signal mostly finds it with the allocator's lock in its hands.
[[noreturn]] void allocate_until_killed(const std::string& path) {
  FlightLog log(10);
  TickRecord record;
  log.add(record, {});
  const LoopConfig config;
  const CrashLog crash_log(log, config, path);
  std::thread([] { pause(); }).detach();  // with one thread the allocator locks nothing
  std::vector<std::vector<char>> blocks(100);
  for (std::size_t i = 0;; ++i) blocks[i % blocks.size()] = std::vector<char>(2000 + i % 7 * 5000);
}

TEST(CrashLog, IsWrittenWhenTheThreadThatDiesHoldsTheAllocatorsLock) {
  const ScratchFolder folder;
  for (int round = 0; round < 10; ++round) {
    const std::string path = folder / ("log_" + std::to_string(round) + ".csv");
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) allocate_until_killed(path);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    ASSERT_EQ(kill(child, SIGSEGV), 0);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGSEGV) << "status " << status << " in round " << round;
    EXPECT_TRUE(std::filesystem::exists(path)) << "round " << round;
  }
}

}  // namespace
}  // namespace palp::test::crash_log_test
