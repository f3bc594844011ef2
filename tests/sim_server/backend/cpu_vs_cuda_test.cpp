// The two back ends run the same functors, so they may differ by round-off only: one sub-step closely, a longer run in
// what it amounts to.
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/change_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/tolerance.h"

namespace palp::test::cpu_vs_cuda_test {
namespace {

// Largest difference relative to the largest value.
double difference(const std::vector<float>& a, const std::vector<float>& b) {
  double worst = 0, scale = 1e-30;
  for (std::size_t i = 0; i < a.size(); ++i) {
    worst = std::max(worst, std::abs(double(a[i]) - b[i]));
    scale = std::max(scale, std::abs(double(a[i])));
  }
  return a.size() == b.size() ? worst / scale : 1e30;
}

class CpuVsCuda : public ::testing::TestWithParam<Method> {};

TEST_P(CpuVsCuda, AgreeAfterAFewSubSteps) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    RandomSceneOptions options;
    options.method = GetParam();
    options.periodic = {seed % 2 == 0, seed > 2, false};
    const Scene scene = random_scene(random, options);
    const StepInput input = random_input(random, scene);
    const auto cpu = simulate(scene, Backend::cpu), gpu = simulate(scene, Backend::cuda);
    Snapshot a, b;
    for (int k = 0; k < 3; ++k) {
      const StepOutput &on_cpu = cpu->step(input), &on_gpu = gpu->step(input);
      cpu->snapshot(a);
      gpu->snapshot(b);
      const Tolerance& tolerance = k == 0 ? tol::kOneStep : tol::kFewSteps;
      EXPECT_TRUE(within(difference(a.position, b.position), tolerance));
      EXPECT_TRUE(within(difference(a.velocity, b.velocity), tolerance));
      EXPECT_TRUE(within(difference(a.pressure, b.pressure), tolerance));
      EXPECT_TRUE(within((on_cpu.proxies[0].force - on_gpu.proxies[0].force).norm() / on_cpu.proxies[0].force.norm(),
                         tol::kBodyWrench));
      for (std::size_t body = 2; body < scene.bodies.size(); ++body)
        EXPECT_TRUE(
            within((on_cpu.bodies[body].force - on_gpu.bodies[body].force).norm() / on_cpu.bodies[body].force.norm(),
                   tol::kFewSteps));
      EXPECT_NEAR(on_gpu.health.kinetic_energy / on_cpu.health.kinetic_energy, 1, 1e-4);
      EXPECT_NEAR(on_gpu.health.max_speed / on_cpu.health.max_speed, 1, 1e-4);
      EXPECT_EQ(on_gpu.health.outside, on_cpu.health.outside);
    }
  }
}

// How many lanes of the GPU share a particle, and who lists its neighbours, depends on the number of particles.
TEST(CpuVsCudaSizes, AgreeWhateverSharesAParticle) {
  for (const int edge : {10, 20, 30, 40}) {
    SCOPED_TRACE(std::to_string(edge) + " particles along an edge");
    Random random(static_cast<unsigned>(edge));
    constexpr double dx = 0.01;
    Scene scene = empty_scene(dx, Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(edge * dx));
    scene.config.gravity.setZero();
    scene.config.periodic = {true, false, true};
    scene.config.numerics.sound_speed = 10;
    scene.config.numerics.max_speed = 1;
    scene.config.numerics.sub_steps = 4;
    scene.config.numerics.support_over_spacing = 2.3;
    scene.config.rate_hz = 1 / (4 * 0.4 * dx / 10);
    add_body(scene, "water", BodyKind::fluid, add_material(scene, 1000, 1e-3), scene.bounds_min, scene.bounds_max);
    for (Eigen::Vector3d& x : scene.position) x += random_vector(random, 0.1 * dx);
    for (Eigen::Vector3d& v : scene.velocity) v = random_vector(random, 0.5);
    const auto cpu = simulate(scene, Backend::cpu), gpu = simulate(scene, Backend::cuda);
    Snapshot a, b;
    for (int k = 0; k < 3; ++k) {
      ASSERT_TRUE(cpu->step({}).health.ok);
      ASSERT_TRUE(gpu->step({}).health.ok) << gpu->output().health.cause;
    }
    cpu->snapshot(a);
    gpu->snapshot(b);
    for (std::size_t i = 0; i < a.position.size(); ++i)
      if (std::abs(a.position[i] - b.position[i]) > 0.5 * edge * dx) b.position[i] = a.position[i];  // wrapped
    EXPECT_TRUE(within(difference(a.position, b.position), tol::kFewSteps));
    EXPECT_TRUE(within(difference(a.velocity, b.velocity), tol::kFewSteps));
    EXPECT_TRUE(within(difference(a.pressure, b.pressure), tol::kFewSteps));
  }
}

