// The whole haptic loop in lock-step: the solver at the server's rate, the server's treatment of samples, a link each
// way, the bridge's loop at 1 kHz and a simulated arm in a simulated hand. One event after the other in integer
// nanoseconds, so that a run is exact, repeatable bit for bit, and as fast as the solver is.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "haptic_bridge/device/profile.h"
#include "haptic_bridge/device/simulated.h"
#include "sim_server/solver/simulation.h"
#include "tools/haptic_bench/link.h"

namespace palp::bench {

// The sessions of the bridge and of the server that stand for each other's peer in a run.
inline constexpr std::uint64_t kBridgeSession = 7, kServerSession = 11;

// Names what is rendered: the loop as it is; the server's wrench held (samples with blend 0), or a spring to the held
// pose of the proxy (blend 1), both without smoothing. The baselines differ in the samples and in LoopConfig, not in
// code.
enum class Variant { ours, held, spring };
const char* to_string(Variant variant);

// Times of the run from which on something is wrong [s]; negative: never.
struct Faults {
  double server_dies = -1;
  double server_stalls = -1, stall_for = 0;  // the server does not step for so long
  double nan_samples = -1;                   // every wrench of the server's is NaN
  double nan_readings = -1;                  // so is every pose of the arm
  double hand_lets_go = -1;
};

// One tick of the bridge.
struct Tick {
  double t = 0;                    // [s]
  Eigen::Vector3d x, turn, v, w;   // of the handle, true: place against the start [m], rotation [rad], speeds
  Eigen::Vector3d force, torque;   // sent
  std::array<double, 2> port{};    // energy that the hand has drawn from the arm: linear, angular [J]
  std::array<double, 2> put_in{};  // energy that the simulation has put into the coupling [J]
  LoopState state = LoopState::waiting;
  bool cut = false, active = false;  // by the passivity controller
  std::int32_t verdict = -1;
  double delay = 0;  // of the device's state that the sample in use was computed from [s]
  double blend = 0;
  double share = 1, turn_share = 1;  // of the stiffness that the profile asks for, as the link allows
  double energy = 0, damping = 0;    // of the passivity controller, linear [J], [N s/m]
};

struct RunSetup {
  const Scene* scene = nullptr;
  double rate_hz = 1000;  // of the server
  double compute = 0;     // a step's time, from taking the device's sample to sending the answer [s]
  LinkPair link;
  Variant variant = Variant::ours;
  bool controller = true;                           // passivity control, and gains that follow the delay
  DeviceProfile profile;                            // limits, gains, arm
  HandScript hand;                                  // keyframes are offsets from the tool's handle at the start
  Eigen::Vector3d start = Eigen::Vector3d::Zero();  // of the handle, as an offset
  double seconds = 1;
  std::uint64_t seed = 1;
  Faults faults;
  std::function<void(Simulation&, double time)> before_step;  // e.g. to drive a current
  std::function<bool(const Tick&)> stop;                      // ends the run after this tick
};

struct Trace {
  std::vector<Tick> ticks;
  LoopReport report;
  int sub_steps = 0;
  std::string trouble;  // of the simulation or the loop; empty: none
  double force_limit = 0, torque_limit = 0;
};

// Throws what the scene or the device throws.
Trace run(const RunSetup& setup);

}  // namespace palp::bench
