// The implicit solve's linear problem, stage by stage on the host.
#include "sim_server/physics/conjugate_gradients.h"

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/elastic_stages.h"
#include "tests/support/random.h"
#include "tests/support/tolerance.h"

namespace palp::test::implicit_elastic_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSpacing = 0.01, kYoung = 1e7, kPoisson = 0.3, kStep = 1e-3;

Scene block(const std::array<int, 3>& n) {
  Scene scene = empty_scene(kSpacing, {-1, -1, -1}, {1, 1, 1});
  scene.config.gravity.setZero();
  add_material(scene, 1000, 0);
  scene.config.materials[0].young_modulus = kYoung;
  scene.config.materials[0].poisson_ratio = kPoisson;
  scene.config.materials[0].damping = 500;
  scene.config.numerics.elastic_solver = ElasticSolver::implicit;
  scene.config.numerics.sub_steps = 1;
  add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, kSpacing * Vector3d(n[0], n[1], n[2]));
  return scene;
}

class Solve {
 public:
  explicit Solve(const std::array<int, 3>& n) : elastic(block(n)) {
    const std::size_t count = elastic.plan().elastic_count;
    for (auto* field : {&predicted_, &residual_, &scaled_, &outer_, &image_, &direction_, &advance_, &change_, &force_})
      field->assign(count, Packed{0, 0, 0, 0});
    rotation_.assign(count, Quat::Identity());
    solve_.predicted = predicted_.data();
    solve_.rotation = rotation_.data();
    solve_.residual = residual_.data();
    solve_.scaled = scaled_.data();
    solve_.outer = outer_.data();
    solve_.image = image_.data();
    solve_.direction = direction_.data();
    solve_.advance = advance_.data();
    solve_.change = change_.data();
    bodies_.force = force_.data();
    pair_.resize(elastic.store().neighbor.size());
    solve_.pair = pair_.data();
    const auto kernel = WendlandC2::with_support(static_cast<real>(elastic.plan().elastic_support));
    const ListPairs list{elastic.views(), solve_, elastic.grid(), kernel};
    for (std::uint32_t i = 0; i < count; ++i) list(i);
  }

  // dt f of velocities.
  std::vector<Vector3d> impulse(const std::vector<Vector3d>& v) {
    std::size_t i = 0;
    const auto places = places_;
    elastic.deform([&](const Vector3d& X) { return places(X); }, [&](const Vector3d&) { return v[i++]; });
    const ElasticViews e = elastic.views();
    const Forcing none{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), false};
    const BeginImplicit begin{e, solve_, bodies_, elastic.medium(), elastic.grid(), &none};
    const PredictedStrain strain{e, solve_, elastic.medium()};
    const PredictedForce force{e, solve_, elastic.medium()};
    for (std::uint32_t k = 0; k < e.count; ++k) begin(k);
    for (std::uint32_t k = 0; k < e.count; ++k) strain(k, SerialTeam{});
    for (std::uint32_t k = 0; k < e.count; ++k) force(k, SerialTeam{});
    return values(residual_);
  }

  // (dt C + dt^2 K) z at the places and rotations of the last impulse().
  std::vector<Vector3d> product(const std::vector<Vector3d>& z) {
    const ElasticViews e = elastic.views();
    for (std::uint32_t k = 0; k < e.count; ++k) scaled_[k] = pack(z[k].cast<real>(), 0);
    const StrainChange strain{e, solve_, elastic.medium(), 0};
    const ForceChange force{e, solve_, elastic.medium(), 0};
    for (std::uint32_t k = 0; k < e.count; ++k) strain(k, SerialTeam{});
    for (std::uint32_t k = 0; k < e.count; ++k) force(k, SerialTeam{});
    std::vector<Vector3d> out = values(image_);
    for (std::uint32_t k = 0; k < e.count; ++k) out[k] -= z[k] / double(residual_[k].w);
    return out;
  }

  // Returns what a particle's velocity gains in one round, and whether the solve ended, where r = z of the first
  // particle is r_0 and of all others 1, with A = I.
  std::pair<double, bool> first_round(real r_0) {
    const Packed one{1, 1, 1, 1};
    for (auto* field : {&residual_, &scaled_, &image_}) field->assign(count(), one);
    for (auto* field : {&direction_, &advance_, &change_}) field->assign(count(), Packed{0, 0, 0, 0});
    residual_[0] = scaled_[0] = image_[0] = Packed{r_0, r_0, r_0, 1};
    std::vector<Packed> sums(1);
    SolveRound round{};
    real unsolved = 0;
    solve_.rounds = solve_.parts = 1;
    solve_.sums = sums.data();
    solve_.round = &round;
    solve_.unsolved = &unsolved;
    SumRound{elastic.views(), solve_, 0, nullptr}(0, SerialTeam{});
    AdvanceRound{elastic.views(), solve_, 0, nullptr}(0, SerialTeam{});
    return {change_.back().x, round.ended};
  }

  void place(const std::function<Vector3d(const Vector3d&)>& x) { places_ = x; }
  std::size_t count() const { return predicted_.size(); }

  Elastic elastic;

 private:
  static std::vector<Vector3d> values(const std::vector<Packed>& from) {
    std::vector<Vector3d> out;
    for (const Packed& p : from) out.push_back(p.xyz().cast<double>());
    return out;
  }

  ImplicitViews solve_;
  BodyViews bodies_;
  std::vector<Packed> predicted_, residual_, scaled_, outer_, image_, direction_, advance_, change_, force_, pair_;
  std::vector<Quat> rotation_;
  std::function<Vector3d(const Vector3d&)> places_ = [](const Vector3d& X) { return X; };
};

