#include "sim_server/solver/elastic_stencil.h"

#include <algorithm>
#include <limits>

namespace palp {

GradientCorrection<double> gradient_correction_of(const std::vector<RestBond>& bonds, const std::vector<bool>& counts,
                                                  double flat) {
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < bonds.size(); ++k)
    if (counts[k]) moment += bonds[k].weight * bonds[k].X * bonds[k].X.transpose();
  return gradient_correction(moment, flat);
}

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Lengths in spacings: the farthest from a mirror image that a neighbour may be (one of a lattice is there or a spacing
// off), and the longest bond that counts (1.73 on a lattice).
constexpr double kMirrored = 0.7, kLong = 1.8;
// How much longer the others are than a bond that leads straight out of a clamp, and the cosine to it of a bond that
// lies along the clamp's face.
constexpr double kAlone = 1.2, kLevel = 0.1;
// The share of the largest principal value of their moment that mirrored bonds have along each axis that they span;
// those of a jittered face have less along its normal.
constexpr double kSpanned = 0.1;
// The weight of a bond's part along the face against that across it, when one is looked for that leads inwards.
constexpr double kAskew = 4;
// The greatest stiffness of a gradient, over the spacing's inverse square: an edge's, 4.5, and room for rounding. With
// it, matter with a jitter of 0.15 spacings has 0.93 of a lattice's sub-step.
constexpr double kMostStiffness = 4.6;

// Returns the sum of the squares of a gradient's factors, the particle's own included [1/m^2].
double stiffness(const std::vector<RestBond>& bonds, const std::vector<bool>& counts) {
  const Matrix3d L = gradient_correction_of(bonds, counts, kFlatNeighborhood).inverse;
  double sum = 0;
  Vector3d own = Vector3d::Zero();
  for (std::size_t k = 0; k < bonds.size(); ++k) {
    if (!counts[k]) continue;
    const Vector3d g = bonds[k].weight * L * bonds[k].X;
    sum += g.squaredNorm();
    own -= g;
  }
  return sum + own.squaredNorm();
}

// Returns the bond that leads straightest and shortest into the directions that `missing` projects onto; their
// number where none does.
std::size_t inward_bond(const std::vector<RestBond>& bonds, const Matrix3d& missing, double longest) {
  std::size_t best = bonds.size();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < bonds.size(); ++k) {
    const Vector3d& X = bonds[k].X;
    const double into = (missing * X).norm(), aside = (X - missing * X).norm();
    if (!(X.norm() < longest) || !(into > 1e-3 * longest)) continue;
    const double error = into + kAskew * aside * aside / into;
    if (error > least * (1 - 1e-9)) continue;
    least = error;
    best = k;
  }
  return best;
}

}  // namespace

bool takes_balanced_bonds(const MaterialConfig& material) { return !material.tear_strain; }

std::vector<bool> balanced_bonds(const std::vector<RestBond>& bonds, double spacing) {
  const double longest = kLong * spacing, near = kMirrored * spacing;
  const auto mirrored = [&](const Vector3d& X) {
    return std::any_of(bonds.begin(), bonds.end(), [&](const RestBond& other) { return (other.X + X).norm() < near; });
  };
  const std::vector<bool> all(bonds.size(), true);
  std::vector<bool> counts(bonds.size());
  for (std::size_t k = 0; k < bonds.size(); ++k) counts[k] = bonds[k].X.norm() < longest && mirrored(bonds[k].X);
  if (counts == all) return all;  // within a lattice
  Matrix3d missing = gradient_correction_of(bonds, all, kFlatNeighborhood).projection -
                     gradient_correction_of(bonds, counts, kSpanned).projection;
  while (missing.trace() > 0.5) {
    const std::size_t k = inward_bond(bonds, missing, longest);
    if (k == bonds.size()) return all;
    counts[k] = true;
    const Vector3d n = (missing * bonds[k].X).normalized();
    missing -= n * n.transpose();
  }
  return stiffness(bonds, counts) > kMostStiffness / (spacing * spacing) ? all : counts;
}

std::vector<bool> bonds_of_clamp(const std::vector<RestBond>& bonds, double spacing) {
  const RestBond* straight = nullptr;
  double shortest = kLong * spacing, next = shortest;
  for (const RestBond& bond : bonds) {
    if (!bond.elastic || bond.X.norm() >= next) continue;
    next = bond.X.norm();
    if (next >= shortest) continue;
    std::swap(shortest, next);
    straight = &bond;
  }
  const bool alone = straight != nullptr && next > kAlone * shortest;
  const auto level = [&](const Vector3d& X) { return std::abs(X.dot(straight->X)) < kLevel * X.norm() * shortest; };
  std::vector<bool> counts;
  for (const RestBond& bond : bonds) {
    const bool here = bond.X.norm() < kLong * spacing;
    counts.push_back(here && (alone ? &bond == straight || (!bond.elastic && level(bond.X)) : bond.elastic));
  }
  return counts;
}

}  // namespace palp
