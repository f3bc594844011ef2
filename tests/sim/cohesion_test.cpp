// Surface tension and adhesion: the pressure in a drop, its oscillation, how it lies on a solid, and what is kept.
#include <cmath>

#include <gtest/gtest.h>

#include "config/error.h"
#include "sim_server/physics/cohesion.h"
#include "sim_server/plan.h"
#include "tests/support/backend.h"
#include "tests/support/random_scene.h"
#include "tests/support/tolerance.h"

namespace palp::testing {
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
  add_body(scene, "drop", BodyType::fluid, water, Eigen::Vector3d::Constant(-half), Eigen::Vector3d::Constant(half),
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

TEST(Cohesion, IsRefusedWhereTheMethodHasNone) {
  Scene scene = drop(3, 0.1, 3e-3, nullptr);
  EXPECT_TRUE(make_plan(scene).cohesion);
  scene.config.method = Method::paper;
  EXPECT_THROW(make_plan(scene), ConfigError);
}

// A cube becomes a ball. What remains inside is the pressure of the ball's surface and that which balances attraction,
// which is the same in balls of all sizes.
double pressure_within(double support, double edge, double& radius, double& speed) {
  const Scene scene = drop(support, 0.1, edge / 2, nullptr);
  const auto simulation = simulate(scene);
  while (simulation->output().time < 0.25) {
    const StepOutput& out = simulation->step({});
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) break;
    speed = out.health.max_speed;
  }
  Snapshot s;
  simulation->snapshot(s);
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  const std::size_t n = scene.position.size();
  for (std::size_t i = 0; i < n; ++i) center += vector_at(s.position, i) / static_cast<double>(n);
  double volume = 0, farthest = 0, nearest = 1, p = 0, weight = 0;
  for (std::size_t i = 0; i < n; ++i) volume += scene.volume[i] * 1000 / s.density[i];
  radius = std::cbrt(volume * 3 / (4 * M_PI));
  Eigen::Vector3d square = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d d = vector_at(s.position, i) - center;
    square += d.cwiseAbs2() / static_cast<double>(n);
    farthest = std::max(farthest, d.norm());
    if (d.norm() > radius - (support + 1) * kSpacing) continue;
    p += s.pressure[i];
    weight += 1;
  }
  const double mean = 1e3 * std::sqrt(5 * square.sum() / 3);
  printf("support %g edge %g: R %.3f mm (gyration %.3f, %.3f %.3f %.3f) farthest %.3f p %.2f Pa of %g, speed %.2g\n", support, edge,
         1e3 * radius, mean, 1e3 * std::sqrt(5 * square.x()), 1e3 * std::sqrt(5 * square.y()), 1e3 * std::sqrt(5 * square.z()), 1e3 * farthest, p / weight, weight, speed);
  (void)nearest;
  return p / weight;
}

TEST(Drop, HasThePressureOfLaplace) {
  for (const double support : {2.0, 3.0}) {
    double R[3], speed = 0, p[3];
    const double edge[3] = {8e-3, 11e-3, 15e-3};
    for (int k = 0; k < 3; ++k) p[k] = pressure_within(support, edge[k], R[k], speed);
    for (int k = 0; k < 2; ++k)
      printf("sigma from %d,%d: %.4f\n", k, k + 1, (p[k] - p[k + 1]) / 2 / (1 / R[k] - 1 / R[k + 1]));
    printf("from 0,2: %.4f\n", (p[0] - p[2]) / 2 / (1 / R[0] - 1 / R[2]));
  }
}

}  // namespace
}  // namespace palp::testing
