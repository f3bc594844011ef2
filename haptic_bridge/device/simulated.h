// A simulated 6-DoF arm in a simulated hand. The arm: apparent mass and inertia (its own weight balanced, as the
// Virtuose does), viscous and Coulomb friction, encoders of finite resolution, velocity by differentiation, a largest
// force, motors that get warm, and stops at the ends of its joints. The hand: it wants to follow a path and pulls the
// handle along it through a mass, spring and damper; the firmer the grip, the stiffer (second-order grip models: Hasser
// & Cutkosky 2002; Fu & Cavusoglu 2012).
#pragma once

#include <memory>
#include <random>

#include "haptic_bridge/device/driver.h"
#include "haptic_bridge/device/grip.h"
#include "haptic_bridge/device/hand_script.h"
#include "haptic_bridge/device/simulated_motors.h"
#include "haptic_bridge/loop/haptic_device.h"

namespace palp {

struct ArmModel {
  double mass = 0.6;                 // apparent at the handle [kg]
  double inertia = 0.004;            // about any axis through the handle [kg m^2]
  double damping = 1;                // viscous friction [N s/m]
  double angular_damping = 0.005;    // [N m s/rad]
  double friction = 0.1;             // Coulomb [N]
  double angular_friction = 0.002;   // [N m]
  double resolution = 5e-6;          // of a position [m]; 0: exact
  double angular_resolution = 1e-4;  // [rad]
  double velocity_filter_hz = 60;  // of the low-pass after differentiating the encoders; 0: the exact velocity is given
  MotorRating motors;
  // its stops, either way from home: along the world's axes [m], and of each component of the rotation vector [rad]
  static constexpr double kNoStop = 1e9;
  Eigen::Vector3d workspace = Eigen::Vector3d::Constant(kNoStop);
  double turn = kNoStop;
};

// DeviceReading::alarms of the simulated arm.
inline constexpr std::uint32_t kArmAtStop = 1, kArmHot = 2, kArmSaturated = 4;

class SimulatedDevice final : public HapticDevice {
 public:
  // home: what the script's keyframes are offsets from. start: where the handle is at first; if that is not where the
  // script begins, the hand first goes there, unhurried. Throws ConfigError when the model would not be stable at its
  // time step of 0.25 ms.
  SimulatedDevice(const ArmModel& arm, const HandScript& script, const RigidState& home, const RigidState& start);

  const DeviceInfo& info() const noexcept override { return info_; }
  bool read(std::int64_t now_ns, DeviceReading& out) noexcept override;
  bool write(const Wrench<double>& wrench) noexcept override;
  void show(LoopState state) noexcept override { grip_.show(state); }

  // The exact state and what the hand wants, for tests.
  const RigidState& true_state() const { return state_; }
  RigidState intent(double time) const noexcept;

 private:
  void advance(double dt) noexcept;
  void sub_step(double middle, double dt) noexcept;
  Eigen::Vector3d stop_force(const Eigen::Vector3d& from_home, const Eigen::Vector3d& velocity,
                             const Eigen::Vector3d& reach, double stiffness, double mass) noexcept;
  void measure(double dt) noexcept;
  Eigen::Vector3d tremor(double dt) noexcept;

  ArmModel arm_;
  HandModel hand_;
  Trajectory approach_;
  Trajectory script_;
  DeviceInfo info_;

  RigidState state_;
  Eigen::Vector3d bristle_ = Eigen::Vector3d::Zero();          // deflection of the friction [m]
  Eigen::Vector3d angular_bristle_ = Eigen::Vector3d::Zero();  // [rad]
  RigidState home_;
  Wrench<double> commanded_;
  Wrench<double> applied_;  // by the motors
  Motors motors_;
  bool at_stop_ = false;
  RigidState measured_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  Eigen::Vector3d tremor_x_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d tremor_v_ = Eigen::Vector3d::Zero();

  Grip grip_;
  bool started_ = false;
  std::int64_t t_last_ns_ = 0;
  double time_ = 0;  // of the script [s]
};

// Its setups are an ArmModel (table [arm] of a profile) and a HandScript.
Driver simulated_driver();

}  // namespace palp
