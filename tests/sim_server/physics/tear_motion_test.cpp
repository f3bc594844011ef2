// Bodies that tear, in motion.
#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/contents.h"
#include "tests/support/scenes.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::tear_motion_test {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing = 0.01, kYoung = 1e5, kTear = 0.2;

Scene with_jelly(double damping) {
  Scene scene = empty_scene(kSpacing, {-3, -3, -3}, {3, 3, 3});
  scene.config.gravity.setZero();
  add_material(scene, 1000, 0);
  MaterialConfig& m = scene.config.materials[0];
  m.young_modulus = kYoung;
  m.poisson_ratio = 0.3;
  m.damping = damping;
  m.tear_strain = kTear;
  return scene;
}

Vector3d vector_of(const std::vector<float>& field, std::size_t i) {
  return {field[3 * i], field[3 * i + 1], field[3 * i + 2]};
}

struct Sums {
  Vector3d p = Vector3d::Zero(), L = Vector3d::Zero();
  double p_size = 0, L_size = 0, kinetic = 0, stored = 0;
};

Sums sums_of(const Scene& scene, const Snapshot& s) {
  Sums out;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const double m = 1000 * scene.volume[i];
    const Vector3d v = vector_of(s.velocity, i), x = vector_of(s.position, i);
    out.p += m * v;
    out.L += m * x.cross(v);
    out.p_size += m * v.norm();
    out.L_size += m * x.cross(v).norm();
    out.kinetic += 0.5 * m * v.squaredNorm();
    out.stored += s.stored[i];
  }
  return out;
}

// A strip with a waist, held by a clamp and a grip.
struct Strip {
  static constexpr double kLength = 0.2, kWide = 6 * kSpacing, kThick = 3 * kSpacing;
  Scene scene = with_jelly(25);
  std::uint32_t clamp, grip, strip;
  Vector3d start;

  Strip() {
    clamp = add_body(scene, "clamp", BodyKind::fixed, 0, {-2 * kSpacing, 0, 0}, {0, kWide, kThick});
    grip = add_body(scene, "grip", BodyKind::rigid, 0, {kLength, 0, 0}, {kLength + 2 * kSpacing, kWide, kThick});
    strip = add_body(scene, "strip", BodyKind::elastic, 0, {0, 0, 0}, {kLength, kWide, kThick}, [](const Vector3d& X) {
      return std::abs(X.x() - kLength / 2) > 2 * kSpacing || std::abs(X.y() - kWide / 2) < 2 * kSpacing;
    });
    scene.bodies[strip].bonded_to = {clamp, grip};
    scene.proxies.push_back({0, grip, Vector3d::Zero(), {1e6, 1e4, 1e4, 1e2}});
    start = scene.bodies[grip].position;
  }
  // Moves the grip; returns the largest force on it.
  double pull(Simulation& simulation, double from, double to, double time) const {
    StepInput input;
    input[0].engaged = true;
    input[0].gains = {2e4, 50, 50, 0.5};
    const int steps = static_cast<int>(1000 * time);
    double most = 0;
    for (int k = 1; k <= steps; ++k) {
      input[0].state.position = start + Vector3d(from + (to - from) * k / steps, 0, 0);
      const StepOutput& out = simulation.step(input);
      EXPECT_TRUE(out.health.ok) << out.health.cause;
      most = std::max(most, std::abs(out.proxies[0].contact_force.x()));
    }
    return most;
  }
};

