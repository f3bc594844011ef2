// Heat at solids that act by their geometry, against exact solutions and what particles give. Units of the problem:
// density and heat capacity are 1, so the diffusivity is the conductivity.
#include <functional>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "sim_server/probes/probes.h"
#include "sim_server/scene/particle_reason.h"
#include "tests/support/backend.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::heat_walls_test {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing = 0.05, kDeep = 9 * kSpacing;

// A space without gravity, periodic across.
Scene space(const Vector3d& low, const Vector3d& high, double H, std::array<bool, 3> periodic) {
  Scene scene = empty_scene(kSpacing, low, high);
  scene.config.periodic = periodic;
  scene.config.gravity.setZero();
  scene.config.rate_hz = 400;
  scene.config.numerics.support_over_spacing = H;
  scene.config.numerics.max_speed = 0.1;
  const auto material = add_material(scene, 1, 0.1);
  scene.config.materials[material].conductivity = 1;
  scene.config.materials[material].heat_capacity = 1;
  add_material(scene, 1, 0.1);
  scene.config.materials[1].heat_capacity = 1;
  return scene;
}

// Adds matter at a temperature.
std::uint32_t add_matter(Scene& scene, const Vector3d& low, const Vector3d& high, double T,
                         BodyKind type = BodyKind::fixed,
                         const std::function<bool(const Vector3d&)>& inside = nullptr) {
  const std::uint32_t b = add_body(scene, "matter " + std::to_string(scene.bodies.size()), type, 0, low, high, inside);
  scene.temperature.resize(scene.position.size(), T);
  return b;
}

// Adds a solid that acts by its geometry, made of shapes in world axes, filled with particles where `inside` says so.
Body& add_solid(Scene& scene, const Vector3d& low, const Vector3d& high, double T, std::vector<ShapeConfig> shapes = {},
                const std::function<bool(const Vector3d&)>& inside = nullptr, BodyKind type = BodyKind::fixed) {
  const std::uint32_t b = add_body(scene, "solid " + std::to_string(scene.bodies.size()), type, 0, low, high, inside);
  scene.temperature.resize(scene.position.size(), T);
  if (shapes.empty()) shapes = {box_between(low, high)};
  give_shapes(scene, b, shapes);
  scene.bodies[b].temperature = T;
  scene.bodies[b].holds_temperature = true;
  return scene.bodies[b];
}

void insulate(Body& body) {
  body.holds_temperature = false;
  body.material = 1;
}

void displace(Scene& scene, double by) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-by, by);
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (!scene.bodies[scene.body[i]].holds_temperature)
      for (int a = 0; a < 3; ++a) scene.position[i][a] += shift(random);
}

Snapshot after(const Scene& scene, double time) {
  const auto simulation = simulate(scene);
  while (simulation->output().time < time - 1e-9) {
    const StepOutput& out = simulation->step({});
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) break;
  }
  Snapshot s;
  simulation->snapshot(s);
  return s;
}

Vector3d place(const Snapshot& s, std::size_t i) {
  return Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>();
}

using Exact = std::function<double(const Vector3d& x)>;

struct Off {
  double worst = 0, rms = 0, mean = 0;
};

Off off(const Scene& scene, const Snapshot& s, const Exact& exact) {
  Off out;
  double n = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    if (scene.bodies[scene.body[i]].holds_temperature) continue;
    const double error = s.temperature[i] - exact(place(s, i));
    out.worst = std::max(out.worst, std::abs(error));
    out.mean += error;
    out.rms += error * error;
    ++n;
  }
  out.rms = std::sqrt(out.rms / n);
  out.mean /= n;
  return out;
}

