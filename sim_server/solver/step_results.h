// The host's side of a step: what a caller's input becomes for the kernels, and what the kernels' body states mean.
#pragma once

#include <vector>

#include "sim_server/physics/health.h"
#include "sim_server/physics/proxy.h"
#include "sim_server/solver/contact_blend.h"
#include "sim_server/solver/plan.h"
#include "sim_server/solver/simulation.h"

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
  // Of the step that was filled last. bodies: null when the plan asks for no wrench. Of a body that is no longer finite
  // what was read before stays, so that nothing non-finite gets out; its health says so.
  void read(const BodyState* bodies, const HealthSums& sums, std::uint32_t crowded, StepOutput& out);

 private:
  void read_body(std::uint32_t index, const BodyState& b, BodyOutput& out) const;
  void read_proxy(std::size_t index, const DeviceInput& input, const BodyState& b, ProxyOutput& out);
  void judge(const HealthSums& sums, std::uint32_t crowded, Health& health) const;

  struct ProxyMemory {
    RigidState slow;  // mean of the device's state
    bool known = false;
    Blend linear, angular;
  };

  const Scene& scene_;
  const Plan& plan_;
  double step_ = 0;                                    // [s]
  StepInput input_;                                    // as accepted
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();  // and the body force, of the step [m/s^2]
  std::vector<ProxyMemory> memory_;
};

}  // namespace palp
