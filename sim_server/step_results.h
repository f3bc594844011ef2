// The host's side of a step: what a caller's input becomes for the kernels, and what the kernels' body states mean.
#pragma once

#include <vector>

#include "sim_server/physics/health.h"
#include "sim_server/plan.h"
#include "sim_server/proxy.h"
#include "sim_server/simulation.h"

namespace palp {

// What goes to the device at the start of each haptic step.
struct StepBlock {
  Forcing forcing;
  ProxyInput proxy[kMaxProxies];
  std::uint32_t heat_zones;  // that are on, one bit each
};

class StepResults {
 public:
  StepResults(const Scene& scene, const Plan& plan);
  void reset(const std::vector<BodyState>& bodies, StepOutput& out);
  // A device whose input is not finite, or no rotation, counts as not engaged for this step.
  void fill(const StepInput& input, double time, StepBlock& block);
  // Of the step that was filled last. bodies: null when the plan asks for no wrench.
  void read(const BodyState* bodies, const HealthSums& sums, std::uint32_t crowded, StepOutput& out);

 private:
  void read_body(std::uint32_t index, const BodyState& b, BodyOutput& out) const;
  void read_proxy(std::size_t index, const DeviceInput& input, const BodyState& b, ProxyOutput& out);
  void judge(const HealthSums& sums, std::uint32_t crowded, Health& health) const;

  // Estimates how far the proxy is held back: 1 - (its motion along the device's) / (the device's motion).
  // How much of the coupling's stiffness a contact answers with, 1 for a rigid one, ke / (K + ke) for an elastic one, 0
  // in free space and in fluid: by how much the contact's force changes with the device's place over some
  // hundredths of a second. What the proxy's own mass makes it lag, and what a link makes of the device's
  // motion, is no contact.
  struct Blend {
    Eigen::Vector3d slow_force = Eigen::Vector3d::Zero();
    double answered = 0, asked = 0;  // means of -dF . dx and K dx^2
    double value = 0;
    // way: of the device from its own slow mean; least: of it that tells anything.
    double update(const Eigen::Vector3d& force, const Eigen::Vector3d& way, double stiffness, double least,
                  double step);
  };
  struct ProxyMemory {
    RigidState slow;  // of the device
    bool known = false;
    Blend linear, angular;
  };

  const Scene& scene_;
  const Plan& plan_;
  double step_ = 0;  // [s]
  StepInput input_;  // as accepted
  std::vector<ProxyMemory> memory_;
};

}  // namespace palp
