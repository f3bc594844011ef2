// The rows of the fault table that an arm provokes, in the real bridge with the real driver: how long it takes until
// the hand is safe, by the bridge's own flight log.
#include <random>

#include "tests/process/fault_system.h"
#include "tests/support/seed.h"

namespace palp::test::fault_arm_test {
namespace {

constexpr double kHalf = 0.0005;  // [s], see ArmEvent

// A row of the table of faults whose event meets a force: when it comes and how much is allowed.
struct ArmRow {
  std::string row;
  ArmEvent event;
  int more_ticks = 0;  // allowed after the next one
};

const ArmEvent kLetGo{"dead_man_up", 0, 0.06, 0, ""};

ArmEvent at(double time, ArmEvent event) {
  event.time = time + kHalf;
  return event;
}

class FaultArm : public FaultSystem {
 protected:
  std::int64_t time_of(int device, const ArmEvent& event) const {
    return opened_ns(device) + static_cast<std::int64_t>(std::llround(1e9 * event.time));
  }
  void judge(int device, const Flight& flight, const ArmRow& row) const {
    RowTimes times(row.row, row.event.name + (row.event.call.empty() ? "" : " of " + row.event.call));
    add_same_tick(times, flight, time_of(device, row.event), row.more_ticks);
    times.tell();
  }
  // Expects half of what the coupling asks for, as fast as the slew limit allows, once the bits were read in their
  // turn.
  void judge_half(int device, const Flight& flight, const ArmRow& row) const {
    RowTimes times(row.row, row.event.name + " bits");
    const std::int64_t t = time_of(device, row.event);
    std::size_t i = tick_at(flight, t);
    ASSERT_LT(i + 50, flight.size());
    const double before = flight[i].felt();
    ASSERT_GT(before, 3);
    double late = 0;
    while (i < flight.size() && flight[i].felt() > 0.5 * length(flight[i].model) + 0.1) late += flight[i++].late_ms;
    ASSERT_LT(i, flight.size());
    EXPECT_EQ(flight[i].state, "engaged");
    times.add(ms_between(t, flight[i].t_ns), 7 + 1 + 0.5 * before / 0.3 + late);
    times.tell();
  }
};

// Returns how late the ticks were from t on, all together [ms].
double late_after(const Flight& flight, std::int64_t t_ns) {
  double late = 0;
  for (std::size_t i = tick_at(flight, t_ns); i < flight.size(); ++i) late += flight[i].late_ms;
  return late;
}

// Draws when the hand opens and for how long: it may do so at any time.
std::vector<ArmEvent> random_releases(unsigned seed, double from, double to) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> pause(0.02, 0.7), open(0.002, 0.2);
  std::vector<ArmEvent> events;
  for (double t = from; t < to; t += pause(random)) {
    const ArmEvent event{"dead_man_up", 1e-3 * std::floor(1e3 * t) + kHalf, 1e-3 * std::ceil(1e3 * open(random)), 0,
                         ""};
    events.push_back(event);
    t = event.time + event.duration;
  }
  return events;
}

// Returns the rows that end the force, in the order of their times.
std::vector<ArmRow> cut_rows() {
  return {
      {"dead-man open", at(1.8, {"dead_man_up", 0, 0.1, 0, ""})},
      {"arm shifted", at(2.6, {"shift", 0, 0.1, 0, ""})},
      {"power off", at(3.3, {"power_off", 0, 0.1, 0, ""})},
      {"emergency stop", at(4.1, {"emergency_stop", 0, 0.1, 0, ""})},
      {"reading: position not a number", at(5, {"nan_position", 0, 0.005, 0, ""})},
      {"reading: no orientation", at(5.4, {"bad_quaternion", 0, 0.005, 0, ""})},
      {"reading: a jump of half a metre", at(5.8, {"jump", 0, 0.005, 0.5, ""})},
      {"reading: link error 2", at(6.2, {"error", 0, 0.005, 2, "virtGetSpeed"})},
      {"reading: link error 6 for good", at(7.8, {"error", 0, 0, 6, "virtGetDeadMan"})},
  };
}

// Returns the rows that halve the force.
std::vector<ArmRow> half_rows() {
  return {
      {"arm at a bound", at(6.8, {"bound", 0, 0.1, 1, ""})},
      {"arm too warm", at(7.1, {"alarm", 0, 0.1, 0x4000, ""})},
      {"arm saturated", at(7.4, {"alarm", 0, 0.1, 0x8000, ""})},
  };
}

// Expects that a process has told the one before the other.
void expect_told_in_order(const std::vector<Event>& news, const std::string& process, const char* first,
                          const char* then) {
  const auto told = [&](const char* text) {
    return std::find_if(news.begin(), news.end(),
                        [&](const Event& e) { return e.process == process && e.text.find(text) != std::string::npos; });
  };
  ASSERT_NE(told(first), news.end()) << first;
  ASSERT_NE(told(then), news.end()) << then;
  EXPECT_LT(told(first), told(then));
}

TEST_F(FaultArm, SwitchesAlarmsAndReadings) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("PALP_SEED=" + std::to_string(seed));
  const std::vector<ArmRow> cuts = cut_rows(), halves = half_rows();
  std::vector<ArmEvent> events;
  for (const ArmRow& row : cuts) events.push_back(row.event);
  for (const ArmRow& row : halves) events.push_back(row.event);
  // after power and emergency stop the hand must let go, after the latter also to switch the power on; elsewhere it
  // does so where a busy machine may have cost the force
  for (const double time : {2.72, 3.45, 4.25, 6.25}) events.push_back(at(time, kLetGo));

