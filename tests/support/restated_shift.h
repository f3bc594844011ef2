// Particle shifting (physics/shift.h), restated in double precision.
#pragma once

#include <algorithm>
#include <cstdint>

#include "tests/support/equations.h"
#include "tests/support/kernels.h"

namespace palp::test {

// Each component from -1 to 1, by three rounds of mixing a number of the particle's and the axis' own.
inline Eigen::Vector3d own_direction(std::size_t particle) {
  Eigen::Vector3d n;
  for (std::uint64_t a = 0; a < 3; ++a) {
    std::uint64_t h = (particle * 3 + a + 1) & 0xffffffffu;
    h ^= h >> 16;
    h = h * 0x7feb352d & 0xffffffffu;
    h ^= h >> 15;
    h = h * 0x846ca68b & 0xffffffffu;
    h ^= h >> 16;
    n[static_cast<int>(a)] = static_cast<double>(h >> 8) / 8388608 - 1;
  }
  return n;
}

// Returns by how much a particle is shifted: e dt (k H^2 (S - s) + 0.2 dx n), k e dt at most 0.1, in layer 3, all of it
// up to e dx^2 / nu = 2, none from 4 on and linearly between.
inline Eigen::Vector3d shift_of(const Restated& w, std::size_t i) {
  const MaterialConfig& fluid = w.scene->config.materials[w.scene->bodies[w.scene->body[i]].material];
  const double reynolds = w.strain[i] * std::pow(w.scene->spacing, 2) * fluid.density / fluid.viscosity;
  if (w.layer[i] < 3 || reynolds >= 4) return Eigen::Vector3d::Zero();
  const double H = w.plan.support, k = w.plan.shift, strained = std::min(w.strain[i] * w.plan.dt, 0.1 / k);
  return std::min(1.0, 2 - reynolds / 2) * strained *
         (k * H * H * (w.slope[i] - w.smooth[i]) + 0.2 * w.scene->spacing * own_direction(i));
}

// Finds layers and s anew by what neighbours had: a layer is one more than the least around, 0 on a surface and 3 at
// most; s is the mean of S by V W. for_pairs(w, i, f) calls f(j, x_ij) for neighbours; lattice: C of a lattice.
template <class Pairs>
void look_around(Restated& w, double lattice, Pairs&& for_pairs) {
  const std::vector<int> before = w.layer;
  const double H = w.plan.support, dx = w.scene->spacing;
  for (std::size_t i = 0; i < w.x.size(); ++i) {
    double cover = w.V[i] * fluid_kernel(0, H, dx);
    Eigen::Vector3d sum = cover * w.slope[i];
    w.layer[i] = 3;
    for_pairs(w, i, [&](std::size_t j, const Eigen::Vector3d& x_ij) {
      const double VW = w.V[j] * fluid_kernel(x_ij.norm(), H, dx);
      cover += VW;
      sum += VW * w.slope[j];
      w.layer[i] = std::min(w.layer[i], std::max(0, before[j]) + 1);
    });
    const double full = cover / lattice;
    if (full < 0.6 || (full < 0.9 && w.slope[i].norm() * H > 0.9)) w.layer[i] = 0;
    w.smooth[i] = w.layer[i] == 3 ? Eigen::Vector3d(sum / cover) : Eigen::Vector3d::Zero();
  }
}

}  // namespace palp::test
