// The loop as it is run: on a clock, between mailboxes and threads, into the flight log.
#include "haptic_bridge/run.h"

#include <csignal>
#include <cstddef>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/futex.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include "haptic_bridge/device/simulated.h"
#include "idl/clock.h"
#include "tests/haptic_bridge/loop/fake_server.h"
#include "tests/support/count_allocations.h"
#include "tests/support/count_locks.h"

namespace palp::test::run_test {
namespace {

LoopConfig config_for_tests() {
  LoopConfig config;
  config.own_session = kBridgeSession;
  return config;
}

// Does the server's work inside the loop's own reads, so that one thread is enough and time is exact.
class ServedArm final : public HapticDevice {
 public:
  explicit ServedArm(LoopPorts& ports)
      : ports_(ports),
        arm_(ArmModel{}, HandScript{}, at_rest({0, 0, -0.003}, Eigen::Quaterniond::Identity()),
             at_rest({0, 0, -0.003}, Eigen::Quaterniond::Identity())) {}
  const DeviceInfo& info() const noexcept override { return arm_.info(); }
  void show(LoopState state) noexcept override { arm_.show(state); }
  bool read(std::int64_t now, DeviceReading& out) noexcept override {
    if (misdeed != nullptr) misdeed();
    DeviceSample sample;
    if (ports_.outgoing.take(sample)) {
      IncomingProxy in{answer(sample, 5, ++sequence_), now};
      test::SpringWall{}.touch(in.sample);
      ports_.incoming.put(in);
    }
    return arm_.read(now, out);
  }
  bool write(const Wrench<double>& w) noexcept override {
    written = w;
    return arm_.write(w);
  }

  void (*misdeed)() = nullptr;  // in each read
  Wrench<double> written = zero_wrench();

 private:
  LoopPorts& ports_;
  SimulatedDevice arm_;
  std::uint64_t sequence_ = 0;
};

// A loop that drives it.
struct ServedLoop {
  explicit ServedLoop(std::size_t logged) : log(logged) {}
  LoopFault run(Clock& clock, std::uint64_t ticks) { return run_loop(loop, clock, *ports, log, stop_, ticks); }
  // In lock-step; time goes on where it was.
  LoopFault run(std::uint64_t ticks) { return run(lock_step_, ticks); }

  std::unique_ptr<LoopPorts> ports = std::make_unique<LoopPorts>();
  ServedArm arm{*ports};
  HapticLoop loop{config_for_tests(), arm};
  FlightLog log;

 private:
  LockStepClock lock_step_;
  std::atomic<bool> stop_{false};
};

TEST(Run, AllocatesNothingInTheLoop) {
  ServedLoop served(500);  // goes round twice
  start_counting_allocations();
  served.run(1200);
  EXPECT_EQ(stop_counting_allocations(), 0u);
  EXPECT_EQ(served.loop.report().state, LoopState::engaged);
  EXPECT_GT(served.loop.report().peak_force, 0.5);

  start_counting_allocations();
  const std::vector<int> seen(100);
  EXPECT_EQ(stop_counting_allocations(), 1u);  // the count does count
}

void lock_and_unlock() {
  static std::mutex mutex;
  const std::lock_guard<std::mutex> lock(mutex);
}

TEST(Run, TakesNoLockInTheLoop) {
  if (!kCountsLocks) GTEST_SKIP() << "the sanitizers count locks themselves";
  constexpr std::uint64_t kTicks = 1200;
  for (const bool honest : {true, false}) {
    ServedLoop served(500);
    if (!honest) served.arm.misdeed = lock_and_unlock;
    start_counting_locks();
    served.run(kTicks);
    EXPECT_EQ(stop_counting_locks(), honest ? 0 : kTicks);
    EXPECT_EQ(served.loop.report().state, LoopState::engaged);
  }
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// From here on any system call but sleeping, waking others and ending kills the process.
void allow_only_the_loops_system_calls() {
  const auto allow = [](unsigned number) {
    return std::array<sock_filter, 2>{sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, number, 0, 1),
                                      sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
  };
  std::vector<sock_filter> filter{BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr))};
  for (const unsigned call : {__NR_clock_nanosleep, __NR_clock_gettime, __NR_exit_group})
    for (const sock_filter& f : allow(call)) filter.push_back(f);
  // a futex wakes; it must not wait, as one does for a lock that another thread holds
  filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_futex, 0, 4));
  filter.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args[1])));
  filter.push_back(BPF_STMT(BPF_ALU | BPF_AND | BPF_K, static_cast<std::uint32_t>(FUTEX_CMD_MASK)));
  filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, FUTEX_WAKE, 0, 1));
  filter.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  filter.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS));
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0)
    _exit(2);
}