  Watcher& watcher = watch();
  start_weights();
  start_arm(0, events);
  const std::vector<ArmEvent> releases = random_releases(seed, 0.2, 6);
  start_arm(1, releases);
  // the reason for having no force changes: the hand lets go, then the power goes
  start_arm(2, {at(2.6, {"dead_man_up", 0, 2, 0, ""}), at(3.6, {"power_off", 0, 2, 0, ""})});
  EXPECT_EQ(bridge(0).wait(), 1) << said_by_all();
  EXPECT_NE(said_by(0).find("virtGetDeadMan failed: the controller answered too late (error 6)"), std::string::npos)
      << said_by(0);
  for (const int device : {1, 2}) EXPECT_EQ(bridge(device).stop(), 0) << said_by(device);

  const Flight log = flight(0);
  ASSERT_GT(log.size(), 6000u);
  expect_limits_held(log);
  for (const ArmRow& row : cuts) judge(0, log, row);
  for (const ArmRow& row : halves) judge_half(0, log, row);
  EXPECT_EQ(log.back().state, "fault");
  EXPECT_EQ(std::count_if(log.end() - 40, log.end(), [](const FlightTick& t) { return !t.good; }), 21);

  const Flight any_moment = flight(1);
  expect_limits_held(any_moment);
  RowTimes any("dead-man open", "random moments");
  for (const ArmEvent& event : releases) add_same_tick(any, any_moment, time_of(1, event));
  any.tell();

  expect_limits_held(flight(2));
  watcher.look();
  {
    SCOPED_TRACE(said_by(2));
    expect_told_in_order(watcher.events, name_of(2), "the hand is off the dead-man switch", "motors have no power");
  }
  EXPECT_TRUE(watcher.has_event("at a bound, too warm or saturated")) << said_by(0);
}

// Expects that from the tick that is too fast on the force goes to the damping as fast as the slew limit allows, and
// stays there.
void judge_fast(const Flight& flight, const std::string& row, const std::function<bool(const FlightTick&)>& too_fast) {
  RowTimes times(row, "a hand that throws the handle");
  const double step = FlightLimits{}.force_step;
  for (std::size_t i = 1; i < flight.size(); ++i) {
    if (!too_fast(flight[i]) || too_fast(flight[i - 1]) || flight[i].engagement < 1) continue;
    const std::int64_t t = flight[i].t_ns;
    // the damping itself changes by up to half a step a tick
    double allowed = 1 + length(minus(flight[i - 1].force, damping_only(flight[i]))) / (0.5 * step);
    bool there = false;
    for (; i < flight.size() && too_fast(flight[i]); ++i) {
      const Vec3 way = minus(damping_only(flight[i]), flight[i - 1].force);
      const Vec3 expected = length(way) > step ? scaled(step / length(way), way) : way;
      const Vec3 found = minus(flight[i].force, flight[i - 1].force);
      if (!flight[i].reduced) {
        EXPECT_LT(length(minus(found, expected)), 1e-6);
      }
      allowed += flight[i].late_ms;
      if (!there && length(minus(flight[i].force, damping_only(flight[i]))) < 0.1) {
        there = true;
        times.add(ms_between(t, flight[i].t_ns), allowed);
      }
    }
  }
  times.tell();
}

