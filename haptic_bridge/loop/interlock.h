// When a hand may be coupled: since the force was last ended, by whatever it was, it has let go of the handle and taken
// hold of it. Nobody is pushed by an arm that they only touch.
#pragma once

#include "haptic_bridge/loop/haptic_device.h"

namespace palp {

class Interlock {
 public:
  // Something ended the force: the hand has to let go and take hold again.
  void trip() { held_ = seen_open_ = false; }
  // Once a tick, with a good reading.
  void update(const DeviceReading& r) {
    const bool on = r.powered && r.chain_closed;
    if (was_on_ && !on) trip();
    was_on_ = on;
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
  bool was_on_ = false;
  bool seen_open_ = false;
  bool held_ = false;
};

}  // namespace palp
