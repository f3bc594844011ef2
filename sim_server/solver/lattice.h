// Sums of kernels over the cubic lattice that particles start on. Lengths are in units of its spacing. Host only.
#pragma once

#include <algorithm>
#include <cmath>

#include "sim_server/physics/smoothing.h"

namespace palp {

inline constexpr int kWholeLattice = 1000;

// The sums at one particle of a lattice, V being 1.
struct LatticeSums {
  double W = 0;       // sum V W, the particle itself included
  double F = 0;       // sum V F without the particle itself
  double moment = 0;  // sum V F x^2, the same along each axis of a whole lattice
};

// Returns the sums for a lattice that ends `rows_above` rows above the particle. H: support radius over spacing.
inline LatticeSums lattice_sums(double H, int rows_above = kWholeLattice) {
  const auto kernel = FluidKernelOf<double>::with_support(H, 1);
  const int reach = static_cast<int>(H) + 1;
  LatticeSums sum;
  for (int x = -reach; x <= reach; ++x)
    for (int y = -reach; y <= reach; ++y)
      for (int z = -reach; z <= std::min(reach, rows_above); ++z) {
        const double r = std::sqrt(double(x * x + y * y + z * z)), F = kernel.F(r);
        sum.W += kernel.W(r);
        sum.F += x != 0 || y != 0 || z != 0 ? F : 0;
        sum.moment += F * x * x;
      }
  return sum;
}

}  // namespace palp