TEST(Tearing, StripRipsAtItsWaistAndPullsNoMore) {
  const Strip s;
  const auto simulation = simulate(s.scene);
  // the waist, 4 of 6 wide, is stretched by half as much again as the rest
  const double section = 4 * kSpacing * Strip::kThick, strength = kYoung * kTear * section;
  const double peak = s.pull(*simulation, 0, 0.05, 1);
  RecordProperty("peak_over_strength", std::to_string(peak / strength));
  EXPECT_GT(peak, 0.6 * strength);
  EXPECT_LT(peak, 1.3 * strength);
  s.pull(*simulation, 0.05, 0.05, 0.6);
  EXPECT_LT(s.pull(*simulation, 0.05, 0.05, 0.05), 0.01 * peak) << "it still pulls";
  Snapshot snapshot;
  simulation->snapshot(snapshot);
  // the halves have their lengths back, and the gap between them is all that the grip has moved
  double left = -1e9, right = 1e9;
  for (std::size_t i = 0; i < s.scene.position.size(); ++i) {
    const double X = s.scene.position[i].x(), x = snapshot.position[3 * i];
    if (X < Strip::kLength / 2 - 2 * kSpacing) left = std::max(left, x);
    if (X > Strip::kLength / 2 + 2 * kSpacing) right = std::min(right, x);
    if (X < Strip::kLength / 2 - 2 * kSpacing) {
      EXPECT_NEAR(x, X, 0.2 * kSpacing);
    }
    if (X > Strip::kLength / 2 + 2 * kSpacing) {
      EXPECT_NEAR(x, X + 0.05, 0.2 * kSpacing);
    }
  }
  EXPECT_GT(right - left, 0.05 + 4 * kSpacing);
}

TEST(Tearing, BelowItsStrengthItNeverRips) {
  const Strip s;
  const auto simulation = simulate(s.scene);
  const double first = s.pull(*simulation, 0, 0.018, 0.5);
  for (int k = 0; k < 2; ++k) {
    s.pull(*simulation, 0.018, -0.01, 0.3);
    s.pull(*simulation, -0.01, 0.018, 0.3);
  }
  s.pull(*simulation, 0.018, 0.018, 0.2);
  const double last = s.pull(*simulation, 0.018, 0.018, 0.05);
  EXPECT_NEAR(last / first, 1, 0.1);
}

// Two ends that fly apart while the whole turns: it rips in the middle. Momenta are kept, energy never grows, and the
// halves go on freely.
TEST(Tearing, ThroughTheBreakMomentaAreKeptAndEnergyIsNotMade) {
  Scene scene = with_jelly(0);
  scene.config.numerics.safety = 0.05;  // symplectic Euler's energy ripples in proportion
  add_body(scene, "bar", BodyKind::elastic, 0, {-8 * kSpacing, -2 * kSpacing, -2 * kSpacing},
           {8 * kSpacing, 2 * kSpacing, 2 * kSpacing});
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const Vector3d& x = scene.position[i];
    scene.velocity[i] = Vector3d(x.x() > 0 ? 3 : -3, 0, 0) + Vector3d(4, 0, 8).cross(x) + Vector3d(0.1, 0.2, 0.3);
  }
  const auto simulation = simulate(scene);
  Snapshot s;
  simulation->snapshot(s);
  const Sums start = sums_of(scene, s);
  double before = start.kinetic + start.stored;
  for (int k = 0; k < 300; ++k) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    simulation->snapshot(s);
    const Sums now = sums_of(scene, s);
    ASSERT_LE(now.kinetic + now.stored, before + value_of(tol::kEnergyGain) * start.kinetic) << "step " << k;
    before = std::min(before, now.kinetic + now.stored);
    ASSERT_LT((now.p - start.p).norm(), 1e-4 * start.p_size) << "step " << k;
    ASSERT_LT((now.L - start.L).norm(), 1e-4 * start.L_size) << "step " << k;
  }
  // apart, each with the other end's velocity gone
  Vector3d v[2] = {Vector3d::Zero(), Vector3d::Zero()}, x[2] = {v[0], v[0]};
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const int side = scene.position[i].x() > 0;
    v[side] += vector_of(s.velocity, i) / (scene.position.size() / 2.0);
    x[side] += vector_of(s.position, i) / (scene.position.size() / 2.0);
  }
  EXPECT_GT((x[1] - x[0]).norm(), 0.5);
  const Vector3d parting = v[1] - v[0];
  for (int k = 0; k < 100; ++k) simulation->step({});
  simulation->snapshot(s);
  Vector3d later[2] = {Vector3d::Zero(), Vector3d::Zero()};
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    later[scene.position[i].x() > 0] += vector_of(s.velocity, i) / (scene.position.size() / 2.0);
  EXPECT_LT((later[1] - later[0] - parting).norm(), 1e-3 * parting.norm());
}