// Many particles are sorted by tiles of cells, and those beside a solid are found in large parts of them.
TEST(CpuVsCudaSizes, AgreeInALargeTank) {
  const ByGeometry by_geometry;
  Random random(11);
  constexpr double dx = 0.01;
  const Eigen::Vector3d size(0.6, 0.45, 0.41);
  Scene scene = empty_scene(dx, {-0.1, -0.1, -0.1}, {0.7, 0.55, 0.6});
  scene.config.numerics.max_speed = 1;
  const auto water = add_material(scene, 1000, 1e-3);
  add_body(scene, "water", BodyKind::fluid, water, {0, 0, 0}, size);
  add_tray(scene, water, {0, 0, 0}, {size.x(), size.y(), 0.5}, 3 * dx);
  scene.config.probes.push_back(probe_of("tray"));
  for (std::uint32_t i = 0; i < scene.bodies[0].count; ++i) {
    scene.position[i] += random_vector(random, 0.1 * dx);
    scene.velocity[i] = random_vector(random, 0.3);
  }
  ASSERT_GT(scene.bodies[0].count, 100000u);
  const auto cpu = simulate(scene, Backend::cpu), gpu = simulate(scene, Backend::cuda);
  Snapshot a, b;
  for (int k = 0; k < 3; ++k) {
    const StepOutput &on_cpu = cpu->step({}), &on_gpu = gpu->step({});
    ASSERT_TRUE(on_cpu.health.ok && on_gpu.health.ok) << on_gpu.health.cause;
    EXPECT_TRUE(within((on_cpu.bodies[1].force - on_gpu.bodies[1].force).norm() / on_cpu.bodies[1].force.norm(),
                       tol::kBodyWrench));
  }
  cpu->snapshot(a);
  gpu->snapshot(b);
  EXPECT_TRUE(within(difference(a.position, b.position), tol::kFewSteps));
  EXPECT_TRUE(within(difference(a.velocity, b.velocity), tol::kFewSteps));
  EXPECT_TRUE(within(difference(a.pressure, b.pressure), tol::kFewSteps));
}

// A column collapses in a tray: single particles part ways, the flow does not.
TEST_P(CpuVsCuda, AgreeInTheSumOfALongRun) {
  constexpr double dx = 0.025;
  Scene scene = empty_scene(dx, {-0.1, -0.1, -0.1}, {0.6, 0.4, 0.6});
  scene.config.method = GetParam();
  scene.config.numerics.max_speed = 2;
  const auto water = add_material(scene, 1000, GetParam() == Method::paper ? 5 : 0.1);
  add_body(scene, "water", BodyKind::fluid, water, {0, 0, 0}, {0.2, 0.3, 0.3});
  add_tray(scene, water, {0, 0, 0}, {0.5, 0.3, 0.4}, 3 * dx);
  scene.config.probes.push_back(probe_of("tray"));
  const auto cpu = simulate(scene, Backend::cpu), gpu = simulate(scene, Backend::cuda);
  Eigen::Vector3d force_cpu = Eigen::Vector3d::Zero(), force_gpu = Eigen::Vector3d::Zero();
  double energy_cpu = 0, energy_gpu = 0;
  for (int k = 0; k < 300; ++k) {
    const StepOutput &on_cpu = cpu->step({}), &on_gpu = gpu->step({});
    ASSERT_TRUE(on_cpu.health.ok && on_gpu.health.ok) << on_gpu.health.cause;
    force_cpu += on_cpu.bodies[1].force / 300;
    force_gpu += on_gpu.bodies[1].force / 300;
    energy_cpu += on_cpu.health.kinetic_energy;
    energy_gpu += on_gpu.health.kinetic_energy;
  }
  Snapshot a, b;
  cpu->snapshot(a);
  gpu->snapshot(b);
  Eigen::Vector3d center_cpu = Eigen::Vector3d::Zero(), center_gpu = Eigen::Vector3d::Zero();
  for (std::uint32_t i = 0; i < scene.bodies[0].count; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      center_cpu[axis] += a.position[3 * i + axis] / scene.bodies[0].count;
      center_gpu[axis] += b.position[3 * i + axis] / scene.bodies[0].count;
    }
  EXPECT_LT((center_cpu - center_gpu).norm(), 0.05 * dx);
  EXPECT_NEAR(energy_gpu / energy_cpu, 1, 0.01);
  EXPECT_LT((force_gpu - force_cpu).norm() / force_cpu.norm(), 0.01);
}

// A bar of which the middle melts and freezes again while its cold ends are rigid, over a pool that freezes.
TEST(CpuVsCudaChanges, AgreeOnPiecesAndTheirMotion) {
  for (const double support : {2.0, 3.0}) {
    SCOPED_TRACE(support);
    Random random(7);
    Scene scene = melting_scene();
    scene.config.numerics.support_over_spacing = support;
    scene.config.materials[0].rigid_below = kMelting - 5;
    add_body(scene, "bar", BodyKind::elastic, 0, {-0.06, -0.015, -0.015}, {0.06, 0.015, 0.015});
    add_body(scene, "pool", BodyKind::fluid, 0, {-0.06, -0.03, -0.06}, {0.06, 0.03, -0.02});
    for (std::size_t i = 0; i < scene.position.size(); ++i) {
      scene.velocity[i] = random_vector(random, 0.02);
      const double melt = std::abs(scene.position[i].x()) < 0.02 ? 0.1 : -6;
      scene.temperature.push_back(kMelting + (scene.body[i] == 0 ? melt : uniform(random, 0, 0.2)));
    }
    add_heat(scene, -6 * mass_of(scene), 0.02, 0.06);
    const auto cpu = simulate(scene, Backend::cpu), gpu = simulate(scene, Backend::cuda);
    std::size_t most = 0;
    for (int k = 1; k <= 8; ++k) {
      run_until(*cpu, 0.01 * k);
      run_until(*gpu, 0.01 * k);
      ASSERT_TRUE(cpu->output().health.ok && gpu->output().health.ok) << gpu->output().health.cause;
      const Snapshot a = snapshot_of(*cpu), b = snapshot_of(*gpu);
      EXPECT_EQ(a.body_id, b.body_id) << k;
      EXPECT_EQ(a.rigid, b.rigid) << k;
      most = std::max(most, static_cast<std::size_t>(std::count(a.rigid.begin(), a.rigid.end(), 1)));
      EXPECT_TRUE(within(difference(a.position, b.position), tol::kManySteps)) << k;
    }
    EXPECT_GT(most, 70u) << "both ends are rigid";
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, CpuVsCuda, ::testing::Values(Method::accurate, Method::paper),
                         [](const auto& param) { return to_string(param.param); });

}  // namespace
}  // namespace palp::test::cpu_vs_cuda_test
