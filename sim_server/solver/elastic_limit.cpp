#include "sim_server/solver/elastic_limit.h"

#include <cmath>

#include "sim_server/physics/elastic.h"
#include "sim_server/solver/elastic_stencil.h"

namespace palp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Rounds of the power method. Its estimate comes from below; after so many it is within 2 % (elastic_limit_test.cpp).
constexpr int kRounds = 60;

struct Bond {
  std::size_t j;
  Vector3d X;  // X_ji
  double F;
  Vector3d g;  // of the gradient at i: grad u = sum (u_j - u_i) g^T
};

std::vector<std::vector<Bond>> bonds_of(const std::vector<Vector3d>& X, double support, bool balanced) {
  const auto kernel = WendlandC2Of<double>::with_support(support);
  std::vector<std::vector<Bond>> bonds(X.size());
  for (std::size_t i = 0; i < X.size(); ++i) {
    std::vector<Bond> near;
    std::vector<RestBond> at_rest;
    for (std::size_t j = 0; j < X.size(); ++j) {
      const Vector3d r = X[j] - X[i];
      const double F = j != i ? kernel.F(r.norm()) : 0;
      if (!(F > 0)) continue;
      near.push_back({j, r, F, F * r});
      at_rest.push_back({r, F, true});
    }
    const std::vector<bool> counts = balanced ? balanced_bonds(at_rest, 1) : std::vector<bool>(near.size(), true);
    for (std::size_t k = 0; k < near.size(); ++k)
      if (counts[k]) bonds[i].push_back(near[k]);
    const Matrix3d L = gradient_correction_of(at_rest, counts, kFlatNeighborhood).inverse;
    for (Bond& b : bonds[i]) b.g = L * b.g;
  }
  return bonds;
}

// Stiffnesses over lambda + 2 mu: 2 mu, and beta E.
struct Moduli {
  double shear, hourglass;
};

// Returns K u: the force of the stress 2 mu G + lambda tr(G) I, which bounds that of any rotation and stretch, and that
// against hourglass modes (physics/elastic.h).
void apply(const std::vector<std::vector<Bond>>& bonds, const Moduli& m, const std::vector<Vector3d>& u,
           std::vector<Vector3d>& force) {
  for (Vector3d& f : force) f.setZero();
  for (std::size_t i = 0; i < u.size(); ++i) {
    Matrix3d G = Matrix3d::Zero();
    for (const Bond& b : bonds[i]) G += (u[b.j] - u[i]) * b.g.transpose();
    const Matrix3d P = m.shear * G + (1 - m.shear) * G.trace() * Matrix3d::Identity();
    for (const Bond& b : bonds[i]) {
      const Vector3d f = P * b.g + m.hourglass * b.F * (u[b.j] - u[i] - G * b.X);
      force[b.j] += f;
      force[i] -= f;
    }
  }
}

}  // namespace

double free_elastic_limit(const std::vector<Vector3d>& positions, double support, double poisson_ratio, bool balanced) {
  if (positions.size() < 2) return 1e30;
  const auto bonds = bonds_of(positions, support, balanced);
  const double nu = poisson_ratio, shear = (1 - 2 * nu) / (1 - nu);
  const double share = static_cast<double>(balanced ? kBalancedHourglassShare : kHourglassShare);
  const Moduli m{shear, share * (1 + nu) * shear};
  std::vector<Vector3d> u(positions.size()), force(positions.size());
  for (std::size_t i = 0; i < u.size(); ++i)  // some of every mode, the same each time
    u[i] = Vector3d(std::sin(1.0 + 2.7 * double(i)), std::cos(2.0 + 3.1 * double(i)), std::sin(0.5 + 1.9 * double(i)));
  double largest = 0;
  for (int round = 0; round < kRounds; ++round) {
    double size = 0, product = 0;
    for (const Vector3d& x : u) size += x.squaredNorm();
    if (!(size > 0)) break;
    for (Vector3d& x : u) x /= std::sqrt(size);
    apply(bonds, m, u, force);
    for (const Vector3d& f : force) product += f.squaredNorm();
    largest = std::sqrt(product);
    u.swap(force);
  }
  return largest > 0 ? 2 / std::sqrt(largest) : 1e30;
}

std::vector<Vector3d> lattice_block(const Eigen::Vector3i& n) {
  std::vector<Vector3d> out;
  for (int k = 0; k < n.z(); ++k)
    for (int j = 0; j < n.y(); ++j)
      for (int i = 0; i < n.x(); ++i) out.emplace_back(i, j, k);
  return out;
}

}  // namespace palp