class ImplicitElasticTest : public RandomCase, public ::testing::WithParamInterface<std::array<int, 3>> {
 protected:
  std::vector<Vector3d> field(std::size_t count) {
    std::vector<Vector3d> out(count);
    for (Vector3d& v : out) v = vector(1);
    return out;
  }
};

double dot(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

// Without stress, where K is the whole slope.
TEST_P(ImplicitElasticTest, ProductsAreTheForcesSlope) {
  Solve solve(GetParam());
  const Matrix3d Q = rotation();
  solve.place([&](const Vector3d& X) { return Vector3d(Q * X); });
  const std::vector<Vector3d> z = field(solve.count());
  // a step ahead strains by 1e-3 or, in double, 1e-6
  const double h = (sizeof(real) == 4 ? 1e-3 : 1e-6) * kSpacing / kStep;
  const auto impulse = [&](double size) {
    std::vector<Vector3d> v = z;
    for (Vector3d& one : v) one *= size;
    return solve.impulse(v);
  };
  const std::vector<Vector3d> more = impulse(h), less = impulse(-h), product = solve.product(z);
  double largest = 0;
  for (const Vector3d& p : product) largest = std::max(largest, p.norm());
  EXPECT_GT(largest, 0);
  for (std::size_t i = 0; i < z.size(); ++i)
    EXPECT_TRUE(within(((more[i] - less[i]) / (2 * h) + product[i]).norm() / largest, tol::kImplicitSlope));
}

// However strained.
TEST_P(ImplicitElasticTest, ProductsAreSymmetricNeverNegativeAndPushNobody) {
  Solve solve(GetParam());
  for (int round = 0; round < 5; ++round) {
    const Matrix3d F = rotation() * Vector3d(between(0.6, 1.5), between(0.6, 1.5), between(0.6, 1.5)).asDiagonal();
    solve.place([&](const Vector3d& X) { return Vector3d(F * X + vector(0.1 * kSpacing)); });
    solve.impulse(std::vector<Vector3d>(solve.count(), Vector3d::Zero()));
    const std::vector<Vector3d> a = field(solve.count()), b = field(solve.count());
    const std::vector<Vector3d> Aa = solve.product(a), Ab = solve.product(b);
    const double size = std::sqrt(dot(a, Aa) * dot(b, Ab));
    EXPECT_GT(size, 0);
    EXPECT_TRUE(within((dot(a, Ab) - dot(b, Aa)) / size, tol::kElasticMomentum));
    Vector3d sum = Vector3d::Zero();
    double sizes = 0;
    for (const Vector3d& p : Aa) {
      sum += p;
      sizes += p.norm();
    }
    EXPECT_TRUE(within(sum.norm() / sizes, tol::kElasticMomentum));
  }
}

TEST(ConjugateGradients, WhatIsNotFiniteReachesTheParticles) {
  Solve solve({3, 2, 1});
  EXPECT_EQ(solve.first_round(1), std::pair(1.0, false));
  EXPECT_EQ(solve.first_round(0).first, 1);
  const real huge = std::numeric_limits<real>::max();
  for (const real bad : {std::numeric_limits<real>::quiet_NaN(), std::numeric_limits<real>::infinity(), huge}) {
    const auto [gained, ended] = solve.first_round(bad);
    EXPECT_FALSE(std::isfinite(gained)) << bad;
    EXPECT_TRUE(ended);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, ImplicitElasticTest,
                         ::testing::Values(std::array{5, 4, 3}, std::array{5, 5, 1}, std::array{6, 1, 1}));

}  // namespace
}  // namespace palp::test::implicit_elastic_test
