// When a hand may be coupled: it must have let go of the handle and taken hold of it while the motors were on and the
// emergency stop was closed. Whatever ended the force before, nobody is pushed by an arm that they only touch.
#pragma once

#include "haptic_bridge/device/device.h"

namespace palp {

class Interlock {
 public:
  // Something ended the force: the hand has to let go and take hold again.
  void trip() { held_ = seen_open_ = false; }
  // Once a tick, with a good reading.
  void update(const DeviceReading& r) {
    if (!r.powered || !r.chain_closed) return trip();
    if (!r.dead_man) {
      seen_open_ = true;
      held_ = false;
    } else if (seen_open_) {
      held_ = true;
    }
  }
  bool held() const { return held_; }
  // The handle is held, but was not let go of since the interlock tripped.
  bool locked(const DeviceReading& r) const { return r.dead_man && !held_; }

 private:
  bool seen_open_ = false;
  bool held_ = false;
};

}  // namespace palp