// Compares solids by geometry with the exact solution, and tells what their particles give.
void expect_exact(const Scene& scene, const Scene& particles, double time, const Tolerance& tolerance,
                  const std::string& title, const Exact& exact) {
  const Off found = off(scene, after(scene, time), exact), before = off(particles, after(particles, time), exact);
  EXPECT_TRUE(within(found.worst, tolerance, {title, "exact, worst place", quantity(found.worst, "K off, of 1 K")}));
  const auto record = [&](const std::string& what, double value) {
    ::testing::Test::RecordProperty(title + ": " + what, std::to_string(value));
  };
  record("worst", found.worst);
  record("rms", found.rms);
  record("mean", found.mean);
  record("worst with particles", before.worst);
  record("rms with particles", before.rms);
  record("mean with particles", before.mean);
}

void expect_profile(const Scene& all, double time, const Tolerance& tolerance, const std::string& title,
                    const Exact& exact) {
  Scene scene = all, particles = all;
  leave_out_particles(scene);
  particles.config.numerics.solid_particles = true;
  ASSERT_LT(scene.position.size(), all.position.size());
  expect_exact(scene, particles, time, tolerance, title, exact);
}

double cooled(double x, double t) { return std::erfc(x / (2 * std::sqrt(t))); }

Scene half_space(double H, double displaced = 0) {
  Scene scene = space({-3 * kSpacing, 0, 0}, {2, kDeep, kDeep}, H, {false, true, true});
  add_solid(scene, {-3 * kSpacing, 0, 0}, {0, kDeep, kDeep}, 1);
  add_matter(scene, {0, 0, 0}, {2, kDeep, kDeep}, 0);
  displace(scene, displaced);
  return scene;
}

std::string with(const std::string& what, double H) { return what + ", H = " + std::to_string(int(H)) + " dx"; }

class HeatWalls : public ::testing::TestWithParam<double> {};

TEST_P(HeatWalls, WarmAHalfSpace) {
  for (const double t : {0.05, 0.1})
    expect_profile(half_space(GetParam()), t, tol::kHeatAtPlane, with("half-space", GetParam()),
                   [t](const Vector3d& x) { return cooled(x.x(), t); });
}

TEST_P(HeatWalls, WarmAHalfSpaceOfDisorderedParticles) {
  expect_profile(half_space(GetParam(), 0.2 * kSpacing), 0.05, tol::kDisorderedHeat,
                 with("disordered half-space", GetParam()), [](const Vector3d& x) { return cooled(x.x(), 0.05); });
}

TEST_P(HeatWalls, WarmACorner) {
  const double deep = 1.25, thick = 3 * kSpacing;
  const Vector3d low(-thick, -thick, 0), high(deep, deep, kDeep);
  Scene scene = space(low, high, GetParam(), {false, false, true});
  add_solid(scene, low, high, 1, {box_between(low, high), cut(box_between({0, 0, -1}, {2, 2, 2}))},
            [](const Vector3d& x) { return x.x() < 0 || x.y() < 0; });
  add_matter(scene, {0, 0, 0}, high, 0);
  expect_profile(scene, 0.05, tol::kHeatProfile, with("corner", GetParam()),
                 [](const Vector3d& x) { return 1 - (1 - cooled(x.x(), 0.05)) * (1 - cooled(x.y(), 0.05)); });
}

// A scene as files have them: a fluid that is packed into a vessel or around a tool.
SceneConfig packed_scene(double H, const Vector3d& half) {
  SceneConfig config = scene(kSpacing);
  config.domain_min = -half;
  config.domain_max = half;
  config.periodic = {false, false, true};
  config.gravity.setZero();
  config.rate_hz = 400;
  config.numerics.support_over_spacing = H;
  config.numerics.max_speed = 0.1;
  config.materials[0].density = config.materials[0].heat_capacity = config.materials[0].conductivity = 1;
  config.materials[0].viscosity = 0.1;
  return config;
}

void add_packed(SceneConfig& config, const std::string& name, BodyKind type, double T,
                const std::vector<ShapeConfig>& shapes) {
  config.bodies.push_back(body(name, type, shapes[0]));
  config.bodies.back().shapes = shapes;
  config.bodies.back().temperature = T;
  config.bodies.back().hold_temperature = type != BodyKind::fluid;
}

