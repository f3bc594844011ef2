// Bodies that yield, in motion.

#include <gtest/gtest.h>

#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/backend.h"
#include "tests/support/contents.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::plastic_motion_test {
namespace {

constexpr double kSpacing = 0.01, kYoung = 1e5, kYield = 3e3;

Scene with_dough(double hardening) {
  Scene scene = empty_scene(kSpacing, {-1, -1, -1}, {1, 1, 1});
  scene.config.gravity.setZero();
  add_material(scene, 1000, 0);
  MaterialConfig& m = scene.config.materials[0];
  m.young_modulus = kYoung;
  m.poisson_ratio = 0.3;
  m.yield_stress = kYield;
  m.hardening = hardening;
  m.damping = 10;
  return scene;
}

// Energy that is stored or moves.
double energy_of(const Scene& scene, const Snapshot& s) {
  double sum = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const Eigen::Vector3d v(s.velocity[3 * i], s.velocity[3 * i + 1], s.velocity[3 * i + 2]);
    sum += s.stored[i] + 0.5 * scene.config.materials[0].density * scene.volume[i] * v.squaredNorm();
  }
  return sum;
}

// A bar between a clamp and a grip that a device pulls and brings back: the force has its plateau, and what stays is
// the strain less the elastic part.
TEST(PlasticBody, PulledBarStaysLonger) {
  Scene scene = with_dough(0);
  const double length = 0.16, side = 4 * kSpacing, area = side * side;
  const auto clamp = add_body(scene, "clamp", BodyKind::fixed, 0, {-2 * kSpacing, 0, 0}, {0, side, side});
  const auto grip = add_body(scene, "grip", BodyKind::rigid, 0, {length, 0, 0}, {length + 2 * kSpacing, side, side});
  const auto bar = add_body(scene, "bar", BodyKind::elastic, 0, {0, 0, 0}, {length, side, side});
  scene.bodies[bar].bonded_to = {clamp, grip};
  scene.proxies.push_back({0, grip, Eigen::Vector3d::Zero(), {1e6, 1e4, 1e4, 1e2}});
  const auto simulation = simulate(scene);
  StepInput input;
  input[0].engaged = true;
  input[0].gains = {2e4, 50, 50, 0.5};
  const Eigen::Vector3d start = scene.bodies[grip].position;
  const auto force_at = [&](double from, double to, double time) {
    const int steps = static_cast<int>(1000 * time);
    double force = 0;
    for (int k = 1; k <= steps; ++k) {
      input[0].state.position = start + Eigen::Vector3d(from + (to - from) * k / steps, 0, 0);
      const StepOutput& out = simulation->step(input);
      EXPECT_TRUE(out.health.ok) << out.health.cause;
      force = -out.proxies[0].contact_force.x();
    }
    return force;
  };
  const auto settled = [&](double at) {
    force_at(at, at, 0.3);
    return force_at(at, at, 0.02);
  };
  const auto grip_moved = [&] { return simulation->output().bodies[grip].state.position.x() - start.x(); };
  // elastic: as far as its Young's modulus says, over the length between the bonds
  force_at(0, 0.002, 0.2);
  const double elastic = settled(0.002);
  EXPECT_NEAR(elastic / (kYoung * area * grip_moved() / (length + kSpacing)), 1, 0.08);
  // far beyond: what the yield stress lets through
  force_at(0.002, 0.02, 0.8);
  const double plateau = settled(0.02);
  const double strain = std::log(1 + grip_moved() / length);
  EXPECT_NEAR(plateau / (kYield * area / std::exp(strain)), 1, 0.08);
  // let go: find where it pulls no more
  force_at(0.02, 0.012, 0.6);
  input[0].gains = {1, 2, 50, 0.5};
  settled(0.012);
  const double stays = grip_moved(), expected = length * (std::exp(strain - kYield / kYoung) - 1);
  RecordProperty("stays_over_expected", std::to_string(stays / expected));
  EXPECT_NEAR(stays / expected, 1, 0.08);
}

