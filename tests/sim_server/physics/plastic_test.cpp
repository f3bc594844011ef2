// Plasticity of one particle, and of blocks one evaluation at a time: against a restatement in double precision that
// keeps another state, against uniaxial theory, under rotations.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "config/error.h"
#include "tests/support/elastic_stages.h"
#include "tests/support/random.h"
#include "tests/support/tolerance.h"

namespace palp::test::plastic_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSpacing = 0.01, kYoung = 1e5, kPoisson = 0.35, kYield = 2e3, kHardening = 8e3;

MaterialConfig dough(double hardening) {
  MaterialConfig m;
  m.name = "dough";
  m.density = 1000;
  m.young_modulus = kYoung;
  m.poisson_ratio = kPoisson;
  m.yield_stress = kYield;
  m.hardening = hardening;
  return m;
}

// The same law from another state: the elastic left Cauchy-Green tensor, from the inverse of the plastic right one.
struct Restated {
  MaterialConfig m;
  Matrix3d inverse_C = Matrix3d::Identity();
  double hardened = 0;

  // P; the yield condition and the energy on the way
  Matrix3d stress(const Matrix3d& F) {
    const double mu = shear_modulus(m), bulk = lame_lambda(m) + 2 * mu / 3;
    const Eigen::SelfAdjointEigenSolver<Matrix3d> trial(F * inverse_C * F.transpose());
    const Matrix3d& n = trial.eigenvectors();
    Vector3d e = 0.5 * trial.eigenvalues().array().log();
    const double volume = e.sum();
    Vector3d s = 2 * mu * (e - Vector3d::Constant(volume / 3));
    const double radius = std::sqrt(2.0 / 3) * (*m.yield_stress + m.hardening * hardened);
    if (s.norm() > radius) {
      const double flow = (s.norm() - radius) / (2 * mu + 2 * m.hardening / 3);
      e -= flow * s / s.norm();
      s *= 1 - 2 * mu * flow / s.norm();
      hardened += std::sqrt(2.0 / 3) * flow;
    }
    const Matrix3d left = n * (2 * e).array().exp().matrix().asDiagonal() * n.transpose();
    inverse_C = F.inverse() * left * F.inverse().transpose();
    const Vector3d tau = s + Vector3d::Constant(bulk * volume);
    energy = s.squaredNorm() / (4 * mu) + 0.5 * bulk * volume * volume;
    return n * tau.asDiagonal() * n.transpose() * F.inverse().transpose();
  }
  double energy = 0;
};

struct Particle {
  Material m;
  Quat q = Quat::Identity();
  Mat3 inverse = Mat3::Identity();
  real hardened = 0;

  explicit Particle(double hardening) {
    Scene scene = empty_scene(kSpacing, {-1, -1, -1}, {1, 1, 1});
    scene.config.materials.push_back(dough(hardening));
    add_body(scene, "dough", BodyKind::elastic, 0, {0, 0, 0}, Vector3d::Constant(kSpacing));
    m = make_medium(scene, make_plan(scene)).material[0];
  }
  Matrix3d stress(const Matrix3d& F) { return plastic_stress(m, F.cast<real>(), q, inverse, hardened).cast<double>(); }
  double energy(const Matrix3d& F) const {
    const Mat3 Fe = F.cast<real>() * inverse;
    return plastic_energy(m, Fe, closest_rotation(Fe, q).toRotationMatrix());
  }
};

class PlasticTest : public RandomCase {
 protected:
  // A path of many small steps that goes back and forth, yields often and stays within a few tens of percent.
  std::vector<Matrix3d> path(int steps) {
    std::vector<Matrix3d> out;
    const Matrix3d A = matrix(0.12), B = matrix(0.12), C = matrix(0.12);
    for (int k = 1; k <= steps; ++k) {
      const double t = 6.3 * k / steps;
      out.push_back(Matrix3d::Identity() + std::sin(t) * A + std::sin(2 * t) * B + std::sin(3 * t) * C);
    }
    return out;
  }
};

TEST_F(PlasticTest, PrincipalAxesRebuildTheMatrix) {
  for (int round = 0; round < 3000; ++round) {
    const Matrix3d Q = rotation();
    Vector3d value(between(-1, 1), between(-1, 1), between(-1, 1));
    if (round % 3 == 1) value[1] = value[0];
    if (round % 3 == 2) value = Vector3d(1e-4 * value[0], 1, 0);
    const Matrix3d A = Q * value.asDiagonal() * Q.transpose();
    const PrincipalAxes found = principal_axes(A.cast<real>());
    const Matrix3d n = found.axis.cast<double>();
    EXPECT_TRUE(within((n.transpose() * n - Matrix3d::Identity()).norm(), tol::kRotation));
    EXPECT_TRUE(within((n * found.value.cast<double>().asDiagonal() * n.transpose() - A).norm(), tol::kRotation));
  }
}