void expect_packed(SceneConfig config, double time, const Tolerance& tolerance, const std::string& title,
                   const Exact& exact) {
  const Scene scene = sample_scene(config, 1000000);
  config.numerics.solid_particles = true;
  const Scene particles = sample_scene(config, 1000000);
  ASSERT_LT(scene.position.size(), particles.position.size());
  expect_exact(scene, particles, time, tolerance, title, exact);
}

TEST_P(HeatWalls, CoolARodInABore) {
  const double R = 10 * kSpacing, side = R + 3 * kSpacing, t = 0.1 * R * R;
  SceneConfig config = packed_scene(GetParam(), {side, side, kDeep / 2});
  add_packed(config, "vessel", BodyKind::fixed, 0, {box({2 * side, 2 * side, kDeep}), cut(cylinder(R, 2 * kDeep))});
  add_packed(config, "rod", BodyKind::fluid, 1, {cylinder(R, kDeep)});
  expect_packed(config, t, tol::kRoundHeat, with("rod in a bore", GetParam()), [=](const Vector3d& x) {
    static constexpr double kZeros[] = {2.404825558, 5.520078110, 8.653727913, 11.79153444, 14.93091771, 18.07106397};
    double T = 0;
    for (const double a : kZeros)
      T += 2 * std::cyl_bessel_j(0, a * x.head<2>().norm() / R) / (a * std::cyl_bessel_j(1, a)) *
           std::exp(-a * a * t / (R * R));
    return T;
  });
}

// Between a hot rod and a cold bore the temperature settles to a logarithm.
TEST_P(HeatWalls, HoldAnAnnulus) {
  const double inner = 4 * kSpacing, outer = 12 * kSpacing, side = outer + 3 * kSpacing;
  SceneConfig config = packed_scene(GetParam(), {side, side, kDeep / 2});
  add_packed(config, "vessel", BodyKind::fixed, 0, {box({2 * side, 2 * side, kDeep}), cut(cylinder(outer, 2 * kDeep))});
  add_packed(config, "rod", BodyKind::fixed, 1, {cylinder(inner, kDeep)});
  add_packed(config, "fluid", BodyKind::fluid, 0.5, {cylinder(outer, kDeep), cut(cylinder(inner, 2 * kDeep))});
  expect_packed(config, 0.15, tol::kRoundHeat, with("annulus", GetParam()),
                [=](const Vector3d& x) { return std::log(x.head<2>().norm() / outer) / std::log(inner / outer); });
}

TEST_P(HeatWalls, WarmAnElasticBody) {
  Scene scene = space({-3 * kSpacing, 0, 0}, {2, kDeep, kDeep}, GetParam(), {false, true, true});
  scene.config.materials[0].young_modulus = 1;
  scene.config.materials[0].poisson_ratio = 0.3;
  add_solid(scene, {-3 * kSpacing, 0, 0}, {0, kDeep, kDeep}, 1);
  add_matter(scene, {0, 0, 0}, {2, kDeep, kDeep}, 0, BodyKind::elastic);
  expect_profile(scene, 0.05, tol::kHeatAtPlane, with("elastic body", GetParam()),
                 [](const Vector3d& x) { return cooled(x.x(), 0.05); });
}

// A plate of 0.3 spacings between two fluids at rest: where it is held both see it, where it insulates nothing passes.
Scene parted_fluids(double H, double left, double right) {
  const double half = 0.15 * kSpacing, deep = 1.5;
  Scene scene = space({-deep, 0, 0}, {deep, kDeep, kDeep}, H, {false, true, true});
  add_solid(scene, {-half, 0, 0}, {half, kDeep, kDeep}, 1);
  add_solid(scene, {-deep, 0, 0}, {-deep + 3 * kSpacing, kDeep, kDeep}, left);
  add_solid(scene, {deep - 3 * kSpacing, 0, 0}, {deep, kDeep, kDeep}, right);
  add_matter(scene, {-deep + 3 * kSpacing, 0, 0}, {-half, kDeep, kDeep}, left, BodyKind::fluid);
  add_matter(scene, {half, 0, 0}, {deep - 3 * kSpacing, kDeep, kDeep}, right, BodyKind::fluid);
  return scene;
}

