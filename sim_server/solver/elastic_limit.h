// The largest stable step of an elastic body with free surfaces, by linear theory.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace palp {

// Returns the largest stable sub-step of method "accurate"'s elasticity, its hourglass forces included, times the speed
// of pressure waves, in spacings: 2 / w for the highest frequency w of these particles, at any rotation and stretch. At
// free surfaces, and at corners most, the corrected gradients are stiffer than within a lattice: corners of a block
// have 0.6 to 0.4 of an infinite lattice's limit, bodies of two layers less. positions: at rest, in spacings, each of a
// spacing's volume. support: radius of the kernel, in spacings; balanced: gradients are taken from
// balanced bonds (elastic_stencil.h). Takes a few milliseconds for a few hundred particles.
double free_elastic_limit(const std::vector<Eigen::Vector3d>& positions, double support, double poisson_ratio,
                          bool balanced);

// Returns a lattice of n particles along each axis, in spacings.
std::vector<Eigen::Vector3d> lattice_block(const Eigen::Vector3i& n);

}  // namespace palp
