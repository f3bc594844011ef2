// Surface tension and adhesion: the pressure in a drop, its oscillation, how it lies on a solid, and what is kept.
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "config/error.h"
#include "sim_server/physics/cohesion.h"
#include "sim_server/probes/probes.h"
#include "sim_server/solver/plan.h"
#include "tests/support/backend.h"
#include "tests/support/random_scene.h"
#include "tests/support/tolerance.h"

namespace palp::test::cohesion_test {
namespace {

constexpr double kSpacing = 1e-3, kTension = 0.072;

Eigen::Vector3d vector_at(const std::vector<float>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

// Water of this viscosity, weightless; the particles that are inside.
Scene drop(double support, double viscosity, double half, const std::function<bool(const Eigen::Vector3d&)>& inside) {
  Scene scene = empty_scene(kSpacing, Eigen::Vector3d::Constant(-2 * half), Eigen::Vector3d::Constant(2 * half));
  scene.config.gravity.setZero();
  scene.config.numerics.support_over_spacing = support;
  const auto water = add_material(scene, 1000, viscosity);
  scene.config.materials[water].surface_tension = kTension;
  add_body(scene, "drop", BodyKind::fluid, water, Eigen::Vector3d::Constant(-half), Eigen::Vector3d::Constant(half),
           inside);
  return scene;
}

TEST(Cohesion, IntegralIsThatOfItsShape) {
  constexpr int n = 20000;
  double sum = 0;
  for (int k = 0; k < n; ++k) {
    const double q = (k + 0.5) / n;
    sum += std::pow(q, 4) * cohesion_phi(static_cast<real>(q)) / n;
  }
  EXPECT_NEAR(sum, kCohesionIntegral, 1e-6);
}

// With two spacings a drop keeps the lattice that it starts with: measured, a cube stays one.
TEST(Cohesion, ReachesThreeSpacings) {
  Scene scene = drop(3, 0.1, 3e-3, nullptr);
  scene.config.numerics.support_over_spacing.reset();
  scene.config.accuracy = Accuracy::fast;
  EXPECT_NEAR(make_plan(scene).support, 3 * kSpacing, 1e-9);
  scene.config.materials[0].surface_tension = 0;
  EXPECT_NEAR(make_plan(scene).support, 2 * kSpacing, 1e-9);
}

TEST(Cohesion, IsRefusedWhereTheMethodHasNone) {
  Scene scene = drop(3, 0.1, 3e-3, nullptr);
  EXPECT_TRUE(make_plan(scene).cohesion);
  scene.config.method = Method::paper;
  EXPECT_THROW(make_plan(scene), ConfigError);
}

// Mechanical pressure within `core` of the centre (Irving & Kirkwood): what the pair forces of pressure and of
// attraction press through it.
double pressure_within(const Scene& scene, const Snapshot& s, const Eigen::Vector3d& center, double core) {
  const Plan plan = make_plan(scene);
  const double strength = kTension / cohesion_norm(plan.support);
  double virial = 0, volume = 0;
  const auto V = [&](std::size_t i) { return scene.volume[i] * 1000 / s.density[i]; };
  const FluidKernel kernel = FluidKernel::with_support(static_cast<real>(plan.support), static_cast<real>(kSpacing));
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const Eigen::Vector3d x = vector_at(s.position, i);
    if ((x - center).norm() > core) continue;
    volume += V(i);
    for (std::size_t j = 0; j < scene.position.size(); ++j) {
      const double r = (x - vector_at(s.position, j)).norm();
      if (j == i || r >= plan.support) continue;
      const double push = (s.pressure[i] + s.pressure[j]) * kernel.F(static_cast<real>(r)) * r -
                          strength * cohesion_phi(static_cast<real>(r / plan.support));
      virial += 0.5 * V(i) * V(j) * push * r;
    }
  }
  return virial / (3 * volume);
}

class Drop : public ::testing::TestWithParam<double> {};

// A cube becomes a ball, and the pressure in it that of its surface, 2 sigma / R.
TEST_P(Drop, IsRoundAndHasThePressureOfLaplace) {
  const Scene scene = drop(GetParam(), 0.1, 5.5e-3, nullptr);
  const auto simulation = simulate(scene);
  while (simulation->output().time < 0.2) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
  }
  double p = 0, gauge = 0, longest = 0, radius = 0;
  Snapshot s;
  ProbeSampler sampler(scene);
  for (int k = 0; k < 100; ++k) {
    simulation->step({});
    if (k % 20 != 19) continue;
    simulation->snapshot(s);
    const std::size_t n = scene.position.size();
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < n; ++i) center += vector_at(s.position, i) / static_cast<double>(n);
    Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector3d d = vector_at(s.position, i) - center;
      square += d * d.transpose() / static_cast<double>(n);
    }
    const Eigen::Vector3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(square).eigenvalues().cwiseSqrt();
    longest = axes[2] / axes[0];
    radius = std::sqrt(5 * square.trace() / 3);
    p += pressure_within(scene, s, center, radius - (GetParam() + 0.5) * kSpacing) / 5;
    ProbeConfig middle;
    middle.quantity = Quantity::pressure;
    middle.points = {center};
    sampler.load(&s, simulation->output());
    gauge += sampler.evaluate(middle)[0][1].value_or(NAN) / 5;
  }
  const double whole = std::cbrt(scene.bodies[0].volume * 3 / (4 * M_PI));
  RecordProperty("laplace_over_exact", std::to_string(p / (2 * kTension / radius)));
  RecordProperty("longest_over_shortest_axis", std::to_string(longest));
  RecordProperty("radius_over_that_of_its_volume", std::to_string(radius / whole));
  RecordProperty("speed", std::to_string(simulation->output().health.max_speed));
  EXPECT_TRUE(within(p / (2 * kTension / radius) - 1, tol::kLaplace));
  EXPECT_TRUE(within(gauge / (2 * kTension / radius) - 1, tol::kGauge));
  EXPECT_TRUE(within(longest - 1, tol::kRoundness));
  EXPECT_TRUE(within(radius / whole - 1, tol::kDropRadius));
}

