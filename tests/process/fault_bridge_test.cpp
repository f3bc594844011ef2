// The rows of the fault table that are the bridge's own: it is late, stands still, or dies. The arm's power is taken by
// a process beside it, so those times are the simulated arm's.
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/process/fault_system.h"

namespace palp::test::fault_bridge_test {
namespace {

constexpr double kHang = 50, kLook = 10;  // of the supervisor [ms]
constexpr double kConnect = 40;           // to the arm, and one call, on a busy machine [ms]

const std::string kAsShipped = "overrun_ms = 5\nlate_ticks = 20";

class FaultBridge : public FaultSystem {
 protected:
  // From t until the supervisor's own connection switched the arm's power off; what it logged comes first, for it
  // empties the log.
  double ms_to_power_off(int device, std::int64_t t_ns) const {
    const double on_arm = time_of_call(device, "virtSetPowerOn 0 = 0");
    return ms_between(t_ns, opened_ns(device) + static_cast<std::int64_t>(std::llround(1e9 * on_arm)));
  }
};

// Each tick that is too late, whatever made it so, and each twentieth in a row that is somewhat late, has no force.
// Returns when such rows of twenty began and were cut while force was felt.
std::vector<std::pair<std::int64_t, std::int64_t>> judge_lateness(const Flight& flight) {
  std::vector<std::pair<std::int64_t, std::int64_t>> rows;
  int late_in_a_row = 0;
  std::int64_t t_first = 0;
  for (std::size_t i = 1; i < flight.size(); ++i) {
    const FlightTick& t = flight[i];
    late_in_a_row = t.late_ms > 0.5 ? late_in_a_row + 1 : 0;
    if (late_in_a_row == 1) t_first = t.t_ns;
    if (t.late_ms <= 5 && late_in_a_row < 20) continue;
    EXPECT_TRUE(t.cut && t.felt() == 0) << t.late_ms << " ms late, " << late_in_a_row << " in a row";
    if (late_in_a_row == 20 && flight[i - 1].felt() > 0.5) rows.emplace_back(t_first, t.t_ns);
    late_in_a_row = 0;
  }
  return rows;
}

TEST_F(FaultBridge, LateTicks) {
  Watcher& watcher = watch();
  start_weights();
  start_bridge_of(0, {"--profile", profile(0, kAsShipped)});
  // each tick takes longer than one period and a half and less than two; one that the machine makes longer begins the
  // row anew, so each chance is long and there are several
  std::vector<ArmEvent> slow;
  for (const double time : {2.0, 3.2, 4.4, 5.6}) {
    slow.push_back({"slow", time, 0.3, 0.0016, "virtGetSpeed"});
    slow.push_back({"dead_man_up", time + 0.4, 0.1, 0, ""});
  }
  start_arm(1, slow, kAsShipped);
  std::vector<std::int64_t> t_goes_on;
  for (int i = 0; i < 3; ++i) {
    watcher.status.clear();
    ASSERT_TRUE(carries(watcher, 0)) << said_by_all();
    const Urgent urgent;
    bridge(0).send_signal(SIGSTOP);
    std::this_thread::sleep_for(20ms);
    t_goes_on.push_back(now_ns());
    bridge(0).send_signal(SIGCONT);
    std::this_thread::sleep_for(50ms);
  }
  ASSERT_TRUE(watcher.sees([&] { return watcher.metric(name_of(1), "ticks") > 5000; })) << said_by_all();
  for (const int device : {0, 1}) EXPECT_EQ(bridge(device).stop(), 0) << said_by(device);
  const Flight stopped = flight(0), slowed = flight(1);
  for (const Flight* log : {&stopped, &slowed}) expect_limits_held(*log);

  judge_lateness(stopped);
  RowTimes overrun("tick 5 ms late: from when it could run", "bridge stopped for 20 ms");
  for (const std::int64_t t : t_goes_on) {
    const std::size_t i = tick_at(stopped, t);
    ASSERT_TRUE(i > 0 && i < stopped.size());
    if (stopped[i - 1].felt() < 0.5) continue;
    EXPECT_GT(stopped[i].late_ms, 15);
    EXPECT_EQ(stopped[i].felt(), 0);
    overrun.add(ms_between(t, stopped[i].t_ns), 5);
  }
  overrun.tell();

  RowTimes in_a_row("20 ticks in a row late by half a period: from the first", "slow of virtGetSpeed");
  for (const auto& [t_first, t_cut] : judge_lateness(slowed)) in_a_row.add(ms_between(t_first, t_cut), 20 * 2 + 5);
  in_a_row.tell();
}

TEST_F(FaultBridge, BridgesThatStandStillOrDie) {
  Watcher& watcher = watch();
  start_weights();
  start_arm(0, {});
  start_arm(1, {});
  ASSERT_TRUE(carries(watcher, 0) && carries(watcher, 1)) << said_by_all();
  const std::int64_t t_stop = now_ns();
  bridge(0).send_signal(SIGSTOP);
  const std::int64_t t_kill = now_ns();
  bridge(1).stop(SIGKILL);
  std::this_thread::sleep_for(200ms);
  const std::int64_t t_goes_on = now_ns();
  bridge(0).send_signal(SIGCONT);
  EXPECT_EQ(bridge(0).wait(5s), 1) << said_by(0);
  EXPECT_TRUE(eventually([&] { return said_by(1).find("the arm was powered off") != std::string::npos; }, kPatience))
      << said_by(1);

  RowTimes hang("bridge stands still: arm without power", "bridge stopped for 200 ms");
  hang.add(ms_to_power_off(0, t_stop), kHang + kLook + kConnect);
  hang.tell();
  RowTimes death("bridge dies: arm without power", "bridge killed (kill -9)");
  // the system first takes the memory of a dead process and then tells; its heart has stopped in any case
  death.add(ms_to_power_off(1, t_kill), kHang + kLook + kConnect);
  death.tell();

  // the log of the dead one is written for it
  EXPECT_TRUE(eventually([&] { return said_by(1).find("flight log was written") != std::string::npos; }, kPatience))
      << said_by(1);
  const Flight killed = flight(1);
  ASSERT_GT(killed.size(), 500u);
  expect_limits_held(killed);
  EXPECT_GT(killed.back().felt(), 3);

  // the bridge that goes on finds itself without an arm, says so, and leaves its whole log
  EXPECT_NE(said_by(0).find("the loop has stood still for 50 ms: the arm was powered off"), std::string::npos);
  EXPECT_NE(said_by(0).find("the loop stood still for so long that the supervisor powered the arm off"),
            std::string::npos)
      << said_by(0);
  EXPECT_TRUE(watcher.sees([&] { return watcher.has_event("the supervisor powered the arm off"); }));
  const Flight log = flight(0);
  ASSERT_GT(log.size(), 500u);
  expect_limits_held(log);
  EXPECT_EQ(log.back().state, "fault");
  EXPECT_EQ(log.back().felt(), 0);
  EXPECT_TRUE(log.back().cut);
  EXPECT_GT(log.back().t_ns, t_goes_on - 50'000'000);
  EXPECT_GT(log[log.size() - 2].felt(), 3) << "one tick is enough";
  tell_row("bridge goes on after that: no force, its run ends", "bridge stopped for 200 ms",
           std::max(0.0, ms_between(t_goes_on, log.back().t_ns)), 10);
  EXPECT_LT(ms_between(t_goes_on, log.back().t_ns), 10 + log.back().late_ms - 200);
}

// The process that the bridge has started, by its name; 0: none.
pid_t supervisor_of(pid_t bridge) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream file(entry.path() / "stat");
    std::string line;
    if (!std::getline(file, line) || line.find("(palp_supervisor)") == std::string::npos) continue;
    pid_t pid = 0, parent = 0;
    char state = 0;
    if (std::sscanf(line.c_str(), "%d (palp_supervisor) %c %d", &pid, &state, &parent) == 3 && parent == bridge)
      return pid;
  }
  return 0;
}

