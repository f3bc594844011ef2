// The smoothing kernels, restated by their textbook formulas in double precision.
#pragma once

#include <Eigen/Core>

namespace palp::test {

// H: support radius. Of fluids: Wendland C2 below 2.5 spacings, the quartic spline from there on, and the quintic one
// from 2.78 on.
double fluid_kernel(double r, double H, double spacing);
// Returns the sum of a fluid's kernel over a cubic lattice, times the volume of a cell; H: in spacings, at most 5.
double lattice_cover(double H);
Eigen::Vector3d fluid_gradient(const Eigen::Vector3d& x, double H, double spacing);
double wendland(double r, double H);
Eigen::Vector3d wendland_gradient(const Eigen::Vector3d& x, double H);
double poly6(double r, double H);
Eigen::Vector3d poly6_gradient(const Eigen::Vector3d& x, double H);
double viscosity_laplacian(double r, double H);

}  // namespace palp::test