INSTANTIATE_TEST_SUITE_P(Supports, Drop, ::testing::Values(3.0, 4.0),
                         [](const auto& param) { return "H_" + std::to_string(static_cast<int>(10 * param.param)); });

// Momentum and angular momentum of a lump that pulls itself together.
TEST(Cohesion, KeepsMomenta) {
  Random random(3);
  Scene scene = drop(2.5, 0, 4e-3, nullptr);
  scene.config.numerics.artificial_viscosity = 0.1;
  Eigen::Vector3d moved = Eigen::Vector3d::Zero(), turned = Eigen::Vector3d::Zero();
  double size = 0, turning = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    scene.position[i] += random_vector(random, 2e-4);
    scene.velocity[i] = random_vector(random, 0.1);
    moved += scene.velocity[i];
    turned += scene.position[i].cross(scene.velocity[i]);
    size += scene.velocity[i].norm();
    turning += scene.position[i].cross(scene.velocity[i]).norm();
  }
  const auto simulation = simulate(scene);
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(simulation->step({}).health.ok) << simulation->output().health.cause;
  Snapshot s;
  simulation->snapshot(s);
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    moved -= vector_at(s.velocity, i);
    turned -= vector_at(s.position, i).cross(vector_at(s.velocity, i));
  }
  EXPECT_TRUE(within(moved.norm() / size, tol::kMomentumOfSnapshot));
  EXPECT_TRUE(within(turned.norm() / turning, tol::kAngularMomentum));
}

// Height over width of half a ball laid on a plate, after it has spread or drawn itself together.
double lying(double adhesion, double& foot) {
  constexpr double R = 6e-3;
  Scene scene = drop(3, 0.05, R, [](const Eigen::Vector3d& x) { return x.z() > 0 && x.norm() < R; });
  scene.config.gravity = {0, 0, -5};  // holds what does not wet
  scene.config.materials[0].adhesion = adhesion;
  add_body(scene, "plate", BodyKind::fixed, 0, {-11e-3, -11e-3, -3e-3}, {11e-3, 11e-3, 0});
  const auto simulation = simulate(scene);
  while (simulation->output().time < 0.2) {
    const StepOutput& out = simulation->step({});
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) return 0;
  }
  Snapshot s;
  simulation->snapshot(s);
  double high = 0;
  foot = 0;
  Eigen::Vector2d center(0, 0);
  const double n = scene.bodies[0].count;
  for (std::uint32_t i = 0; i < n; ++i) center += vector_at(s.position, i).head<2>() / n;
  for (std::uint32_t i = 0; i < n; ++i) {
    high = std::max<double>(high, s.position[3 * i + 2]);
    if (s.position[3 * i + 2] < kSpacing) foot = std::max(foot, (vector_at(s.position, i).head<2>() - center).norm());
  }
  ::testing::Test::RecordProperty("height_mm_at_" + std::to_string(adhesion), std::to_string(1e3 * high));
  ::testing::Test::RecordProperty("foot_mm_at_" + std::to_string(adhesion), std::to_string(1e3 * foot));
  return high;
}

// The more a plate attracts the water the wider it spreads and the lower it lies.
TEST(Adhesion, OrdersHowADropLies) {
  double foot[3];
  const double repelled = lying(0, foot[0]), upright = lying(kTension / 2, foot[1]), wetting = lying(kTension, foot[2]);
  EXPECT_GT(repelled, upright + 0.5 * kSpacing);
  EXPECT_GT(upright, wetting + 0.5 * kSpacing);
  EXPECT_LT(foot[0], foot[1]);
  EXPECT_LT(foot[1], foot[2]);
}

}  // namespace
}  // namespace palp::test::cohesion_test
