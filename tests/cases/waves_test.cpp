// Waves and floating: a box that heaves in a pool, and a wave that stands in it, against linear potential flow in the
// same pool.
#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>

#include "tests/support/backend.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::waves_test {
namespace {

constexpr double kSpacing = 0.02, kGravity = 9.81;
constexpr const char* kPapersSlosh =
    "density by summation falls short at the surface: the water is as compressible as its pressure is off";

// Half of a pool, by symmetry: plane flow under a surface at z = 0, in square cells of one length. The box takes the
// cells next to x = 0 down to its draft. Lengths are in spacings.
struct Pool {
  int length, depth, wide, draft;  // wide: of the box; 0 leaves it out
};

// The longest period of what rises and falls together [s]: the box's heave, or without a box the longest symmetric
// wave. Linear potential flow (Newman 1977, chapter 6): d2phi = 0, the surface and the box's bottom rise with dphi/dz,
// and their inertia, phi and the box's mass, is driven by rho g times their height. Inverse iteration over the rise of
// each column of cells, which are 1 / refine spacings wide.
double period_of(const Pool& pool, int refine) {
  const double h = kSpacing / refine, draft = pool.draft * kSpacing;
  const int nx = pool.length * refine / 2, nz = pool.depth * refine, wide = pool.wide * refine / 2;
  const auto top = [&](int i) { return i < wide ? nz - pool.draft * refine : nz; };
  std::vector<int> first{0};
  for (int i = 0; i < nx; ++i) first.push_back(first.back() + top(i));
  const auto cell = [&](int i, int k) { return first[static_cast<std::size_t>(i)] + k; };
  std::vector<Eigen::Triplet<double>> entries{{0, 0, 1.0}};  // pins the potential, of which a constant is free
  const auto join = [&](int a, int b) {
    entries.insert(entries.end(), {{a, a, 1.0}, {b, b, 1.0}, {a, b, -1.0}, {b, a, -1.0}});
  };
  for (int i = 0; i < nx; ++i)
    for (int k = 0; k < top(i); ++k) {
      if (k + 1 < top(i)) join(cell(i, k), cell(i, k + 1));
      if (i + 1 < nx && k < top(i + 1)) join(cell(i, k), cell(i + 1, k));
    }
  Eigen::SparseMatrix<double> flow(first.back(), first.back());
  flow.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(flow);
  Eigen::VectorXd rise(nx), next(nx), source(first.back());
  for (int i = 0; i < nx; ++i) rise[i] = std::cos(M_PI * (i + 0.5) / nx);
  std::fill(rise.begin(), rise.begin() + wide, 1.0);
  double inertia = 0;
  for (int round = 0; round < 40; ++round) {
    const double mean = std::accumulate(rise.begin(), rise.end(), 0.0) / nx;  // water is neither made nor lost
    for (double& r : rise) r -= mean;
    const double size = std::sqrt(std::inner_product(rise.begin(), rise.end(), rise.begin(), 0.0));
    for (double& r : rise) r /= size;
    source.setZero();
    for (int i = 0; i < nx; ++i) source[cell(i, top(i) - 1)] = h * rise[i];
    const Eigen::VectorXd potential = solver.solve(source);
    for (int i = 0; i < nx; ++i) next[i] = potential[cell(i, top(i) - 1)] + 0.5 * h * rise[i];
    const double at_box = std::accumulate(next.begin(), next.begin() + wide, 0.0) / std::max(1, wide);
    std::fill(next.begin(), next.begin() + wide, at_box + draft * rise[0]);
    inertia = std::inner_product(rise.begin(), rise.end(), next.begin(), 0.0);
    rise = next;
  }
  return 2 * M_PI * std::sqrt(inertia / kGravity);
}

// Returns the period for an infinitely fine grid, from two grids: the error at the box's edges falls with the cell's
// length.
double exact_period(const Pool& pool) { return 2 * period_of(pool, 4) - period_of(pool, 2); }

// Periodic along x and y, with the pool's middle at x = 0. With three spacings of support: with two the particles keep
// their first lattice, and its stiffness in shear makes waves about a tenth faster.
Scene pool_scene(const Pool& pool, Method method, const std::function<bool(const Eigen::Vector3d&)>& is_water) {
  const double half = 0.5 * pool.length * kSpacing, deep = 9 * kSpacing, bottom = -pool.depth * kSpacing;
  Scene scene = empty_scene(kSpacing, {-half, 0, bottom - 3 * kSpacing}, {half, deep, 10 * kSpacing});
  scene.config.periodic = {true, true, false};
  scene.config.numerics.support_over_spacing = 3;
  scene.config.method = method;
  scene.config.gravity = {0, 0, -kGravity};
  const auto water = add_material(scene, 1000, 1e-3);
  const ByGeometry walls;
  add_body(scene, "water", BodyKind::fluid, water, {-half, 0, bottom}, {half, deep, 2 * kSpacing}, is_water);
  add_body(scene, "floor", BodyKind::fixed, water, {-half, 0, bottom - 3 * kSpacing}, {half, deep, bottom});
  return scene;
}

// When a curve turns for the n-th time, between samples; 0 where it does not.
double turn(const std::vector<double>& y, double step, int n) {
  for (std::size_t k = 10; k + 10 < y.size(); ++k) {
    const bool high = *std::max_element(&y[k - 10], &y[k + 10] + 1) == y[k];
    const bool low = *std::min_element(&y[k - 10], &y[k + 10] + 1) == y[k];
    if (high == low || --n > 0) continue;
    return (static_cast<double>(k) + 0.5 * (y[k - 10] - y[k + 10]) / (y[k - 10] - 2 * y[k] + y[k + 10]) * 10) * step;
  }
  return 0;
}

class Waves : public ::testing::TestWithParam<Method> {};

// A hand holds a flat box of half the water's density one spacing above its draft until the water is at rest, and lets
// go of its height, not of its turning.
TEST_P(Waves, AFloatingBoxHeavesWithItsAddedMass) {
  constexpr Pool pool{36, 12, 12, 4};
  const double wide = pool.wide * kSpacing, raised = kSpacing, draft = pool.draft * kSpacing;
  const Eigen::Vector3d low(-wide / 2, 0, raised - draft), high(wide / 2, 9 * kSpacing, raised + draft);
  Scene scene = pool_scene(pool, GetParam(), [&](const Eigen::Vector3d& x) {
    return x.z() < 0 && (std::abs(x.x()) > wide / 2 || x.z() < low.z());
  });
  const auto wood = add_material(scene, 500, 1e-3);
  const ByGeometry solid;
  const auto box = add_body(scene, "box", BodyKind::rigid, wood, low, high);
  scene.proxies.push_back({0, box, Eigen::Vector3d::Zero(), {1e5, 1e4, 1e4, 1e2}});
  const auto simulation = simulate(scene);
  StepInput input;
  input[0].engaged = true;
  input[0].state.position = scene.bodies[box].position;
  std::vector<double> height;
  for (int k = 0; k < 1500; ++k) {
    input[0].gains = k < 500 ? CouplingGains{2e4, 400, 20, 0.4} : CouplingGains{0, 0, 20, 0.4};
    const StepOutput& out = simulation->step(input);
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    if (k >= 500) height.push_back(out.bodies[box].state.position.z());
  }
  const double exact = exact_period(pool), found = turn(height, 1e-3, 2);
  EXPECT_TRUE(within(found / exact - 1, tol::kHeave,
                     {"D7 flat box that heaves in a pool: period", quantity(exact, "s (potential flow, added mass)"),
                      quantity(found, "s"), GetParam(), kPapersSlosh}));
}

// Started level, with the velocities of a standing wave as long as the pool; watched by its share in where particles
// are.
TEST_P(Waves, AStandingWaveHasItsPeriod) {
  constexpr Pool pool{36, 12, 0, 0};
  const double k = 2 * M_PI / (pool.length * kSpacing), depth = pool.depth * kSpacing;
  const double exact = 2 * M_PI / std::sqrt(kGravity * k * std::tanh(k * depth));
  EXPECT_NEAR(exact_period(pool) / exact, 1, 0.002) << "the reference of the box that heaves";
  Scene scene = pool_scene(pool, GetParam(), [](const Eigen::Vector3d& x) { return x.z() < 0; });
  for (std::uint32_t i = 0; i < scene.bodies[0].count; ++i) {
    const Eigen::Vector3d& x = scene.position[i];
    const double speed = 0.2 / std::sinh(k * depth), up = k * (x.z() + depth);
    scene.velocity[i] =
        speed * Eigen::Vector3d(-std::cosh(up) * std::sin(k * x.x()), 0, std::sinh(up) * std::cos(k * x.x()));
  }
  const auto simulation = simulate(scene);
  Snapshot s;
  std::vector<double> share;
  while (simulation->output().time < 0.9 * exact) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    simulation->snapshot(s);
    double sum = 0;
    for (std::uint32_t i = 0; i < scene.bodies[0].count; ++i) sum += std::cos(k * s.position[3 * i]);
    share.push_back(sum);
  }
  const double found = 2 * (turn(share, 1e-3, 2) - turn(share, 1e-3, 1));
  EXPECT_TRUE(
      within(found / exact - 1, tol::kStandingWave,
             {"Standing wave in a pool, twelve spacings deep: period",
              "2 pi / sqrt(g k tanh(k h)) = " + quantity(exact, "s"), quantity(found, "s"), GetParam(), kPapersSlosh}));
}

INSTANTIATE_TEST_SUITE_P(Methods, Waves, ::testing::ValuesIn(methods()),
                         [](const auto& param) { return to_string(param.param); });

}  // namespace
}  // namespace palp::test::waves_test
