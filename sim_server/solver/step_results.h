// The host's side of a step: makes the kernels' input from a caller's, and a caller's results from the kernels' body
// states.
#pragma once

#include <vector>

#include "sim_server/physics/health.h"
#include "sim_server/physics/proxy.h"
#include "sim_server/solver/contact_blend.h"
#include "sim_server/solver/fluid_watch.h"
#include "sim_server/solver/plan.h"
#include "sim_server/solver/simulation.h"

namespace palp {

// The input block of a haptic step, which goes to the device at its start.
struct StepBlock {
  Forcing forcing;
  ProxyInput proxy[kMaxProxies];
  std::uint32_t heat_zones;  // one bit a zone: 1 where it is on
};

class StepResults {
 public:
  StepResults(const Scene& scene, const Plan& plan);
  void reset(const std::vector<BodyState>& bodies, StepOutput& out);
  // Makes all that sleeps wake within Plan::sleep_interval steps, because something about the scene has changed.
  void disturb() { changed_for_ = plan_.sleep_interval; }
  // Writes the input block. A device whose input is not finite, or no rotation, counts as not engaged for this step.
  void fill(const StepInput& input, double time, StepBlock& block);
  // Reads the results of the step whose block was filled last. bodies: null when the plan asks for no wrench. The
  // results of a body that is no longer finite stay as they were, so that nothing non-finite gets out; health says so.
  void read(const BodyState* bodies, const HealthSums& sums, std::uint32_t neighbor_overflow, StepOutput& out);

 private:
  void read_body(std::uint32_t index, const BodyState& b, BodyOutput& out) const;
  void read_proxy(std::size_t index, const DeviceInput& input, const BodyState& b, ProxyOutput& out);
  void judge(const HealthSums& sums, std::uint32_t neighbor_overflow, Health& health);

  struct ProxyMemory {
    RigidState slow;  // slow mean of the device's state
    bool known = false;
    ContactBlend linear, angular;
  };

  const Scene& scene_;
  const Plan& plan_;
  double step_ = 0;  // [s]
  FluidWatch watch_;
  StepInput input_;                                    // the accepted input
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();  // gravity and body force of the step [m/s^2]
  int changed_for_ = 0;                                // steps for which it still counts as changed
  std::vector<ProxyMemory> memory_;
};

}  // namespace palp