TEST_F(FaultBridge, SupervisorsThatDieOrStandStill) {
  struct Case {
    int signal;
    std::string row, provoked_by;
  };
  const std::array<Case, 2> cases{{{SIGKILL, "supervisor dies", "supervisor killed (kill -9)"},
                                   {SIGSTOP, "supervisor stands still", "supervisor stopped"}}};
  Watcher& watcher = watch();
  start_weights();
  start_arm(0, {});
  start_arm(1, {});
  for (int device = 0; device < 2; ++device) {
    const Case& c = cases[static_cast<std::size_t>(device)];
    SCOPED_TRACE(c.row);
    ASSERT_TRUE(carries(watcher, device)) << said_by_all();
    const pid_t supervisor = supervisor_of(bridge(device).pid());
    ASSERT_GT(supervisor, 0);
    watcher.events.clear();
    const std::int64_t t_lost = now_ns();
    ASSERT_EQ(kill(supervisor, c.signal), 0);
    EXPECT_EQ(bridge(device).wait(5s), 1) << said_by(device);
    EXPECT_NE(said_by(device).find("the supervisor has died"), std::string::npos) << said_by(device);
    EXPECT_TRUE(watcher.sees([&] { return watcher.has_event("the supervisor has died"); }));
    EXPECT_NE(kill(supervisor, 0), 0) << "it outlives the bridge";

    const Flight log = flight(device);
    ASSERT_GT(log.size(), 500u);
    expect_limits_held(log);
    EXPECT_EQ(log.back().state, "fault");
    EXPECT_EQ(log.back().felt(), 0);
    EXPECT_GT(log[log.size() - 2].felt(), 3) << "one tick is enough";
    RowTimes end(c.row + ": no force, the bridge's run ends", c.provoked_by);
    end.add(ms_between(t_lost, log.back().t_ns), 100);
    end.tell();
    RowTimes power(c.row + ": arm without power", c.provoked_by);
    power.add(ms_to_power_off(device, t_lost), 100 + kConnect);
    power.tell();
  }
}

}  // namespace
}  // namespace palp::test::fault_bridge_test
