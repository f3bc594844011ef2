// The scenes of the bench: the smallest that show the effect. Tools weigh 0.15 kg and are held where they are; the
// limits of their coupling are far beyond what the bench asks for, so that none of it is clipped.
#pragma once

#include "sim_server/scene/scene.h"

namespace palp::bench {

inline constexpr std::size_t kMostParticles = 100000;
inline constexpr double kToolMass = 0.15;  // [kg]
inline constexpr double kGap = 5e-3;       // between the tool and what is below it, at the start [m]

// A cube of 5 cm above a fixed plate, without gravity.
Scene wall_scene();
// A bar of 20 cm along y between two fixed jaws, kSlack from either: it may turn about z by kFreeTurn, until its ends
// meet them. Long, so that the give of the contacts at its ends is small beside the coupling's.
inline constexpr double kSlack = 0.5e-3;           // [m]
inline constexpr double kFreeTurn = kSlack / 0.1;  // [rad]
Scene vise_scene();
// The cube above an elastic block of 10 x 10 x 6 cm that holds on to the plate, and beside it a bare plate: the tool is
// at x = 0 over the block, and at x = kBareX over the plate.
inline constexpr double kBareX = 0.16;  // [m]
Scene elastic_scene();
// A ball of the tool's mass in the middle of a periodic box of a thick fluid that a body force can move as a whole.
Scene current_scene();
// A ball half under water in a tank.
Scene tank_scene();

}  // namespace palp::bench