TEST_P(HeatWalls, OfAThinHotPlateWarmBothSides) {
  Scene scene = parted_fluids(GetParam(), 0, 0);
  leave_out_particles(scene);
  const Off found =
      off(scene, after(scene, 0.05), [](const Vector3d& x) { return cooled(std::abs(x.x()) - 0.15 * kSpacing, 0.05); });
  EXPECT_TRUE(
      within(found.worst, tol::kHeatAtPlane,
             {with("thin hot plate", GetParam()), "exact, worst place", quantity(found.worst, "K off, of 1 K")}));
}

TEST_P(HeatWalls, OfAThinInsulatorPartHotFromCold) {
  Scene scene = parted_fluids(GetParam(), 0, 1);
  insulate(scene.bodies[0]);
  leave_out_particles(scene);
  const Snapshot s = after(scene, 0.1);
  const Off found = off(scene, s, [](const Vector3d& x) { return x.x() < 0 ? 0 : 1; });
  EXPECT_TRUE(within(found.worst, tol::kHeatKept));
}

// A hot tool that moves through a periodic space with the fluid before it warms that as one at rest does.
TEST_P(HeatWalls, OfAMovingToolWarmWhatMovesAlong) {
  const auto warmed = [&](const Vector3d& v) {
    Scene scene = space({-1, -1, -1}, {1, 1, 1}, GetParam(), {true, true, true});
    scene.config.numerics.max_speed = 4;
    const Vector3d low(-0.2, -0.2, -0.2), high(0.2, 0.2, 0.2);
    add_solid(scene, low - Vector3d(0.2, 0, 0), high - Vector3d(0.4, 0, 0), 1, {}, nullptr, BodyKind::rigid).velocity =
        v;
    add_matter(scene, low, high, 0, BodyKind::fluid);
    for (Vector3d& of : scene.velocity) of = v;
    leave_out_particles(scene);
    return after(scene, 0.05);
  };
  const Snapshot rest = warmed({0, 0, 0}), moved = warmed({3, 0, 1.2});
  double worst = 0, warmest = 0;
  for (std::size_t i = 0; i < rest.temperature.size(); ++i) {
    worst = std::max<double>(worst, std::abs(moved.temperature[i] - rest.temperature[i]));
    warmest = std::max<double>(warmest, rest.temperature[i]);
  }
  EXPECT_GT(warmest, 0.5);
  EXPECT_TRUE(within(worst, tol::kMovedHeat));
}

INSTANTIATE_TEST_SUITE_P(Supports, HeatWalls, ::testing::Values(2.0, 3.0),
                         [](const auto& param) { return "H" + std::to_string(int(param.param)); });

// A slab that loses heat at one face alone, since on the other it lies on what does not conduct.
TEST(HeatAtAnInsulator, IsNotLostToAir) {
  Scene scene = space({-1, 0, 0}, {1, kDeep, kDeep}, 3, {false, true, true});
  insulate(add_solid(scene, {-0.5, 0, 0}, {0, kDeep, kDeep}, 400));
  add_matter(scene, {0, 0, 0}, {0.5, kDeep, kDeep}, 400);
  scene.config.heat.loss_to_air = 0.02;
  scene.config.heat.air_temperature = 300;
  leave_out_particles(scene);
  ASSERT_EQ(scene.bodies[0].count, 0u);
  const Snapshot s = after(scene, 1);
  const double mean = std::accumulate(s.temperature.begin(), s.temperature.end(), 0.0) / double(s.temperature.size());
  const double rate = -std::log((mean - 300) / 100), exact = 0.02 / 0.5;
  EXPECT_TRUE(
      within(rate / exact - 1, tol::kPlaneLoss,
             {"Slab on an insulator that loses heat to air: rate", quantity(exact, "1/s"), quantity(rate, "1/s")}));
}

}  // namespace
}  // namespace palp::test::heat_walls_test