TEST_F(PlasticTest, FollowsTheLawRestated) {
  for (const double hardening : {0.0, kHardening})
    for (int round = 0; round < 20; ++round) {
      Particle particle(hardening);
      Restated exact{dough(hardening)};
      for (const Matrix3d& F : path(300)) {
        const Matrix3d P = exact.stress(F);
        EXPECT_TRUE(within((particle.stress(F) - P).norm() / kYield, tol::kPlasticStress));
        EXPECT_TRUE(within((particle.energy(F) - exact.energy) / (kYield * kYield / kYoung), tol::kPlasticEnergy));
      }
      ASSERT_GT(exact.hardened, 0.1);
      EXPECT_TRUE(within(particle.hardened - exact.hardened, tol::kPlasticStrain));
      // the flow has kept the volume
      EXPECT_TRUE(within(particle.inverse.cast<double>().determinant() - 1, tol::kPlasticVolume));
    }
}

// The law does not depend on the observer, however that one turns.
TEST_F(PlasticTest, TurnsWithTheObserver) {
  for (int round = 0; round < 20; ++round) {
    Particle still(kHardening), turned(kHardening);
    const Vector3d axis = rotation().col(0);
    const double speed = between(0.01, 0.1);
    const Matrix3d start = rotation();
    int k = 0;
    for (const Matrix3d& F : path(300)) {
      const Matrix3d Q = Eigen::AngleAxisd(speed * ++k, axis).toRotationMatrix() * start;
      const Matrix3d P = still.stress(F), P_turned = turned.stress(Q * F);
      EXPECT_TRUE(within((P_turned - Q * P).norm() / kYield, tol::kPlasticStress));
    }
    EXPECT_TRUE(within((still.inverse - turned.inverse).norm(), tol::kPlasticStrain));
  }
}

// The work put in is at least what is stored: flow takes energy and never gives any.
TEST_F(PlasticTest, FlowOnlyTakesEnergy) {
  for (int round = 0; round < 50; ++round) {
    Particle particle(round % 2 ? kHardening : 0);
    for (const Matrix3d& F : path(40)) {
      const double before = particle.energy(F);
      particle.stress(F);
      EXPECT_LE(particle.energy(F), before * (1 + 1e-5) + 1e-3);
    }
  }
}

// Squeezed flat, turned inside out, blown up: finite, and its state stays what it has to be.
TEST_F(PlasticTest, SurvivesAnything) {
  for (int round = 0; round < 2000; ++round) {
    Particle particle(round % 2 ? kHardening : 0);
    for (int k = 0; k < 5; ++k) {
      Matrix3d F = matrix(k % 2 ? 30 : 1);
      if (round % 4 == 1) F.col(0).setZero();
      if (round % 4 == 2) F = Matrix3d::Zero();
      if (round % 4 == 3) F.col(1) = F.col(0);
      EXPECT_TRUE(particle.stress(F).allFinite());
      EXPECT_TRUE(within(particle.inverse.cast<double>().determinant() - 1, tol::kPlasticVolume));
      EXPECT_LT(particle.inverse.norm(), kMaxFlow);
    }
  }
}

Scene bar(double hardening) {
  Scene scene = empty_scene(kSpacing, {-1, -1, -1}, {1, 1, 1});
  scene.config.materials.push_back(dough(hardening));
  add_body(scene, "bar", BodyKind::elastic, 0, {0, 0, 0}, {12 * kSpacing, 4 * kSpacing, 4 * kSpacing});
  return scene;
}

// Force through the middle of a bar of logarithmic strains e along x and c across.
double section_force(Elastic& elastic, double e, double c) {
  elastic.deform(
      [&](const Vector3d& X) { return Vector3d(std::exp(e) * X.x(), std::exp(c) * X.y(), std::exp(c) * X.z()); });
  const std::vector<Vector3d> f = elastic.forces();
  double half = 0;
  for (std::size_t i = 0; i < f.size(); ++i)
    if (elastic.scene().position[i].x() < 6 * kSpacing) half += f[i].x();
  return half;
}

