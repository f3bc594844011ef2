// The bridge's flight log as numbers, what no tick of any log may break, and how long it took to be safe.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "tests/process/running_system.h"
#include "tests/support/flight_table.h"

namespace palp::test {

using Vec3 = std::array<double, 3>;

inline double length(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }
inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec3 scaled(double s, const Vec3& v) { return {s * v[0], s * v[1], s * v[2]}; }
inline Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

struct FlightTick {
  std::int64_t t_ns = 0;
  double late_ms = 0, age_ms = 0, stale_scale = 0, engagement = 0, sim_time = 0;
  std::uint64_t sequence = 0;
  bool good = false, hand_on = false, cut = false, reduced = false;
  unsigned alarms = 0;
  std::string state, verdict;
  Vec3 velocity{}, turning{}, model{}, force{}, torque{};
  double felt() const { return length(force); }
  // The wrench is below 0.1 N, and its torque below what that is at a lever of 0.1 m.
  bool safe() const { return length(force) < 0.1 && length(torque) < 0.01; }
};
using Flight = std::vector<FlightTick>;

inline Flight flight_of(const std::string& file) {
  const FlightTable log(file);
  const auto number = [&](const std::string& column, std::size_t i) { return log.number(column, i); };
  const auto is_on = [&](const std::string& column, std::size_t i) { return log.text(column, i) == "1"; };
  const auto vector = [&](const std::string& column, std::size_t i) {
    return Vec3{number(column + "_x", i), number(column + "_y", i), number(column + "_z", i)};
  };
  Flight flight(log.ticks());
  for (std::size_t i = 0; i < flight.size(); ++i) {
    FlightTick& t = flight[i];
    t.t_ns = log.t_ns(i);
    t.late_ms = 1e-3 * number("lateness_us", i);
    t.age_ms = 1e-3 * number("age_us", i);
    t.stale_scale = number("stale_scale", i);
    t.engagement = number("engagement", i);
    t.sim_time = number("sim_time_s", i);
    t.sequence = std::stoull(log.text("sequence", i));
    t.good = is_on("good_reading", i);
    t.hand_on = is_on("hand_on", i);
    t.cut = is_on("cut", i);
    t.reduced = is_on("reduced", i);
    t.alarms = static_cast<unsigned>(number("alarms", i));
    t.state = log.text("state", i);
    t.verdict = log.text("verdict", i);
    t.velocity = vector("velocity", i);
    t.turning = vector("angular_velocity", i);
    t.model = vector("model_force", i);
    t.force = vector("force", i);
    t.torque = vector("torque", i);
  }
  return flight;
}

// The limits of the profile that these tests give the bridge.
struct FlightLimits {
  double force = 10, torque = 1;                // [N], [N m]
  Vec3 axis_force{9, 9, 8};                     // [N]
  double force_step = 0.3, torque_step = 0.03;  // of a tick [N], [N m]
  double power = 5;                             // [W]
};
inline constexpr const char* kFlightLimits =
    "[limits]\nforce = 10\ntorque = 1\naxis_force = [9, 9, 8]\nforce_slew = 300\ntorque_slew = 30\npower = 5\n";

// Returns what a handle is to feel that is too fast or has only old samples: damping of 3 N s/m within the limits, so
// far as it is engaged, and no more.
inline Vec3 damping_only(const FlightTick& t) {
  const FlightLimits most;
  Vec3 force = scaled(-3, t.velocity);
  for (std::size_t k = 0; k < 3; ++k) force[k] = std::clamp(force[k], -most.axis_force[k], most.axis_force[k]);
  return scaled(t.engagement * std::min(1.0, most.force / std::max(most.force, length(force))), force);
}

// Expects that no tick breaks a limit, and that no tick without a hand, a reading or health has any force.
inline void expect_limits_held(const Flight& flight, const FlightLimits& most = {}) {
  constexpr double kRounding = 1e-6;  // the log has nine digits
  FlightTick before;
  for (const FlightTick& t : flight) {
    SCOPED_TRACE("tick at " + std::to_string(1e-9 * static_cast<double>(t.t_ns - flight[0].t_ns)) + " s");
    ASSERT_LE(t.felt(), most.force + kRounding);
    ASSERT_LE(length(t.torque), most.torque + kRounding);
    for (std::size_t k = 0; k < 3; ++k) ASSERT_LE(std::abs(t.force[k]), most.axis_force[k] + kRounding);
    ASSERT_LE(dot(t.force, t.velocity) + dot(t.torque, t.turning), most.power + kRounding);
    if (!t.cut && !t.reduced) {
      ASSERT_LE(length(minus(t.force, before.force)), most.force_step + kRounding);
      ASSERT_LE(length(minus(t.torque, before.torque)), most.torque_step + kRounding);
    }
    // in the very last tick a wrench may have been refused for good
    const bool ended = t.state == "fault" && &t != &flight.back();
    if (t.cut || !t.good || !t.hand_on || ended) {
      ASSERT_EQ(t.felt() + length(t.torque), 0);
    }
    before = t;
  }
}

// Returns the index of the first tick that begins at or after t; flight.size() if there is none.
inline std::size_t tick_at(const Flight& flight, std::int64_t t_ns) {
  return static_cast<std::size_t>(
      std::lower_bound(flight.begin(), flight.end(), t_ns,
                       [](const FlightTick& tick, std::int64_t t) { return tick.t_ns < t; }) -
      flight.begin());
}

inline double ms_between(std::int64_t from_ns, std::int64_t to_ns) {
  return 1e-6 * static_cast<double>(to_ns - from_ns);
}

// Prints one line of the table of measured times, for people; with PALP_RESULTS=DIR also at the end of
// DIR/fault_times.md.
inline void tell_row(const std::string& row, const std::string& provoked_by, double measured_ms, double allowed_ms) {
  std::array<char, 512> line{};
  std::snprintf(line.data(), line.size(), "| %s | %s | %.2f | %.2f |", row.c_str(), provoked_by.c_str(), measured_ms,
                allowed_ms);
  std::cout << line.data() << std::endl;
  const char* folder = std::getenv("PALP_RESULTS");
  if (folder == nullptr) return;
  std::ofstream table(std::string(folder) + "/fault_times.md", std::ios::app);
  if (table.tellp() == 0) table << "| row | provoked by | ms | allowed ms |\n|---|---|---|---|\n";
  table << line.data() << '\n';
}

// The worst of several provocations of one row.
class RowTimes {
 public:
  RowTimes(std::string row, std::string provoked_by) : row_(std::move(row)), provoked_by_(std::move(provoked_by)) {}
  void add(double measured_ms, double allowed_ms) {
    EXPECT_LE(measured_ms, allowed_ms) << row_;
    ++count_;
    if (count_ > 1 && measured_ms - allowed_ms < measured_ - allowed_) return;
    measured_ = measured_ms;
    allowed_ = allowed_ms;
  }
  int count() const { return count_; }
  // At least one of the provocations must have met a force.
  void tell() const {
    EXPECT_GT(count_, 0) << row_ << ": never provoked while a force was felt";
    if (count_ > 0)
      tell_row(row_, provoked_by_ + (count_ > 1 ? ", worst of " + std::to_string(count_) : ""), measured_, allowed_);
  }

 private:
  std::string row_, provoked_by_;
  int count_ = 0;
  double measured_ = 0, allowed_ = 0;
};

}  // namespace palp::test
