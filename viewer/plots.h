// The data of the plots: the last seconds of what hands feel and of how the simulation keeps up. Pure.
#pragma once

#include <array>
#include <cstdint>

#include "viewer/feed_state.h"
#include "viewer/history.h"
#include "viewer/hud_text.h"

namespace palp {

struct HandPlots {
  std::array<History, 3> force;   // [N] x y z
  std::array<History, 3> torque;  // [N m] x y z
};

struct Plots {
  std::array<HandPlots, kMaxDevices> hands;
  History frame_age;         // [s] of the particles shown
  History bridge_age;        // [s] of the samples that the worst bridge renders from
  History step_time;         // [s] of the wall clock per haptic step
  History real_time_factor;  // simulated over wall-clock time
  History kinetic_energy;    // [J] of all that moves

  // Takes what is known at a time [ns]; call once a picture.
  void add(const FeedView& view, const HudData& figures, std::int64_t now_ns);
};

}  // namespace palp
