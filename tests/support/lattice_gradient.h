// Elasticity's choice of bonds, restated for blocks of a lattice.
#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

namespace palp::test {

// Returns whether the gradient at place i of a block on a lattice is taken from its bond with j: at corners from all
// bonds, elsewhere from those to the next 26 places that have a mirror image in the block, and from those that lead
// straight from a face or an edge to the next place.
inline bool in_gradient(const std::vector<Eigen::Vector3d>& X, std::size_t i, std::size_t j, double spacing) {
  const auto inside = [&](const Eigen::Vector3d& x) {
    return std::any_of(X.begin(), X.end(), [&](const Eigen::Vector3d& y) { return (x - y).norm() < 1e-3 * spacing; });
  };
  int single = 0;  // axes along which it has a neighbour on one side
  for (int a = 0; a < 3; ++a) {
    const Eigen::Vector3d step = spacing * Eigen::Vector3d::Unit(a);
    single += static_cast<int>(inside(X[i] + step) != inside(X[i] - step));
  }
  const Eigen::Vector3d bond = X[j] - X[i];
  return single == 3 || bond.norm() < 1.1 * spacing || (bond.norm() < 1.75 * spacing && inside(X[i] - bond));
}

}  // namespace palp::test