// Pulled, pushed and let go: s = E e up to the yield stress, then (E s_y + H ...) on the line of slope E H / (E + H),
// and back along E. The bar narrows by Poisson's ratio of the elastic strain and by half of the plastic one.
TEST_F(PlasticTest, BarFollowsTheStressStrainCurve) {
  for (const double hardening : {0.0, kHardening})
    for (const double sign : {1.0, -1.0}) {
      Elastic elastic(bar(hardening));
      const double area = 16 * kSpacing * kSpacing, slope = kYoung * hardening / (kYoung + hardening);
      const double first = kYield / kYoung, most = 0.15;
      const auto check = [&](double e, double tau) {
        const double plastic = e - tau / kYoung;
        const double force = section_force(elastic, sign * e, sign * (-kPoisson * tau / kYoung - plastic / 2));
        const double exact = sign * tau / std::exp(sign * e) * area;
        EXPECT_TRUE(within((force - exact) / (kYield * area), tol::kPlasticCurve)) << "strain " << sign * e;
        EXPECT_TRUE(within(elastic.hardened[0] - plastic, tol::kPlasticStrain)) << "strain " << sign * e;
      };
      check(0.5 * first, 0.5 * kYield);
      check(0.99 * first, 0.99 * kYield);
      double tau = 0;
      for (double e = 0.03; e <= most + 1e-9; e += 0.01) check(e, tau = kYield + slope * (e - first));
      // let go: the elastic strain comes back, the rest stays
      const double stays = most - tau / kYoung;
      EXPECT_GT(stays, 0.1);
      const double released = section_force(elastic, sign * stays, -sign * stays / 2);
      EXPECT_TRUE(within(released / (kYield * area), tol::kPlasticCurve));
      EXPECT_TRUE(within(elastic.hardened[0] - stays, tol::kPlasticStrain));
    }
}

TEST_F(PlasticTest, ForcesTurnWithTheBodyAndKeepBothMomenta) {
  Elastic still(bar(kHardening), true), turned(bar(kHardening), true);
  const double scale = kYield * kSpacing * kSpacing;
  const Matrix3d A = matrix(0.1);
  for (int k = 1; k <= 10; ++k) {
    const Matrix3d Q = rotation(), F = Matrix3d::Identity() + 0.1 * k * A;
    const auto bent = [&](const Vector3d& X) {
      return Vector3d(F * X + 0.02 * k * kSpacing * Vector3d(std::sin(90 * X.y()), std::sin(70 * X.z()), 0));
    };
    still.deform(bent);
    const std::vector<Vector3d> f = still.forces();
    turned.deform([&](const Vector3d& X) { return Vector3d(Q * bent(X)); });
    const std::vector<Vector3d> f_turned = turned.forces();
    Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
    double force_size = 0, torque_size = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
      EXPECT_TRUE(within((f_turned[i] - Q * f[i]).norm() / scale, tol::kPlasticForce));
      const Vector3d moment = still.place(i).cross(f[i]);
      force += f[i];
      torque += moment;
      force_size += f[i].norm();
      torque_size += moment.norm();
    }
    EXPECT_TRUE(within(force.norm() / force_size, tol::kElasticMomentum));
    EXPECT_TRUE(within(torque.norm() / torque_size, tol::kElasticMomentum));
  }
  EXPECT_GT(still.hardened[100], 0.01);
}

// Below the yield stress nothing stays, and at small strains the law is that of what does not yield.
TEST_F(PlasticTest, BelowYieldItIsElastic) {
  Scene plain = bar(0);
  plain.config.materials[0].yield_stress.reset();
  Elastic yields(bar(0)), elastic(plain);
  const Matrix3d F = Matrix3d::Identity() + matrix(0.002);
  for (Elastic* each : {&yields, &elastic}) each->deform([&](const Vector3d& X) { return Vector3d(F * X); });
  const std::vector<Vector3d> a = yields.forces(), b = elastic.forces();
  double size = 0, off = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    size = std::max(size, b[i].norm());
    off = std::max(off, (a[i] - b[i]).norm());
  }
  EXPECT_LT(off, 0.02 * size);
  for (const real h : yields.hardened) EXPECT_EQ(h, 0);
}

TEST_F(PlasticTest, ThePapersMethodRefusesIt) {
  Scene scene = bar(0);
  scene.config.method = Method::paper;
  EXPECT_THROW(make_plan(scene), ConfigError);
}

}  // namespace
}  // namespace palp::test::plastic_test
