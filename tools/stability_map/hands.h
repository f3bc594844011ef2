// The hands of the stability map: what a device does to the tool of a cell.
#pragma once

#include "tools/stability_map/setup.h"

namespace palp::stability {

class HandPath {
 public:
  HandPath(const Setup& setup, const Scene& scene);
  // Returns what the devices are at the start of the k-th haptic step.
  StepInput at(int k) const;

 private:
  Setup setup_;
  CouplingGains gains_;
  RigidState start_;
  bool any_ = false;
};

}  // namespace palp::stability
