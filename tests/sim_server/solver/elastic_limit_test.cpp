#include "sim_server/solver/elastic_limit.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "sim_server/physics/smoothing.h"
#include "tests/support/lattice_gradient.h"

namespace palp::test::elastic_limit_test {
namespace {

// The highest frequency of a body whose energy is mu |G|^2 + lambda/2 tr(G)^2 a volume, G the corrected gradient of the
// displacements, and 0.3 E / 2 F |G X_ji - u_ji|^2 a pair of volumes, 0.15 E / 2 if balanced, against hourglass modes;
// by the eigenvalues of its whole stiffness matrix, in spacings and pressure wave speeds.
double highest_frequency(const std::vector<Eigen::Vector3d>& X, double support, double poisson, bool balanced) {
  const auto kernel = WendlandC2Of<double>::with_support(support);
  const auto n = static_cast<Eigen::Index>(X.size());
  const double shear = (1 - 2 * poisson) / (1 - poisson), hourglass = (balanced ? 0.15 : 0.3) * (1 + poisson) * shear;
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  const auto counts = [&](Eigen::Index i, Eigen::Index j) {
    return in_gradient(X, static_cast<std::size_t>(i), static_cast<std::size_t>(j), 1);
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    Eigen::MatrixXd g = Eigen::MatrixXd::Zero(3, n);  // column j: derivative of the gradient by u_j
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Vector3d r = X[static_cast<std::size_t>(j)] - X[static_cast<std::size_t>(i)];
      if (j != i && (!balanced || counts(i, j))) g.col(j) = kernel.F(r.norm()) * r;
      moment += g.col(j) * r.transpose();
    }
    g = moment.inverse() * g;
    g.col(i) = -g.rowwise().sum();
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        K.block(a * n, b * n, n, n) += (1 - shear) * g.row(a).transpose() * g.row(b);
        if (a == b) K.block(a * n, a * n, n, n) += shear * g.transpose() * g;
      }
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Vector3d r = X[static_cast<std::size_t>(j)] - X[static_cast<std::size_t>(i)];
      if (j == i || !(r.norm() < support) || (balanced && !counts(i, j))) continue;
      Eigen::VectorXd misfit = -(g.transpose() * r);
      misfit(j) += 1;
      misfit(i) -= 1;
      for (int a = 0; a < 3; ++a)
        K.block(a * n, a * n, n, n) += hourglass * kernel.F(r.norm()) * misfit * misfit.transpose();
    }
  }
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff());
}

// The power method's rounds are few, and its estimate of a frequency comes from below.
TEST(ElasticLimit, IsThatOfTheHighestFrequency) {
  for (const Eigen::Vector3i& n : {Eigen::Vector3i(2, 2, 2), Eigen::Vector3i(4, 4, 2), Eigen::Vector3i(4, 4, 3)})
    for (const double support : {2.0, 3.0})
      for (const double poisson : {-0.9, 0.0, 0.3, 0.49})
        for (const bool balanced : {false, true}) {
          const auto X = lattice_block(n);
          const double exact = 2 / highest_frequency(X, support, poisson, balanced);
          const double limit = free_elastic_limit(X, support, poisson, balanced);
          EXPECT_GE(limit, exact * (1 - 1e-9)) << n.transpose() << " H " << support << " nu " << poisson;
          EXPECT_LE(limit, exact * 1.03) << n.transpose() << " H " << support << " nu " << poisson;
        }
}

TEST(ElasticLimit, HasNoneForASingleParticle) {
  EXPECT_GT(free_elastic_limit(lattice_block({1, 1, 1}), 2, 0.3, true), 1e20);
}

TEST(ElasticLimit, OfPairsIsOneSpacing) {
  EXPECT_NEAR(free_elastic_limit(lattice_block({2, 1, 1}), 2, 0.3, true), 1, 1e-9);
}

}  // namespace
}  // namespace palp::test::elastic_limit_test
