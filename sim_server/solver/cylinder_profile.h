// The shares of a cylinder without ends (physics/wall_share.h), which are no polynomials, by the distance from its
// axis. Host only.
#pragma once

#include <vector>

#include "sim_server/physics/real.h"
#include "sim_server/physics/smoothing.h"

namespace palp {

inline constexpr int kProfileParts = 128;

// Returns kProfileParts + 1 nodes from the axis to radius + support: share [-], slope [1/m] and pull along the normal
// and around the axis [-], each for the support radius [m]. By quadrature in double precision, within 1e-4.
std::vector<Packed> cylinder_profile(double radius, const FluidKernelOf<double>& kernel);

}  // namespace palp