// Thrown out of shape and left alone, a body loses energy and never gains any, and keeps its momenta.
TEST(PlasticBody, EnergyNeverGrows) {
  for (const double hardening : {0.0, 2e4}) {
    Scene scene = with_dough(hardening);
    scene.config.materials[0].damping = 0;
    scene.config.numerics.safety = 0.25;  // symplectic Euler's energy ripples in proportion
    add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, {8 * kSpacing, 6 * kSpacing, 6 * kSpacing});
    const Eigen::Vector3d middle = scene.bodies[0].position;
    for (std::size_t i = 0; i < scene.position.size(); ++i) {
      const Eigen::Vector3d r = scene.position[i] - middle;
      scene.velocity[i] = Eigen::Vector3d(25 * r.x(), -12 * r.y() + 20 * r.x(), -12 * r.z()) +
                          Eigen::Vector3d(0, 0, 10).cross(r) + Eigen::Vector3d(0.2, 0, 0);
    }
    const auto simulation = simulate(scene);
    Snapshot s;
    simulation->snapshot(s);
    const double start = energy_of(scene, s);
    double before = start;
    for (int k = 0; k < 200; ++k) {
      const StepOutput& out = simulation->step({});
      ASSERT_TRUE(out.health.ok) << out.health.cause;
      simulation->snapshot(s);
      const double now = energy_of(scene, s);
      ASSERT_LE(now, before + value_of(tol::kEnergyGain) * start) << "step " << k;
      before = std::min(before, now);
    }
    EXPECT_LT(before, 0.8 * start) << "nothing has flowed";
    Eigen::Vector3d p = Eigen::Vector3d::Zero(), p0 = p, L = p, L0 = p;
    for (std::size_t i = 0; i < scene.position.size(); ++i) {
      const double m = 1000 * scene.volume[i];
      const Eigen::Vector3d v(s.velocity[3 * i], s.velocity[3 * i + 1], s.velocity[3 * i + 2]);
      const Eigen::Vector3d x(s.position[3 * i], s.position[3 * i + 1], s.position[3 * i + 2]);
      p += m * v;
      p0 += m * scene.velocity[i];
      L += m * x.cross(v);
      L0 += m * scene.position[i].cross(scene.velocity[i]);
    }
    EXPECT_LT((p - p0).norm(), 1e-4 * p0.norm());
    EXPECT_LT((L - L0).norm(), 1e-3 * L0.norm());
  }
}

// A block so soft that its own weight makes it flow as far as matter flows comes to rest on a plate, at all that the
// limit of the sub-step allows, and gives up no more energy than it falls for.
TEST(PlasticBody, FlowsUnderItsOwnWeightWithoutGain) {
  SceneConfig config = contact_scene(0.02, 0.3, 0);
  config.rate_hz = 100;
  config.numerics.safety = 1;
  MaterialConfig& m = config.materials[0];
  m.density = 448;
  m.young_modulus = 1210;
  m.poisson_ratio = 0.49;
  m.yield_stress = 24;
  config.bodies = {at(body("plate", BodyKind::fixed, box({0.4, 0.4, 0.04})), {0, 0, -0.02}),
                   at(body("mud", BodyKind::elastic, box({0.16, 0.16, 0.16})), {0, 0, 0.08})};
  const Scene scene = sampled(config);
  const auto simulation = simulate(scene);
  Snapshot s;
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(simulation->step({}).health.ok);
  simulation->snapshot(s);
  double fallen = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    fallen += 448 * scene.volume[i] * kGravity * (scene.position[i].z() - s.position[3 * i + 2]);
  RecordProperty("energy_over_fallen", std::to_string(energy_of(scene, s) / fallen));
  EXPECT_GT(fallen, 0);
  EXPECT_LT(energy_of(scene, s), fallen);
}

TEST(Lightness, PlasticityIsPaidForWhereSomethingYields) {
  const auto arrays = [](bool yields) {
    Scene scene = with_dough(0);
    if (!yields) scene.config.materials[0].yield_stress.reset();
    add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, Eigen::Vector3d::Constant(4 * kSpacing));
    return contents_of(scene).arrays;
  };
  EXPECT_EQ(added(arrays(false), arrays(true)), (Names{"elastic plastic part", "elastic plastic strain"}));
}

}  // namespace
}  // namespace palp::test::plastic_motion_test
