// Which bonds break, and what is left of the neighbourhoods: one evaluation at a time.
#include <map>

#include <gtest/gtest.h>

#include "config/error.h"
#include "tests/support/elastic_stages.h"
#include "tests/support/random.h"
#include "tests/support/tolerance.h"

namespace palp::test::tear_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSpacing = 0.01, kYoung = 1e5, kTear = 0.2;

Scene block(int nx, int ny, int nz, double support = 2) {
  Scene scene = empty_scene(kSpacing, {-1, -1, -1}, {1, 1, 1});
  add_material(scene, 1000, 0);
  scene.config.materials[0].young_modulus = kYoung;
  scene.config.materials[0].tear_strain = kTear;
  scene.config.numerics.support_over_spacing = support;
  add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, {nx * kSpacing, ny * kSpacing, nz * kSpacing});
  return scene;
}

using TearTest = RandomCase;

std::size_t count_torn(const Elastic& elastic) {
  std::size_t n = 0;
  for (const std::uint8_t t : elastic.torn) n += t;
  return n;
}

TEST_F(TearTest, HoldsUpToItsStrainAndNoFurther) {
  for (const double support : {2.0, 3.0}) {
    Elastic elastic(block(6, 4, 4, support));
    const Matrix3d Q = rotation();
    for (const double strain : {0.1, 0.99 * kTear, -0.5, 1.01 * kTear}) {
      elastic.deform([&](const Vector3d& X) { return Vector3d(Q * Vector3d((1 + strain) * X.x(), X.y(), X.z())); });
      elastic.forces();
      elastic.forces();  // a tear follows the strain of the evaluation before
      EXPECT_EQ(count_torn(elastic) > 0, strain > kTear) << strain;
    }
    // those across the stretch and no others
    const ElasticStore& s = elastic.store();
    for (std::uint32_t i = 0; i + 1 < s.first.size(); ++i)
      for (std::uint32_t k = s.first[i]; k < s.first[i + 1]; ++k) {
        const Vec3 X = s.rest[s.neighbor[k]].xyz() - s.rest[i].xyz();
        EXPECT_EQ(elastic.torn[k] != 0, std::abs(X.x()) > 0.5 * X.norm());
      }
  }
}

// A cut through the middle: each half has exact gradients of its own, feels nothing of the other, and keeps momenta.
TEST_F(TearTest, HalvesAreBodiesOfTheirOwn) {
  for (const double support : {2.0, 3.0}) {
    Elastic elastic(block(8, 4, 4, support), true);
    const double cut = 4 * kSpacing;
    const auto torn_by = [&](double gap) {
      elastic.deform([&](const Vector3d& X) { return Vector3d(X.x() > cut ? X.x() + gap : X.x(), X.y(), X.z()); });
      elastic.forces();
      elastic.forces();
    };
    torn_by(0.6 * kSpacing);
    torn_by(3 * kSpacing);
    for (int round = 0; round < 5; ++round) {
      const Matrix3d A = rotation(), B = rotation();
      // not next to nothing: forces are compared with their sum
      const Matrix3d stretch = Vector3d(1 + between(0.05, 0.1), 1 - between(0.05, 0.1), 1).asDiagonal();
      const Vector3d shift = vector(0.05);
      elastic.deform(
          [&](const Vector3d& X) { return X.x() > cut ? Vector3d(B * stretch * X + shift) : Vector3d(A * X); });
      const std::vector<Vector3d> f = elastic.forces();
      Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
      double size = 0, torque_size = 0;
      for (std::size_t i = 0; i < f.size(); ++i) {
        const bool right = elastic.scene().position[i].x() > cut;
        const Matrix3d F = elastic.gradient[i].cast<double>();
        EXPECT_TRUE(within((F - (right ? Matrix3d(B * stretch) : A)).norm(), tol::kElasticGradient));
        if (!right) {
          EXPECT_TRUE(within(f[i].norm() / (kYoung * kSpacing * kSpacing), tol::kElasticForce));
          continue;
        }
        const Vector3d moment = elastic.place(i).cross(f[i]);
        force += f[i];
        torque += moment;
        size += f[i].norm();
        torque_size += moment.norm();
      }
      EXPECT_TRUE(within(force.norm() / size, tol::kElasticMomentum));
      EXPECT_TRUE(within(torque.norm() / torque_size, tol::kElasticMomentum));
    }
  }
}

// Whatever is done to it: a bond is broken in both lists or in none, and forces balance in every evaluation.
TEST_F(TearTest, PairsBreakTogetherAndForcesBalance) {
  Elastic elastic(block(6, 6, 5), true);
  std::size_t before = 0;
  for (int round = 1; round < 12; ++round) {
    const Matrix3d Q = rotation();
    elastic.deform([&](const Vector3d& X) { return Vector3d(Q * X + vector(0.05 * round * kSpacing)); });
    const std::vector<Vector3d> f = elastic.forces();
    const ElasticStore& s = elastic.store();
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> broken;
    for (std::uint32_t i = 0; i + 1 < s.first.size(); ++i)
      for (std::uint32_t k = s.first[i]; k < s.first[i + 1]; ++k)
        if (elastic.torn[k]) ++broken[std::minmax(i, s.neighbor[k])];
    for (const auto& [pair, times] : broken) EXPECT_EQ(times, 2) << pair.first << " " << pair.second;
    EXPECT_GE(broken.size(), before) << "healed";
    before = broken.size();
    Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
    double size = 1e-9, torque_size = 1e-9;
    for (std::size_t i = 0; i < f.size(); ++i) {
      ASSERT_TRUE(f[i].allFinite());
      const Vector3d moment = elastic.place(i).cross(f[i]);
      force += f[i];
      torque += moment;
      size += f[i].norm();
      torque_size += moment.norm();
    }
    EXPECT_TRUE(within(force.norm() / size, tol::kElasticMomentum));
    EXPECT_TRUE(within(torque.norm() / torque_size, tol::kElasticMomentum));
  }
  EXPECT_GT(before, 100u);
}

TEST_F(TearTest, ThePapersMethodRefusesIt) {
  Scene scene = block(2, 2, 2);
  scene.config.method = Method::paper;
  EXPECT_THROW(make_plan(scene), ConfigError);
}

}  // namespace
}  // namespace palp::test::tear_test