// Blows a block of n particles to bits; returns what energy it gains, as a share of what it begins with.
double gain_of_burst(const Vector3d& n, double speed, double poisson_ratio, std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  Scene scene = with_jelly(0);
  scene.config.materials[0].poisson_ratio = poisson_ratio;
  scene.config.numerics.safety = 0.05;
  add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, kSpacing * n);
  for (Vector3d& v : scene.velocity) v = speed * Vector3d(normal(random), normal(random), normal(random));
  const auto simulation = simulate(scene);
  Snapshot s;
  simulation->snapshot(s);
  const Sums start = sums_of(scene, s);
  Sums now;
  for (int k = 0; k < 60; ++k) {
    const StepOutput& out = simulation->step({});
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) break;
    simulation->snapshot(s);
    now = sums_of(scene, s);
    EXPECT_LT((now.p - start.p).norm(), 1e-4 * start.p_size);
  }
  return (now.kinetic + now.stored) / start.kinetic - 1;
}

// Blown to bits of one to three particles: everything stays finite, momenta are kept, no energy comes out of it, and
// the bits end up flying straight.
TEST(Tearing, CrumbsFlyOn) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (const Vector3d& n : {Vector3d(6, 6, 6), Vector3d(4, 1, 1), Vector3d(5, 5, 1)})
    for (const double speed : {1.0, 4.0, 20.0})
      EXPECT_LE(gain_of_burst(n, speed, 0.3, random), value_of(tol::kBurstGain))
          << "speed " << speed << ", " << n.transpose();
}

// A block that hardly compresses is stiff against the change of volume that the bonds left fit: it gained fourteen
// times its energy.
TEST(Tearing, CrumbsThatHardlyCompressGainNothing) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (const Vector3d& n : {Vector3d(4, 4, 4), Vector3d(5, 5, 1)})
    for (const double speed : {1.0, 4.0})
      EXPECT_LE(gain_of_burst(n, speed, 0.49, random), value_of(tol::kBurstGain))
          << "speed " << speed << ", " << n.transpose();
}

// One particle, two, three in a row, of whatever material and however thrown.
TEST(Tearing, BitsOfAFewParticlesStayFinite) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  for (const int count : {1, 2, 3})
    for (const bool yields : {false, true})
      for (const bool tears : {false, true})
        for (const double speed : {0.5, 5.0, 50.0}) {
          Scene scene = with_jelly(0);
          if (yields) scene.config.materials[0].yield_stress = 2e3;
          if (!tears) scene.config.materials[0].tear_strain.reset();
          add_body(scene, "bit", BodyKind::elastic, 0, {0, 0, 0}, {count * kSpacing, kSpacing, kSpacing});
          for (Vector3d& v : scene.velocity) v = speed * Vector3d(normal(random), normal(random), normal(random));
          const auto simulation = simulate(scene);
          Snapshot s;
          simulation->snapshot(s);
          const Sums start = sums_of(scene, s);
          for (int k = 0; k < 50; ++k) EXPECT_EQ(simulation->step({}).health.non_finite, 0u);
          simulation->snapshot(s);
          const Sums end = sums_of(scene, s);
          EXPECT_LT((end.p - start.p).norm(), 1e-4 * start.p_size);
        }
}

TEST(Lightness, TearsArePaidForWhereSomethingTears) {
  const auto names = [](bool tears) {
    Scene scene = with_jelly(0);
    if (!tears) scene.config.materials[0].tear_strain.reset();
    add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, Vector3d::Constant(4 * kSpacing));
    Contents all = contents_of(scene);
    all.arrays.merge(all.launches);
    return all.arrays;
  };
  EXPECT_EQ(added(names(false), names(true)), (Names{"elastic integrity", "elastic projection", "elastic stretch",
                                                     "elastic tears", "elastic torn bonds"}));
}

}  // namespace
}  // namespace palp::test::tear_motion_test
