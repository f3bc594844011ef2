// Whatever ends the bridge, the arm is powered off from outside.
#include "haptic_bridge/guard/supervisor.h"

#include <csignal>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "idl/clock.h"

namespace palp::test {
namespace {

using namespace std::chrono_literals;

// The times and the supervisor's process id, in memory that both processes see.
struct Shared {
  std::atomic<std::int64_t> t_off_ns{0};   // when the arm was powered off
  std::atomic<std::int64_t> t_dead_ns{0};  // when the bridge was about to end
  std::atomic<std::int64_t> t_saved_ns{0};
  std::atomic<int> supervisor{0};
};

class SupervisorTest : public ::testing::Test {
 protected:
  Shared& shared_ =
      *new (mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) Shared;

  std::function<void()> power_off() {
    return [this] { shared_.t_off_ns = now_ns(); };
  }
  // Runs a bridge that lives as the test says; returns how it ended.
  int bridge(const std::function<void(Supervisor&)>& life) {
    const pid_t child = fork();
    if (child == 0) {
      Supervisor supervisor(power_off(), [this] {
        shared_.t_saved_ns = now_ns();
        return std::string("what was logged is saved");
      });
      shared_.supervisor = supervisor.pid();
      life(supervisor);
      shared_.t_dead_ns = now_ns();
      raise(SIGKILL);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return status;
  }
  static bool comes(const std::atomic<std::int64_t>& t_ns) {
    for (const std::int64_t end = now_ns() + 2'000'000'000; now_ns() < end;) {
      if (t_ns != 0) return true;
      std::this_thread::sleep_for(1ms);
    }
    return false;
  }
};

TEST_F(SupervisorTest, ABridgeThatIsKilledLeavesAnArmWithoutPower) {
  bridge([](Supervisor& s) {
    for (int i = 0; i < 20; ++i) {
      s.heartbeat().beat(now_ns());
      std::this_thread::sleep_for(1ms);
    }
  });
  ASSERT_TRUE(comes(shared_.t_off_ns));
  EXPECT_LT(shared_.t_off_ns - shared_.t_dead_ns, 50'000'000);
  EXPECT_TRUE(comes(shared_.t_saved_ns));
}

// A signal mostly finds a thread that allocates and frees with the allocator's lock in its hands.
TEST_F(SupervisorTest, WhatWasLoggedIsSavedWhenTheThreadThatDiesHoldsTheAllocatorsLock) {
  for (int round = 0; round < 10; ++round) {
    shared_.t_saved_ns = 0;
    const int status = bridge([](Supervisor&) {
      std::signal(SIGSEGV, SIG_DFL);  // a sanitizer's handler may need the lock, too
      std::thread([self = pthread_self()] {
        std::this_thread::sleep_for(50ms);
        pthread_kill(self, SIGSEGV);
      }).detach();
      std::vector<std::vector<char>> blocks(100);
      for (std::size_t i = 0;; ++i) blocks[i % blocks.size()] = std::vector<char>(2000 + i % 7 * 5000);
    });
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGSEGV) << "status " << status << " in round " << round;
    EXPECT_TRUE(comes(shared_.t_saved_ns)) << "round " << round;
  }
}

TEST_F(SupervisorTest, ALoopThatHangsLosesItsArm) {
  bridge([&](Supervisor& s) {
    shared_.t_dead_ns = now_ns();
    s.heartbeat().beat(now_ns());
    while (shared_.t_off_ns == 0 && now_ns() - shared_.t_dead_ns < 3'000'000'000) std::this_thread::sleep_for(1ms);
  });
  ASSERT_NE(shared_.t_off_ns, 0);
  // it has died since: of one that was killed the heartbeat may end first, too
  EXPECT_TRUE(comes(shared_.t_saved_ns));
}

TEST_F(SupervisorTest, ALoopThatGoesOnAfterAHangHearsThatItsArmIsOff) {
  Supervisor supervisor(power_off());
  EXPECT_TRUE(supervisor.heartbeat().beat(now_ns()));
  ASSERT_TRUE(comes(shared_.t_off_ns));
  EXPECT_FALSE(supervisor.heartbeat().beat(now_ns()));
}

TEST_F(SupervisorTest, ALoopThatDoesNotRunYetOrNoMoreIsNoHang) {
  Supervisor supervisor(power_off());
  std::this_thread::sleep_for(150ms);
  EXPECT_EQ(shared_.t_off_ns, 0);
  supervisor.heartbeat().beat(now_ns());
  std::this_thread::sleep_for(20ms);
  supervisor.heartbeat().rest();
  std::this_thread::sleep_for(150ms);
  EXPECT_EQ(shared_.t_off_ns, 0);
}

TEST_F(SupervisorTest, ADeadOneIsNoticed) {
  Supervisor supervisor(power_off());
  EXPECT_TRUE(supervisor.alive());
  kill(supervisor.pid(), SIGKILL);
  siginfo_t ended{};
  waitid(P_PID, static_cast<id_t>(supervisor.pid()), &ended, WEXITED | WNOWAIT);
  EXPECT_FALSE(supervisor.alive());
  EXPECT_FALSE(supervisor.alive()) << "for good";
}

TEST_F(SupervisorTest, AStoppedOneIsNoticedAndDoesNotHoldTheBridgeBack) {
  pid_t pid = 0;
  {
    Supervisor supervisor(power_off());
    supervisor.heartbeat().beat(now_ns());
    pid = supervisor.pid();
    kill(pid, SIGSTOP);
    siginfo_t stopped{};
    waitid(P_PID, static_cast<id_t>(pid), &stopped, WSTOPPED | WNOWAIT);
    EXPECT_FALSE(supervisor.alive());
    EXPECT_FALSE(supervisor.alive()) << "for good";
    supervisor.heartbeat().rest();
  }
  EXPECT_NE(kill(pid, 0), 0) << "it goes on to its end";
  EXPECT_EQ(shared_.t_off_ns, 0);
}

TEST_F(SupervisorTest, EndsInOrderWithTheBridge) {
  {
    Supervisor supervisor(power_off());
    supervisor.heartbeat().beat(now_ns());
    ASSERT_EQ(kill(supervisor.pid(), 0), 0);
    kill(supervisor.pid(), SIGINT);  // Ctrl-C reaches all of a terminal's processes
    kill(supervisor.pid(), SIGTERM);
    supervisor.heartbeat().rest();
    shared_.supervisor = supervisor.pid();
  }
  EXPECT_EQ(shared_.t_off_ns, 0);
  EXPECT_NE(kill(shared_.supervisor, 0), 0) << "it lives on";
}

}  // namespace
}  // namespace palp::test