void call_the_system() { (void)getppid(); }
void wait_on_a_futex() {
  static std::uint32_t word = 0;
  syscall(SYS_futex, &word, FUTEX_WAIT_PRIVATE, 1, nullptr, nullptr, 0);  // 0 is not 1: it returns at once
}

TEST(Run, MakesNoSystemCallButTheClocks) {
  for (void (*const misdeed)() : {static_cast<void (*)()>(nullptr), &call_the_system, &wait_on_a_futex}) {
    ServedLoop served(500);
    served.arm.misdeed = misdeed;
    RealClock clock;
    Heartbeat heartbeat;
    served.ports->heartbeat = &heartbeat;
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      allow_only_the_loops_system_calls();
      served.run(clock, 400);
      _exit(served.loop.report().ticks == 400 && !heartbeat.take_if_silent(now_ns() + 1'000'000'000, 1) ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    if (misdeed == nullptr) {
      EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
    } else {
      EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGSYS) << "the filter filters nothing";
    }
  }
}
#endif

TEST(Run, LeavesTheDeviceWithoutForceHoweverItEnds) {
  ServedLoop served(4000);
  EXPECT_EQ(served.run(2000), LoopFault::none);
  EXPECT_GT(served.log.at(served.log.size() - 1).sent.force.norm(), 0.5);
  EXPECT_EQ(served.arm.written.force, Eigen::Vector3d::Zero());
}

TEST(Run, ALoopThatNobodyGuardsEndsWithoutForceInItsNextTick) {
  ServedLoop served(4000);
  ASSERT_EQ(served.run(2000), LoopFault::none);
  served.ports->unguarded = true;
  EXPECT_EQ(served.run(2000), LoopFault::unguarded);
  ASSERT_EQ(served.log.size(), 2001u);
  EXPECT_GT(served.log.at(1999).sent.force.norm(), 0.5);
  EXPECT_EQ(served.log.at(2000).sent.force, Eigen::Vector3d::Zero());
  EXPECT_EQ(served.log.at(2000).state, LoopState::fault);
  EXPECT_NE(std::string(to_string(LoopFault::unguarded)).find("the supervisor has died"), std::string::npos);
}

// A clock on which something stops the whole process for a while, and the supervisor sees it.
class HaltingClock final : public Clock {
 public:
  HaltingClock(Heartbeat& heartbeat, std::int64_t t_halt_ns) : heartbeat_(heartbeat), t_halt_ns_(t_halt_ns) {}
  std::int64_t now_ns() noexcept override { return clock_.now_ns(); }
  void sleep_until(std::int64_t t_ns) noexcept override {
    clock_.sleep_until(t_ns);
    if (taken || clock_.now_ns() < t_halt_ns_) return;
    clock_.sleep_until(t_ns + 60 * kMillisecond);
    taken = heartbeat_.take_if_silent(clock_.now_ns(), 50 * kMillisecond);
  }
  bool taken = false;

 private:
  LockStepClock clock_;
  Heartbeat& heartbeat_;
  std::int64_t t_halt_ns_;
};

