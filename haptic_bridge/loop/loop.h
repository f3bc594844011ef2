// The 1 kHz loop: device -> newest sample of the server -> virtual coupling -> passivity -> limits -> device. One tick
// is one call; run_loop (run.h) calls it at absolute deadlines. Knows nothing of DDS, files or threads.
#pragma once

#include <cstdint>

#include "haptic_bridge/loop/force_limits.h"
#include "haptic_bridge/loop/gain_governor.h"
#include "haptic_bridge/loop/haptic_device.h"
#include "haptic_bridge/loop/interlock.h"
#include "haptic_bridge/loop/local_model.h"
#include "haptic_bridge/loop/passivity.h"
#include "haptic_bridge/loop/sample_gate.h"
#include "haptic_bridge/loop/stale_fade.h"
#include "haptic_bridge/loop/tick_input.h"
#include "haptic_bridge/loop/workspace.h"
#include "idl/messages.h"

namespace palp {

// The bounds past which the force ends until the hand has let go and taken hold again, or becomes damping.
struct SafetyConfig {
  std::int64_t overrun_ns = 5'000'000;  // a tick that is this late; 0: never
  int late_ticks = 20;                  // that many ticks in a row late by half a period; 0: never
  int bad_samples = 3;                  // more than so many unsound samples in a row
  double tool_speed = 1.5;              // of the device; faster: damping only [m/s]
  double tool_turn = 6;                 // [rad/s]
};

// The time over which the motors warm, for their continuous rating [s].
inline constexpr double kWarmingTime = 10;

struct LoopConfig {
  std::int64_t period_ns = 1'000'000;
  std::uint32_t device = 0;
  std::uint64_t own_session = 0;        // of this bridge's DeviceSamples
  CouplingGains gains = kDefaultGains;  // proposed to the server
  WrenchLimits limits;
  SafetyConfig safety;
  PassivityConfig passivity;
  PassivityConfig angular_passivity{1e-3, 10e-3, 0, 0.03, 0.05, 0.005};
  GovernorConfig governor;
  WorkspaceConfig workspace;
  StaleTimes stale;
  // A wrench computed from a device state older than this is stale however fresh its arrival: the server does not hear
  // us.
  std::int64_t round_trip_allowance_ns = 10'000'000;
  double blend_time = 0.005;            // time constant of going over to a new sample [s]
  std::int64_t fresh_ns = 200'000'000;  // so long must data have been fresh before force comes (back)
  double ramp_up = 0.5;                 // [s] from no force to all of it
  double ramp_down = 0.05;              // [s]
  double ramp_after_clutch = 0.3;       // as ramp_up, after the arm was moved without the tool [s]
  double slew_recovery = 0.03;         // in which the slope limit makes up for what it could not follow [s]; 0: at once
  double fade_damping = 3;             // takes the place of the local model when data grows old [N s/m]
  double fade_angular_damping = 0.03;  // [N m s/rad]
  double max_speed = 5;                // a reading that moved faster than this since the last good one is wrong [m/s]
  double max_angular_speed = 50;       // [rad/s]
  int max_bad_ticks = 20;              // that many failures of the device in a row are a fault
};

// Everything about one tick, for the flight log. Plain data.
struct TickRecord {
  std::uint64_t tick = 0;
  std::int64_t t_ns = 0;         // of the tick, CLOCK_MONOTONIC
  std::int64_t lateness_ns = 0;  // behind its deadline
  std::uint32_t missed = 0;      // whole periods skipped before it
  std::int64_t duration_ns = 0;  // of the tick, as run_loop measures it
  LoopState state = LoopState::waiting;
  bool good_reading = false;
  bool engaged_device = false;
  bool cut = false;            // the wrench was set to zero by a safety cut, not by the slew limit
  bool reduced = false;        // the power limit took force away, not the slew limit
  std::uint32_t alarms = 0;    // of the device
  std::int32_t verdict = -1;   // on the sample that came in this tick (Verdict), -1: none came
  std::uint64_t sequence = 0;  // of the sample in use
  std::int64_t age_ns = 0;     // since it was received; 0 without sample
  std::int64_t delay_ns = 0;   // since the device state that it was computed from was read
  double sim_time = 0;         // of the sample in use [s]
  RigidState device;
  Eigen::Vector3d proxy = Eigen::Vector3d::Zero();  // position of the proxy in the sample in use [m]
  Wrench<double> model = zero_wrench();             // before the limits
  Wrench<double> sent = zero_wrench();              // on the device
  double stale_scale = 1;
  double engagement = 0;
  double blend_linear = 0;
  double blend_angular = 0;
  double energy_linear = 0;  // that the coupling may still give the hand [J]
  double energy_angular = 0;
  double damping_linear = 0;  // of the passivity controller [N s/m]
  double damping_angular = 0;
  double gains_share = 1;  // of the gains that the profile asks for, as the link allows
};

// Running totals, copied out once a tick.
struct LoopReport {
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;     // whole periods
  std::int64_t t_first_ns = 0;  // of the first tick
  std::int64_t t_last_ns = 0;
  LoopState state = LoopState::waiting;
  LoopFault fault = LoopFault::none;
  std::uint64_t server_session = 0;
  std::uint64_t bad_readings = 0;
  std::uint64_t bad_writes = 0;
  std::uint64_t cuts = 0;          // ticks in which a wrench that was not zero was cut to zero
  std::uint64_t stale_events = 0;  // times that data went stale
  std::uint64_t trips = 0;         // times that the hand had to let go: stale, overrun, unsound samples
  std::uint64_t damped_ticks = 0;  // of the passivity controller
  bool dead_man = false, powered = false, chain_closed = false, shifted = false;  // of the last good reading
  bool strained = false;  // the device is at a bound, too warm or saturated
  double gains_share = 1;
  double motion_scale = 1, force_scale = 1;  // of the workspace
  SceneReach reach;               // half of it is 0 where it is not known, or the hand has not taken hold yet
  std::uint64_t passed_over = 0;  // samples of the server that never came to use
  std::array<std::uint64_t, kVerdicts> verdicts{};
  std::int64_t age_ns = 0;
  double force = 0;  // sent [N]
  double torque = 0;
  double peak_force = 0;
  double peak_torque = 0;
};

class HapticLoop {
 public:
  // Force limits are the smaller of the configuration's and the device's.
  HapticLoop(const LoopConfig& config, HapticDevice& device);

