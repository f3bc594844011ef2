// The script of a simulated Virtuose, read from a TOML file: what the arm is, what its hand does, and what goes wrong
// when. config/devices/README.md has the keys.
#pragma once

#include <string>
#include <vector>

#include "haptic_bridge/device/simulated.h"

namespace palp::fake {

enum class EventKind {
  dead_man_up,     // the hand lets go of the switch
  power_off,       // someone switches the motors off
  emergency_stop,  // the chain is open
  shift,           // the shift button is pressed
  button,          // value: which
  bound,           // value: bits of virtIsInBounds
  alarm,           // value: bits of virtGetAlarm
  failure,         // value: bits of virtGetFailure
  error,           // value: the error code that calls end with
  nan_position,
  bad_quaternion,
  jump,    // value: metres along the arm's X
  freeze,  // the state is no longer updated
  slow,    // value: seconds that each call takes
};

struct Event {
  double time = 0;  // since virtOpen [s]
  double end = 0;
  EventKind kind = EventKind::dead_man_up;
  double value = 0;
  std::string call;  // error, slow: only this function; empty: all
  bool holds(double t) const { return t >= time && t < end; }
};

struct Script {
  bool lock_step = false;  // time passes by one time step with each call that reads a pose, instead of by the clock
  int device_type = 3;
  int serial = 1;
  int major_version = 4, minor_version = 4;
  double relay_delay = 2.5;  // from power on until the motors render force [s]
  double latency = 1e-3;     // of a command [s]
  double grip_at = 0.3;      // when the hand takes hold [s]
  bool regrip = true;        // the hand takes hold anew every 2 s as long as it feels nothing
  double continuous_force = 10, continuous_torque = 1;  // more than this for long makes the motors hot
  std::vector<double> workspace{0.45, 0.45, 0.45};      // half of it along X, Y, Z [m]
  ArmModel arm;
  HandScript hand;    // begins to move when it first feels a force, without regrip when it takes hold
  std::string log;    // every call, and what was wrong with its order; empty: none
  std::string trace;  // CSV: time, switches and rendered force of each millisecond; empty: none
  std::vector<Event> events;
};

// Throws ConfigError with every fault, file:line each. Names of files in it are relative to its folder.
Script read_script(const std::string& file);

}  // namespace palp::fake
