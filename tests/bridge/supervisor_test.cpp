// Whatever ends the bridge, the arm is powered off from outside.
#include "haptic_bridge/supervisor.h"

#include <csignal>
#include <thread>

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "idl/clock.h"

namespace palp {
namespace {

using namespace std::chrono_literals;

// What two processes see.
struct Shared {
  std::atomic<std::int64_t> t_off_ns{0};   // when the arm was powered off
  std::atomic<std::int64_t> t_dead_ns{0};  // when the bridge was about to end
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
      Supervisor supervisor(power_off());
      shared_.supervisor = supervisor.pid();
      life(supervisor);
      shared_.t_dead_ns = now_ns();
      raise(SIGKILL);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return status;
  }
  bool off_within(std::chrono::milliseconds time) {
    for (const std::int64_t end = now_ns() + time.count() * 1'000'000; now_ns() < end;) {
      if (shared_.t_off_ns != 0) return true;
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
  ASSERT_TRUE(off_within(2000ms));
  EXPECT_LT(shared_.t_off_ns - shared_.t_dead_ns, 50'000'000);
}

TEST_F(SupervisorTest, ALoopThatHangsLosesItsArm) {
  bridge([&](Supervisor& s) {
    shared_.t_dead_ns = now_ns();
    s.heartbeat().beat(now_ns());
    while (shared_.t_off_ns == 0 && now_ns() - shared_.t_dead_ns < 3'000'000'000) std::this_thread::sleep_for(1ms);
  });
  ASSERT_NE(shared_.t_off_ns, 0);
}

TEST_F(SupervisorTest, ALoopThatGoesOnAfterAHangHearsThatItsArmIsOff) {
  Supervisor supervisor(power_off());
  EXPECT_TRUE(supervisor.heartbeat().beat(now_ns()));
  ASSERT_TRUE(off_within(2000ms));
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
}  // namespace palp