  // One tick at now_ns. incoming: what came in since the last tick, or null. No allocation, no lock, no throw, and no
  // system call but the device's. Same calls, same wrenches, bit for bit.
  void tick(std::int64_t now_ns, std::int64_t lateness_ns, std::uint32_t missed, const IncomingProxy* incoming);

  // Tells the loop of so many samples of the server that have come since the last tick and were too malformed to be
  // handed on.
  void note_refused(std::uint64_t samples) { refused_ += samples; }
  // Ends the force with the next tick, for good.
  void fail(LoopFault fault) { fault_ = fault; }
  // Leaves the device without force, after the last tick.
  void release() noexcept { device_.release(); }

  // The results of the last tick. The bus numbers and stamps the sample when it sends it. worth_sending: the device has
  // been read.
  const DeviceSample& sample() const { return sample_; }
  bool worth_sending() const { return have_reading_; }
  const TickRecord& record() const { return record_; }
  // Returns what the last tick took in: the same inputs in the same order give the same wrenches (rerun.h).
  const TickInput& input() const { return input_; }
  const LoopReport& report() const { return report_; }
  const LoopConfig& config() const { return config_; }

 private:
  void read_device(std::int64_t now_ns);
  bool plausible(const RigidState& next, std::int64_t now_ns) const;
  void count_unsound(std::uint64_t samples);
  void judge_sample(const IncomingProxy& in, std::int64_t now_ns);
  void take_sample(const IncomingProxy& in, bool begins, std::int64_t now_ns);
  void follow_time(std::int64_t lateness_ns);
  void follow_link(std::int64_t now_ns);
  void follow_hand();
  void trip();
  LoopState find_state(bool willing) const;
  void observe_energy();
  Wrench<double> render_wrench();
  Wrench<double> apply_limits(const Wrench<double>& wanted);
  void send(const Wrench<double>& wrench);
  void describe(std::int64_t now_ns);

  LoopConfig config_;
  HapticDevice& device_;
  SampleGate gate_;
  BlendedModel model_;
  Interlock interlock_;
  Workspace workspace_;
  GainGovernor governor_;
  PassivityController passivity_, angular_passivity_;
  ThermalLimit thermal_limit_, angular_thermal_limit_;
  SlewLimit slope_;
  double period_;       // [s]
  double elapsed_ = 0;  // since the last tick [s]

  DeviceReading reading_;  // the last good one
  RigidState tool_;        // it, in the scene
  // the tool in the middle of the period that a wrench is held for: a spring held from its beginning gives energy, like
  // a damper of -K T/2
  RigidState middle_ = tool_;
  RigidState before_ = tool_;  // the device, in the last tick
  bool have_reading_ = false;
  std::int64_t t_reading_ns_ = 0;
  int bad_reads_in_a_row_ = 0;
  int bad_writes_in_a_row_ = 0;
  std::uint64_t bad_samples_in_a_row_ = 0;
  std::uint64_t refused_ = 0;  // since the last tick
  int late_in_a_row_ = 0;

  bool have_sample_ = false;
  std::int64_t t_receive_ns_ = 0;
  std::int64_t t_device_ns_ = 0;
  std::uint32_t sample_flags_ = 0;
  RigidState proxy_ = tool_;          // of the sample in use
  std::array<double, 2> energy_{};    // as the sample in use says, linear and angular [J]
  std::array<double, 2> received_{};  // of it, since the last tick [J]
  std::array<double, 2> stored_{};    // in the coupling's springs, at most, as the arm would get it back [J]
  std::int64_t fresh_since_ns_ = 0;
  bool qualified_ = false;
  bool was_stale_ = false;
  bool tripped_ = false;     // in this tick
  bool referenced_ = false;  // the hand's space lies on the scene's
  bool shifted_ = false;     // the arm was moved without the tool since the last engagement
  bool too_fast_ = false;
  double engagement_ = 0;
  std::array<double, 2> rendered_{};  // of force and torque that the coupling asked for, what was sent, 0..1
  Wrench<double> last_sent_ = zero_wrench();
  LoopFault fault_ = LoopFault::none;

  DeviceSample sample_;
  TickInput input_;
  TickRecord record_;
  LoopReport report_;
};

}  // namespace palp
