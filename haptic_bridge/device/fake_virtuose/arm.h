// A Virtuose on a table that is not there: the simulated arm in its simulated hand, and the controller between it and
// the library, which steps at 1 kHz. All that a client sees of it is in the arm's frame: X towards the operator, Y to
// the operator's right, Z up; palp's simulated hand moves in a room with x to the right, y away from the operator.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <fstream>
#include <memory>

#include "haptic_bridge/device/fake_virtuose/script.h"
#include "haptic_bridge/device/virtuose/api.h"

namespace palp::fake {

using Pose = std::array<float, 7>;
using Vector = std::array<float, 6>;

// The last command of a client: forces, and the target of the virtual mechanism.
struct Command {
  double time = 0;
  Vector force{};
  Vector more{};  // added to it
  Pose target{0, 0, 0, 0, 0, 0, 1};
  Vector target_speed{};
};

// Returns the bits that a number of a script stands for; the number may be negative.
inline unsigned bits_of(double value) { return static_cast<unsigned>(static_cast<long long>(value)); }

class Arm {
 public:
  explicit Arm(const Script& script);

  // Steps the controller until time t [s since virtOpen].
  void advance_to(double t);
  double measured_at() const { return 1e-3 * static_cast<double>(t_measured_); }
  double time() const { return 1e-3 * static_cast<double>(ticks_); }
  // Returns whether an event of this kind is on, and sets value to the event's if it is.
  bool is_on(EventKind kind, double* value = nullptr) const;

  // The values at the last step, as the library shows them.
  const Pose& avatar() const { return shown_.avatar; }
  const Pose& physical() const { return shown_.physical; }
  const Vector& speed() const { return shown_.speed; }
  const Vector& rendered() const { return rendered_; }  // force on the hand
  bool dead_man() const { return holds_ && !is_on(EventKind::dead_man_up); }
  bool chain_closed() const { return !is_on(EventKind::emergency_stop); }
  bool powered() const { return powered_; }
  bool shifted() const { return !powered_ || is_on(EventKind::shift); }
  unsigned bounds() const;
  unsigned alarms() const;

  void send(const Vector& force);
  void add(const Vector& force);  // to what is sent or coupled, until the next add or send
  void send_target(const Pose* pose, const Vector* speed);
  void attach();  // the mechanism, at the target that was sent last
  void cut();     // the watchdog's: no force from here on, until power is asked for anew

  int mode = kVirtNoCommand;
  bool power_wanted = false;
  bool feedback = false;
  bool attached = false;
  double force_limit = 1e9, torque_limit = 1e9;  // of virtSaturateTorque
  Vector stiffness{}, damping{};                 // of the virtual mechanism, rotation first

 private:
  struct Shown {
    Pose avatar{0, 0, 0, 0, 0, 0, 1}, physical{0, 0, 0, 0, 0, 0, 1};
    Vector speed{};
  };
  void step();
  void follow_switches();
  void follow_hand();
  Vector wanted_force() const;
  Vector limited(Vector force);
  Command& next_command();
  void measure();
  void trace();

  Script script_;
  std::unique_ptr<SimulatedDevice> plant_;
  RigidState state_;  // measured, room
  std::int64_t ticks_ = 0;
  std::int64_t t_measured_ = 0;  // [ms]

  bool holds_ = false;
  double t_hold_ = 0;    // of the last change
  bool felt_ = false;    // some force since it took hold
  bool moving_ = false;  // the hand's script has begun
  bool powered_ = false;
  double t_power_ = 0;
  Command active_;
  std::deque<Command> underway_;  // younger than the latency
  Vector rendered_{};
  Motors motors_;
  double t_saturated_ = -1;

  bool indexing_ = true;
  Eigen::Vector3d x_offset_ = Eigen::Vector3d::Zero();  // avatar = offset + physical
  Eigen::Quaterniond q_offset_ = Eigen::Quaterniond::Identity();
  Shown shown_;
  std::ofstream trace_;
};

}  // namespace palp::fake
