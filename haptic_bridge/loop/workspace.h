// Between the arm's space and the scene's: motion is scaled, force is scaled, and a clutch moves the one against the
// other. The world axes are the same in both; a device turns its own into them.
//   x_sim = x_0 + s (x_dev - x_ref), F_dev = f F_sim: a hand feels s f K of a stiffness K, and f / s of a work
#pragma once

#include <array>

#include "haptic_bridge/loop/force_limits.h"
#include "haptic_bridge/loop/haptic_device.h"

namespace palp {

struct WorkspaceConfig {
  double motion_scale = 1;  // s: the tool's way over the arm's
  double force_scale = 1;   // f: force and torque on the hand over those of the simulation
  bool relative = false;    // a hand that takes hold begins at the tool; false: the arm's space is the scene's
};

// Where the handle can be moved, in the scene: a box along the world's axes [m].
struct SceneReach {
  std::array<double, 3> center{}, half{};
};

class Workspace {
 public:
  explicit Workspace(const WorkspaceConfig& config) : config_(config) {}

  // Lays down that from now on the arm at this pose means the tool at that pose.
  void reference(const RigidState& arm, const RigidState& tool) {
    offset_ = tool.position - config_.motion_scale * arm.position;
    turn_ = (arm.orientation.conjugate() * tool.orientation).normalized();
  }
  SceneReach to_scene(const DeviceReach& reach) const {
    const Eigen::Vector3d c = offset_ + config_.motion_scale * reach.center, h = config_.motion_scale * reach.half;
    return {{c.x(), c.y(), c.z()}, {h.x(), h.y(), h.z()}};
  }
  RigidState to_scene(const RigidState& arm) const {
    return {offset_ + config_.motion_scale * arm.position, (arm.orientation * turn_).normalized(),
            config_.motion_scale * arm.linear, arm.angular};
  }
  Wrench<double> to_arm(const Wrench<double>& w) const {
    return {config_.force_scale * w.force, config_.force_scale * w.torque};
  }
  // The ratio of the hand's work to the simulation's.
  double linear_work() const { return config_.force_scale / config_.motion_scale; }
  double angular_work() const { return config_.force_scale; }
  const WorkspaceConfig& config() const { return config_; }

 private:
  WorkspaceConfig config_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond turn_ = Eigen::Quaterniond::Identity();  // of the tool in the handle
};

}  // namespace palp