TEST(Run, ALoopThatWasTakenForDeadEndsWithoutForceAndSaysWhy) {
  ServedLoop served(4000);
  Heartbeat heartbeat;
  served.ports->heartbeat = &heartbeat;
  HaltingClock clock(heartbeat, 4'000'000'000);
  EXPECT_EQ(served.run(clock, 4000), LoopFault::taken_for_dead);
  EXPECT_TRUE(clock.taken);
  ASSERT_GT(served.log.size(), 2900u);
  EXPECT_GT(served.log.at(served.log.size() - 2).sent.force.norm(), 0.5);
  const TickRecord& last = served.log.at(served.log.size() - 1);
  EXPECT_EQ(last.state, LoopState::fault);
  EXPECT_EQ(last.sent.force, Eigen::Vector3d::Zero());
  EXPECT_EQ(served.loop.sample().flags & (kHealthy | kEngaged), 0u);
  EXPECT_NE(std::string(to_string(served.loop.report().fault)).find("powered the arm off"), std::string::npos);
}

TEST(Run, RunsTheSameTwiceOnTheLockStepClock) {
  std::vector<double> forces[2];
  for (auto& out : forces) {
    ServedLoop served(2000);
    served.run(2000);
    for (std::size_t i = 0; i < served.log.size(); ++i) out.push_back(served.log.at(i).sent.force.z());
    EXPECT_EQ(served.ports->lateness.max_us(), 0);
    EXPECT_EQ(served.loop.report().missed, 0u);
  }
  EXPECT_EQ(forces[0], forces[1]);
}

// Time that passes as the test says.
class SlipClock final : public Clock {
 public:
  std::int64_t now_ns() noexcept override { return now; }
  void sleep_until(std::int64_t t) noexcept override {
    now = std::max(now, t) + (++sleeps == 10 ? 3'600'000 : 50'000);
    deadlines_off += (t - first_deadline) % kMillisecond != 0;
    if (sleeps == 1) first_deadline = t;
  }
  std::int64_t now = 5'000'000'000, first_deadline = 5'001'000'000;
  int sleeps = 0;
  int deadlines_off = 0;
};

// Every look at it costs 30 us.
class SlowClock final : public Clock {
 public:
  std::int64_t now_ns() noexcept override { return now_ += 30'000; }
  void sleep_until(std::int64_t t) noexcept override { now_ = std::max(now_, t - 30'000); }
  std::int64_t cpu_ns() noexcept override { return now_ / 100; }

 private:
  std::int64_t now_ = 1'000'000'000;
};

TEST(Run, TellsWhatATickCosts) {
  auto ports = std::make_unique<LoopPorts>();
  PuppetDevice device;
  HapticLoop loop(config_for_tests(), device);
  FlightLog log(100);
  SlowClock clock;
  std::atomic<bool> stop{false};
  run_loop(loop, clock, *ports, log, stop, 50);
  EXPECT_EQ(ports->duration.count(), 50u);
  EXPECT_EQ(ports->duration.max_us(), 30);
  EXPECT_EQ(log.at(7).duration_ns, 30'000);
  EXPECT_NEAR(static_cast<double>(ports->cpu_ns), 50 * 1e4, 2e3);
}

TEST(Run, SkipsMissedPeriodsAndKeepsItsGrid) {
  auto ports = std::make_unique<LoopPorts>();
  PuppetDevice device;
  HapticLoop loop(config_for_tests(), device);
  FlightLog log(100);
  SlipClock clock;
  std::atomic<bool> stop{false};
  run_loop(loop, clock, *ports, log, stop, 20);
  EXPECT_EQ(loop.report().missed, 3u);
  EXPECT_EQ(log.at(9).missed, 3u);
  EXPECT_EQ(log.at(10).lateness_ns, 50'000);
  EXPECT_EQ(log.at(19).t_ns - log.at(0).t_ns, (19 + 3) * kMillisecond);
  EXPECT_EQ(clock.deadlines_off, 0);
  EXPECT_EQ(ports->lateness.max_us(), 3600);
}

TEST(Run, EndsOnAFaultWithTheDeviceAtRest) {
  auto ports = std::make_unique<LoopPorts>();
  PuppetDevice device;
  device.readable = false;
  HapticLoop loop(config_for_tests(), device);
  FlightLog log(100);
  LockStepClock clock;
  std::atomic<bool> stop{false};
  EXPECT_EQ(run_loop(loop, clock, *ports, log, stop), LoopFault::device_read);
  EXPECT_EQ(log.at(log.size() - 1).state, LoopState::fault);
  DeviceSample sample;
  EXPECT_FALSE(ports->outgoing.take(sample));  // never read, never sent
}

TEST(Run, MeetsTheBusThreadsWithoutARace) {
  // the loop, a sender that is woken, a receiver that answers, and somebody who watches: for the thread sanitizer
  auto ports = std::make_unique<LoopPorts>();
  PuppetDevice device;
  LoopConfig config = config_for_tests();
  config.period_ns = 200'000;
  config.fresh_ns = 10'000'000;
  config.ramp_up = 0.02;
  HapticLoop loop(config, device);
  FlightLog log(4000);
  std::atomic<bool> stop{false}, done{false};
  std::uint64_t sent = 0, seen = 0;
  std::thread server([&] {
    DeviceSample sample;
    while (!done) {
      if (!ports->sample_ready.wait_for(20'000'000) || !ports->outgoing.take(sample)) continue;
      IncomingProxy in{answer(sample, 5, ++sent), now_ns()};
      in.sample.wrench.force = {0, 0, 1};
      ports->incoming.put(in);
    }
  });
  std::thread watcher([&] {
    LoopReport report;
    while (!done) {
      if (ports->report.take(report)) seen = report.ticks;
      (void)ports->lateness.quantile_us(0.99);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  RealClock clock;
  run_loop(loop, clock, *ports, log, stop, 3000);
  done = true;
  server.join();
  watcher.join();
  EXPECT_GT(sent, 100u);
  EXPECT_GT(seen, 0u);
  EXPECT_GT(loop.report().verdicts[0], 100u);
}

TEST(Wakeup, WakesOnceForWakesThatPiledUp) {
  Wakeup w;
  EXPECT_FALSE(w.wait_for(1'000'000));
  for (int i = 0; i < 5; ++i) w.wake();
  EXPECT_TRUE(w.wait_for(1'000'000));
  EXPECT_FALSE(w.wait_for(1'000'000));
}

TEST(Realtime, CountsTheCpuTimeOfTheCallingThread) {
  RealClock clock;
  const std::int64_t before = clock.cpu_ns();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const std::int64_t slept = clock.cpu_ns();
  EXPECT_LT(slept - before, 40'000'000);
  const std::int64_t until = now_ns() + 20'000'000;
  while (now_ns() < until) {
  }
  EXPECT_GT(clock.cpu_ns(), slept);
}

TEST(Realtime, MeasuresHowLateThisMachineIs) {
  const Lateness l = measure_lateness({0, -1, false}, kMillisecond, 0.2);
  EXPECT_EQ(l.seconds, 0.2);
  EXPECT_GT(l.p50_us, 0);
  EXPECT_LE(l.p50_us, l.p999_us);
  EXPECT_LE(l.p999_us, l.max_us);
}

TEST(Realtime, SaysHonestlyWhatItGot) {
  RealtimeReport report;
  std::thread([&] { make_realtime({0, 5000, false}, report); }).join();
  EXPECT_FALSE(report.fifo);
  EXPECT_EQ(report.cpu, -1);
  EXPECT_NE(report.trouble.find("core 5000 was refused"), std::string::npos);
  EXPECT_EQ(report.line().find("ordinary scheduling, memory not locked, any core of "), 0u) << report.line();
}

}  // namespace
}  // namespace palp::test::run_test