TEST_F(FaultArm, FastHandles) {
  Watcher& watcher = watch();
  start_weights();
  const auto keyframe = [](double time, double lift, double turn) {
    return "[[keyframe]]\ntime = " + std::to_string(time) + "\nposition = [0.0, 0.0, " + std::to_string(lift) +
           "]\nrotation_deg = [0.0, 0.0, " + std::to_string(turn) + "]\n";
  };
  write_text(folder_ / "hand.toml", "grip = \"firm\"\n" + keyframe(0, 0, 0) + keyframe(0.7, 0, 0) +
                                        keyframe(0.85, 0.25, 0) + keyframe(1.4, 0.25, 0) + keyframe(1.6, 0.25, 100) +
                                        keyframe(60, 0.25, 100));
  start_arm(0, {}, kNeverLate, "hand = \"hand.toml\"\n");
  ASSERT_TRUE(carries(watcher, 0)) << said_by_all();
  std::this_thread::sleep_for(1800ms);
  EXPECT_EQ(bridge(0).stop(), 0) << said_by(0);
  const Flight log = flight(0);
  expect_limits_held(log);
  judge_fast(log, "handle faster than 1.5 m/s", [](const FlightTick& t) { return length(t.velocity) > 1.5; });
  judge_fast(log, "handle faster than 6 rad/s", [](const FlightTick& t) { return length(t.turning) > 6; });
}

// Errors that are no passing trouble of the link: the arm is without force and power at once, and the run ends.
struct Failure {
  const char* row;
  ArmEvent event;
  const char* told;
  int more_ticks;
};

class FaultArmFails : public FaultArm {
 protected:
  // Judges how a bridge ends that has met its failure. False: no force was felt when it came.
  bool judge_end(int device, const Failure& f) {
    EXPECT_EQ(bridge(device).wait(), 1) << said_by_all();
    EXPECT_NE(said_by(device).find(f.told), std::string::npos) << said_by(device);
    const Flight log = flight(device);
    const std::int64_t t = time_of(device, f.event);
    const std::size_t met = tick_at(log, t);
    if (met < 2 || log[met - 2].felt() < 3) return false;
    expect_limits_held(log);
    EXPECT_EQ(log.back().state, "fault");
    const double powered_for = 1e3 * (time_of_call(device, "virtSetPowerOn 0 = 0") - f.event.time);
    RowTimes times(f.row, f.event.name + (f.event.call.empty() ? "" : " of " + f.event.call));
    if (f.event.call == "virtSetForce") {  // whatever the log says, the arm takes no wrench: power alone helps
      times.add(powered_for, late_after(log, t) + f.more_ticks);
    } else {
      add_same_tick(times, log, t, f.more_ticks);
    }
    times.tell();
    EXPECT_LT(powered_for, 500) << "the power went with the end of the process, not of the loop";
    return true;
  }
};

TEST_F(FaultArmFails, TheRunEnds) {
  std::vector<Failure> failures{
      {"device error 11 from a read", at(2.1, {"error", 0, 0, 11, "virtGetSpeed"}), "virtGetSpeed failed", 0},
      {"device error 11 from a write", at(2.1, {"error", 0, 0, 11, "virtSetForce"}), "virtSetForce failed", 2},
      {"device writes fail 20 times in a row", at(2.1, {"error", 0, 0, 2, "virtSetForce"}), "virtSetForce failed", 22},
      {"failure bits of the motors", at(2.1, {"failure", 0, 0, 2, ""}), "a failure of its motors", 6},
      {"alarm: wrong position", at(2.1, {"alarm", 0, 0, 0x40000, ""}), "an error of its position", 6},
      {"state that is no longer updated", at(2.1, {"freeze", 0, 0, 0, ""}), "its pose stands still", 52},
  };
  start_weights();
  write_text(folder_ / "hand.toml", "[[keyframe]]\ntime = 0\n[[keyframe]]\ntime = 3\nposition = [0.0, 0.0, 0.4]\n");
  // on a busy machine a bridge may not feel its weight in time; it is tried again
  for (int round = 0; round < 5 && !failures.empty(); ++round) {
    const std::size_t n = std::min<std::size_t>(failures.size(), kBridges);
    for (std::size_t i = 0; i < n; ++i)
      start_arm(static_cast<int>(i), {failures[i].event}, kNeverLate,
                failures[i].event.name == "freeze" ? "hand = \"hand.toml\"\n" : "");
    std::vector<Failure> left(failures.begin() + static_cast<std::ptrdiff_t>(n), failures.end());
    for (std::size_t i = 0; i < n; ++i) {
      SCOPED_TRACE(failures[i].row);
      if (!judge_end(static_cast<int>(i), failures[i])) left.push_back(failures[i]);
    }
    failures = left;
  }
  EXPECT_EQ(failures.size(), 0u) << failures[0].row << " never met a force";
}

}  // namespace
}  // namespace palp::test::fault_arm_test
