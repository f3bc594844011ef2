// Pieces that become rigid and deformable again, weightless: what is kept, what is lost, what it costs.
#include <gtest/gtest.h>

#include <set>

#include "sim_server/physics/rigid_pieces.h"
#include "tests/support/change_scenes.h"
#include "tests/support/random.h"
#include "tests/support/tolerance.h"

namespace palp::test::rigid_pieces_test {
namespace {

// Rigid from 5 K below melting on.
Scene freezing_scene(double young = 2e4) {
  Scene scene = melting_scene(young);
  scene.config.materials[0].viscosity = 0;  // Morris's form is not central
  scene.config.materials[0].rigid_below = kMelting - 5;
  return scene;
}

// As much as warms all by so many K.
void add_warming(Scene& scene, double kelvin, double start, double end) {
  add_heat(scene, mass_of(scene) * kelvin * kCapacity / kLatent, start, end);
}

std::size_t rigid_count(const Snapshot& s) {
  return static_cast<std::size_t>(std::count(s.rigid.begin(), s.rigid.end(), 1));
}

std::size_t rigid_pieces(const Snapshot& s) {
  std::set<std::uint32_t> ids;
  for (std::size_t i = 0; i < s.rigid.size(); ++i)
    if (s.rigid[i] != 0) ids.insert(s.body_id[i]);
  return ids.size();
}

// Returns the part of the kinetic energy of all particles that a rigid body with the same momenta would have.
double rigid_energy(const Scene& scene, const Snapshot& s) {
  const Motion all = motion_of(scene, s);
  const double mass = mass_of(scene);
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  const auto at = [&](std::size_t i) { return Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>(); };
  for (std::size_t i = 0; i < scene.position.size(); ++i) center += 1000 * scene.volume[i] / mass * at(i);
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const Eigen::Vector3d r = at(i) - center;
    inertia += 1000 * scene.volume[i] * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  const Eigen::Vector3d spin = all.spin - center.cross(all.momentum);
  return all.momentum.squaredNorm() / (2 * mass) + spin.dot(inertia.inverse() * spin) / 2;
}

class Rigidify : public RandomCase {
 protected:
  // Gives all a random motion of a rigid body and besides, each particle its own.
  void set_moving(Scene& scene, double linear, double angular, double own) {
    const Eigen::Vector3d v = vector(linear), w = vector(angular);
    for (std::size_t i = 0; i < scene.position.size(); ++i)
      scene.velocity[i] = v + w.cross(scene.position[i]) + vector(own);
  }
};

double size_of_momenta(const Scene& scene) {
  double sum = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i) sum += 1000 * scene.volume[i] * scene.velocity[i].norm();
  return sum;
}

// A lump flies, turns and wobbles, becomes rigid, and soft again.
TEST_F(Rigidify, KeepsMomentaAndAddsNoEnergy) {
  for (int round = 0; round < 3; ++round) {
    Scene scene = freezing_scene();
    const Eigen::Vector3d shape = Eigen::Vector3d(1, between(0.3, 1), between(0.5, 1));
    add_body(scene, "lump", BodyKind::elastic, 0, {-0.04, -0.04, -0.04}, {0.04, 0.04, 0.04},
             [&](const Eigen::Vector3d& x) { return x.cwiseQuotient(shape).norm() < 0.04; });
    set_moving(scene, 0.2, 5, 0.05);
    scene.temperature.assign(scene.position.size(), kMelting - 1);
    add_warming(scene, -8, 0.04, 0.08);
    add_warming(scene, 8, 0.3, 0.34);
    const double scale = size_of_momenta(scene);
    const auto simulation = simulate(scene);
    Snapshot s = snapshot_of(*simulation), rigid, before;
    const Motion start = motion_of(scene, s);
    int changes = 0;
    double stretched = 0, most_rigid = 0, strain = 0;
    EXPECT_EQ(rigid_count(s), 0u);
    for (int k = 0; k < 500; ++k) {
      ASSERT_TRUE(simulation->step({}).health.ok);
      before = s;
      s = snapshot_of(*simulation);
      const Motion now = motion_of(scene, s);
      ASSERT_TRUE(within((now.momentum - start.momentum).norm() / scale, tol::kChangeMomentum)) << k;
      ASSERT_TRUE(within((now.spin - start.spin).norm() / (scale * 0.04), tol::kChangeMomentum)) << k;
      ASSERT_LE(now.kinetic, start.kinetic * (1 + value_of(tol::kChangeEnergy))) << k;
      ASSERT_TRUE(rigid_count(s) == 0 || rigid_count(s) == scene.position.size()) << "in one step";
      if (rigid_count(s) != rigid_count(before)) {
        ++changes;
        const double kinetic_before = motion_of(scene, before).kinetic;
        RecordProperty("kept_by_change_" + std::to_string(changes), std::to_string(now.kinetic / kinetic_before));
        // A lump that becomes soft again still has the strain with which it became rigid: no more than motion had lost
        // by then.
        if (changes == 1) strain = start.kinetic - kinetic_before;
        const double most = kinetic_before + (changes == 2 ? strain : 0);
        EXPECT_LE(now.kinetic, most * (1 + value_of(tol::kChangeEnergy)));
        if (changes == 1) rigid = s;
      }
      if (changes != 1) continue;
      most_rigid = std::max(most_rigid, std::abs(now.kinetic / rigid_energy(scene, s) - 1));
      for (std::size_t pair = 0; pair < 200; ++pair) {
        const std::size_t i = random_() % scene.position.size(), j = random_() % scene.position.size();
        const auto apart = [&](const Snapshot& at) {
          return (Eigen::Map<const Eigen::Vector3f>(&at.position[3 * i]).cast<double>() -
                  Eigen::Map<const Eigen::Vector3f>(&at.position[3 * j]).cast<double>())
              .norm();
        };
        stretched = std::max(stretched, std::abs(apart(s) - apart(rigid)));
      }
    }
    EXPECT_EQ(changes, 2);
    RecordProperty("stretched_over_spacing", std::to_string(stretched / kSpacing));
    RecordProperty("rigid_energy_error", std::to_string(most_rigid));
    EXPECT_TRUE(within(stretched / kSpacing, tol::kRigidShape));
    EXPECT_TRUE(within(most_rigid, tol::kRigidEnergy));
  }
}

// The middle of a rigid bar melts and freezes: two rigid bodies, then one.
TEST_F(Rigidify, RigidPiecesSplitAndMerge) {
  Scene scene = freezing_scene();
  add_body(scene, "bar", BodyKind::elastic, 0, {-0.06, -0.015, -0.015}, {0.06, 0.015, 0.015});
  set_moving(scene, 0.01, 0.1, 0.02);  // the middle stays in the zone
  scene.temperature.assign(scene.position.size(), kMelting - 6);
  for (const double sign : {1.0, -1.0}) {
    // the middle third is warmed by 8 K, and cooled to where it was
    add_heat(scene, sign * mass_of(scene) / 3 * (8 * kCapacity + kLatent) / kLatent, sign > 0 ? 0.05 : 0.15,
             sign > 0 ? 0.1 : 0.2);
    scene.config.heat_zones.back().size = {0.04, 0.3, 0.3};
  }
  const double scale = size_of_momenta(scene);
  const auto simulation = simulate(scene);
  const Motion start = motion_of(scene, snapshot_of(*simulation));
  std::vector<std::size_t> pieces;
  for (int k = 0; k < 260; ++k) {
    ASSERT_TRUE(simulation->step({}).health.ok);
    const Snapshot s = snapshot_of(*simulation);
    const Motion now = motion_of(scene, s);
    ASSERT_TRUE(within((now.momentum - start.momentum).norm() / scale, tol::kChangeMomentum)) << k;
    ASSERT_TRUE(within((now.spin - start.spin).norm() / (scale * 0.06), tol::kChangeMomentum)) << k;
    ASSERT_LE(now.kinetic, start.kinetic * (1 + value_of(tol::kChangeEnergy))) << k;
    if (pieces.empty() || rigid_pieces(s) != pieces.back()) pieces.push_back(rigid_pieces(s));
  }
  EXPECT_EQ(pieces, (std::vector<std::size_t>{0, 1, 0, 2, 0, 1}));
}

// One particle, two, a line of them, a sheet: no inertia round some axes.
TEST_F(Rigidify, FewParticlesFlyOn) {
  for (const Eigen::Vector3i& n : {Eigen::Vector3i(1, 1, 1), {2, 1, 1}, {5, 1, 1}, {4, 3, 1}}) {
    SCOPED_TRACE(::testing::Message() << n.transpose());
    Scene scene = freezing_scene();
    add_body(scene, "few", BodyKind::elastic, 0, Eigen::Vector3d::Zero(), kSpacing * n.cast<double>());
    set_moving(scene, 0.2, 40, 0);
    scene.temperature.assign(scene.position.size(), kMelting - 6);
    const auto simulation = simulate(scene);
    const Motion start = motion_of(scene, snapshot_of(*simulation));
    run_until(*simulation, 0.2);
    ASSERT_TRUE(simulation->output().health.ok);
    const Snapshot s = snapshot_of(*simulation);
    const Motion end = motion_of(scene, s);
    EXPECT_EQ(rigid_count(s), scene.position.size());
    const double scale = size_of_momenta(scene);
    EXPECT_TRUE(within((end.momentum - start.momentum).norm() / scale, tol::kChangeMomentum));
    EXPECT_TRUE(within((end.spin - start.spin).norm() / (scale * 0.04), tol::kChangeMomentum));
    EXPECT_LE(end.kinetic, start.kinetic * (1 + value_of(tol::kChangeEnergy)));
  }
}

TEST_F(Rigidify, MorePiecesThanThereIsRoomForStaySoft) {
  Scene scene = freezing_scene();
  const auto alone = [](double x) { return static_cast<int>(std::floor(x / kSpacing)) % 3 == 0; };
  add_body(scene, "grains", BodyKind::elastic, 0, {0, 0, 0}, {0.15, 0.15, 0.09},
           [&](const Eigen::Vector3d& x) { return alone(x.x()) && alone(x.y()) && alone(x.z()); });
  set_moving(scene, 0.1, 0, 0.01);
  scene.temperature.assign(scene.position.size(), kMelting - 6);
  const auto simulation = simulate(scene);
  run_until(*simulation, 0.05);
  const Snapshot s = snapshot_of(*simulation);
  ASSERT_GT(scene.position.size(), kMaxRigidPieces);
  for (std::size_t i = 0; i < s.rigid.size(); ++i) EXPECT_EQ(s.rigid[i], i < kMaxRigidPieces ? 1 : 0) << i;
  for (std::size_t i = 0; i < s.velocity.size(); ++i)
    EXPECT_NEAR(s.velocity[i], scene.velocity[i / 3][static_cast<Eigen::Index>(i % 3)], 1e-6);
}

TEST_F(Rigidify, WhatHasSetIsRigidWhereThatIsAsked) {
  for (const bool asked : {true, false}) {
    Scene scene = freezing_scene();
    MaterialConfig& m = scene.config.materials[0];
    m.melting_temperature.reset();
    m.latent_heat = 0;
    m.rigid_below.reset();
    m.rigid_when_set = asked;
    m.cooking_temperature = 310;
    m.cooking_time = 0.05;
    add_body(scene, "batter", BodyKind::fluid, 0, {0, 0, 0}, {0.03, 0.03, 0.03});
    scene.temperature.assign(scene.position.size(), 350);
    const auto simulation = simulate(scene);
    run_until(*simulation, 0.03);
    EXPECT_EQ(rigid_count(snapshot_of(*simulation)), 0u);
    run_until(*simulation, 0.08);
    EXPECT_EQ(rigid_count(snapshot_of(*simulation)), asked ? 27u : 0u);
  }
}

// The hand's tool stays what it is, and so does what is frozen to it.
TEST_F(Rigidify, WhatHoldsAToolStaysSoft) {
  Scene scene = freezing_scene();
  add_material(scene, 1000, 0.1);
  scene.config.materials[1].heat_capacity = kCapacity;
  const auto tool = add_body(scene, "tool", BodyKind::rigid, 1, {-0.02, -0.02, 0}, {0.02, 0.02, 0.04});
  const auto coat = add_body(scene, "coat", BodyKind::elastic, 0, {-0.02, -0.02, 0.04}, {0.02, 0.02, 0.06});
  add_body(scene, "crumb", BodyKind::elastic, 0, {-0.02, -0.02, 0.1}, {0.02, 0.02, 0.12});
  scene.bodies[coat].bonded_to.push_back(tool);
  scene.temperature.assign(scene.position.size(), kMelting - 6);
  const auto simulation = simulate(scene);
  run_until(*simulation, 0.03);
  const Snapshot s = snapshot_of(*simulation);
  for (std::size_t i = 0; i < s.rigid.size(); ++i) {
    EXPECT_EQ(s.rigid[i], scene.body[i] > coat ? 1 : 0) << i;
    EXPECT_EQ(s.body_id[i], scene.body[i] > coat ? 3 + scene.bodies[2].first : tool) << i;
  }
}

TEST_F(Rigidify, RunsRepeatBitForBit) {
  Scene scene = freezing_scene();
  add_body(scene, "bar", BodyKind::elastic, 0, {-0.06, -0.015, -0.015}, {0.06, 0.015, 0.015});
  add_body(scene, "melt", BodyKind::fluid, 0, {-0.06, -0.015, 0.02}, {0.06, 0.015, 0.05});
  set_moving(scene, 0.1, 1, 0.05);
  for (const std::uint32_t b : scene.body)
    scene.temperature.push_back(b == 0 ? kMelting - 6 : kMelting + between(0, 1));
  add_warming(scene, -5, 0.03, 0.08);
  const auto first = simulate(scene), second = simulate(scene);
  Snapshot a, b;
  for (Simulation* simulation : {first.get(), second.get()}) {
    run_until(*simulation, 0.1);
    simulation->snapshot(simulation == first.get() ? a : b);
  }
  EXPECT_GT(rigid_count(a), 0u);
  EXPECT_EQ(a.position, b.position);
  first->reset();
  run_until(*first, 0.1);
  first->snapshot(b);
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_EQ(a.body_id, b.body_id);
  EXPECT_EQ(a.rigid, b.rigid);
}

TEST(Lightness, RigidPiecesArePaidForWhereTheyCanBe) {
  Scene scene = freezing_scene();
  add_body(scene, "lump", BodyKind::elastic, 0, {0, 0, 0}, {0.03, 0.03, 0.03});
  scene.temperature.assign(scene.position.size(), kMelting - 6);
  for (const bool asked : {true, false}) {
    if (!asked) scene.config.materials[0].rigid_below.reset();
    const auto simulation = simulate(scene);
    for (int k = 0; k < 20; ++k) simulation->step({});
    std::size_t found = 0;
    for (const auto& [name, bytes] : simulation->footprint().arrays) found += name.find("rigid") == 0 ? 1 : 0;
    for (const std::string& name : simulation->footprint().launches) found += name.find("rigid") == 0 ? 1 : 0;
    EXPECT_EQ(found > 0, asked);
    EXPECT_EQ(snapshot_of(*simulation).rigid.empty(), !asked);
  }
}

}  // namespace
}  // namespace palp::test::rigid_pieces_test
