// The stress by which matter that is pressed resists the rate of its strain.
#include "sim_server/physics/contact_stress.h"
#include "tests/support/random.h"

namespace palp::test {
namespace {

using Eigen::Matrix3d;

constexpr double kMu = 4e4, kDensity = 900, kSpacing = 0.02, kStep = 2e-4;
constexpr double kWave = 6.666666666666667;  // sqrt(mu / density) [m/s]

class ContactDamping : public RandomCase {
 protected:
  static Matrix3d stress(const Matrix3d& before, const Matrix3d& F) {
    return contact_damping(before.cast<real>(), F.cast<real>(), real(kMu), real(kDensity), real(kSpacing), real(kStep))
        .cast<double>();
  }
  Matrix3d strained() { return rotation() * (Matrix3d::Identity() + matrix(0.4)); }
};

TEST_F(ContactDamping, TakesWorkFromEveryStrainAndTurnsNothing) {
  for (int n = 0; n < 200; ++n) {
    const Matrix3d before = strained(), F = before + matrix(1e-2), P = stress(before, F);
    EXPECT_GT(P.cwiseProduct(F - before).sum(), 0);
    const Matrix3d cauchy = P * F.transpose();
    EXPECT_LT((cauchy - cauchy.transpose()).norm(), 1e-5 * cauchy.norm());
  }
}

TEST_F(ContactDamping, IsNoneInATurn) {
  for (int n = 0; n < 50; ++n) {
    const Matrix3d before = strained();
    const Matrix3d F = Eigen::AngleAxisd(0.05, vector(1).normalized()) * before;
    const Matrix3d stretch = before + 0.05 * before;
    EXPECT_LT(stress(before, F).norm(), 1e-3 * stress(before, stretch).norm());
  }
}

TEST_F(ContactDamping, HasAFifthOfTheImpedanceOfShearWavesAcrossASpacing) {
  const double rate = 2;  // [1/s]
  Matrix3d F = Matrix3d::Identity();
  F(2, 2) -= rate * kStep;
  const double viscosity = 0.2 * kSpacing * kDensity * kWave;
  EXPECT_NEAR(stress(Matrix3d::Identity(), F)(2, 2), -viscosity * rate, 2e-3 * viscosity * rate);
}

TEST_F(ContactDamping, DoesNotGrowWithAStretch) {
  Matrix3d before = Matrix3d::Identity();
  before(0, 0) = 2;
  Matrix3d F = before;
  F(0, 0) += 1e-3;
  // F S has 2 (4 times 0.001), of which (tr C - 2)^2 = 16 leaves a sixteenth
  const double viscosity = 0.2 * kSpacing * kDensity * kWave;
  EXPECT_NEAR(stress(before, F)(0, 0), 2 * 2e-3 * viscosity / kStep / 16, 5e-3 * 4e-3 * viscosity / kStep / 16);
}

}  // namespace
}  // namespace palp::test
