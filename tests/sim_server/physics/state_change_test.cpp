// Melting, freezing and setting: what bonds do, what is kept through a change, and what it costs.
#include <gtest/gtest.h>

#include <set>

#include "config/error.h"
#include "sim_server/solver/state_change_plan.h"
#include "tests/support/change_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/tolerance.h"

namespace palp::test::state_change_test {
namespace {

// Matter that is solid and stays so moves as an elastic body of the same stuff, which is another code (elastic.h): of
// one that could tear, since that takes its gradients from all of its bonds, too.
TEST(StateChange, ASolidIsAnElasticBody) {
  Scene scene = melting_scene();
  scene.config.numerics.support_over_spacing = 2;
  add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, {0.06, 0.05, 0.04});
  Random random(5);
  for (Eigen::Vector3d& v : scene.velocity) v = random_vector(random, 0.05);
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    scene.velocity[i] += Eigen::Vector3d(0, 0, 2).cross(scene.position[i]);
  scene.config.numerics.sub_steps = 4;
  Scene plain = scene;
  plain.config.materials[0].melting_temperature.reset();
  plain.config.materials[0].conductivity = 0;
  plain.config.materials[0].tear_strain = 100;
  scene.temperature.assign(scene.position.size(), kMelting - 10);
  ASSERT_EQ(make_plan(scene).slots, 120u);
  ASSERT_EQ(make_plan(plain).elastic_count, 120u);
  const auto a = simulate(scene), b = simulate(plain);
  double moved = 0, apart = 0;
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(a->step({}).health.ok);
    ASSERT_TRUE(b->step({}).health.ok);
  }
  const Snapshot s = snapshot_of(*a), t = snapshot_of(*b);
  for (std::size_t i = 0; i < s.position.size(); ++i) {
    apart = std::max(apart, static_cast<double>(std::abs(s.position[i] - t.position[i])));
    moved = std::max(moved, std::abs(s.position[i] - scene.position[i / 3][static_cast<Eigen::Index>(i % 3)]));
  }
  ASSERT_GT(moved, kSpacing);
  EXPECT_TRUE(within(apart / kSpacing, tol::kBondedMotion));
}

// Bonds hold whatever came before: the slots of a body that follows a single particle are one less than its particles.
TEST(StateChange, BondsHoldAfterABodyOfOneParticle) {
  Scene scene = melting_scene();
  const auto water = add_material(scene, 1000, 0.1);
  scene.config.materials[water].heat_capacity = kCapacity;
  add_body(scene, "speck", BodyKind::fluid, water, {-0.2, 0, 0}, {-0.19, 0.01, 0.01});
  add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, {0.06, 0.05, 0.04});
  Random random(6);
  for (std::size_t i = 1; i < scene.position.size(); ++i) scene.velocity[i] = random_vector(random, 0.05);
  scene.temperature.assign(scene.position.size(), kMelting - 10);
  ASSERT_EQ(scene.bodies[0].count, 1u);
  const auto simulation = simulate(scene);
  run_until(*simulation, 0.3);
  ASSERT_TRUE(simulation->output().health.ok);
  const Snapshot s = snapshot_of(*simulation);
  const auto moved = [&](std::size_t i) -> Eigen::Vector3d {
    return Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>() - scene.position[i];
  };
  double apart = 0;
  for (std::size_t i = 2; i < scene.position.size(); ++i) apart = std::max(apart, (moved(i) - moved(1)).norm());
  EXPECT_LT(apart, 0.5 * kSpacing) << "without bonds they come apart by a spacing";
}

// Snapshot::body_id where all that is solid and closer than the reach of bonds is bonded.
std::vector<std::uint32_t> ids_by_distance(const Scene& scene, const Snapshot& s, double reach) {
  std::vector<std::uint32_t> id = scene.body;
  const auto at = [&](std::size_t i) { return Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]); };
  const auto count = static_cast<std::uint32_t>(scene.bodies.size());
  for (std::uint32_t first = 0; first < id.size(); ++first) {
    if (s.solid[first] < 0.5f || id[first] >= count) continue;
    std::vector<std::uint32_t> open{first};
    while (!open.empty()) {
      const std::uint32_t i = open.back();
      open.pop_back();
      if (id[i] >= count) continue;
      id[i] = count + first;
      for (std::uint32_t j = 0; j < id.size(); ++j)
        if (s.solid[j] > 0.5f && (at(i) - at(j)).norm() < reach) open.push_back(j);
    }
  }
  return id;
}

std::size_t number_of(const std::vector<std::uint32_t>& ids, std::size_t bodies) {
  std::set<std::uint32_t> all;
  for (const std::uint32_t id : ids)
    if (id >= bodies) all.insert(id);
  return all.size();
}

// A bar of two bodies whose middle melts and freezes: one piece, two, and one again.
TEST(StateChange, PiecesSplitAndMerge) {
  Scene scene = melting_scene();
  add_body(scene, "other", BodyKind::fluid, 0, {-0.06, 0.1, 0}, {0.06, 0.12, 0.02});
  add_body(scene, "bar", BodyKind::elastic, 0, {-0.06, -0.015, -0.015}, {0.06, 0.015, 0.015});
  for (const std::uint32_t b : scene.body) scene.temperature.push_back(kMelting + (b == 0 ? 0.5 : -0.5));
  for (const double sign : {1.0, -1.0}) {
    add_heat(scene, sign * 1.5 * 0.036, sign > 0 ? 0.05 : 0.15, sign > 0 ? 0.1 : 0.2);
    scene.config.heat_zones.back().size = {0.04, 0.05, 1};
  }
  const auto simulation = simulate(scene);
  int checked = 0;
  for (const auto& [time, pieces] : {std::pair(0.0, 1u), {0.04, 1u}, {0.13, 2u}, {0.25, 1u}}) {
    run_until(*simulation, time);
    const Snapshot s = snapshot_of(*simulation);
    EXPECT_EQ(number_of(s.body_id, scene.bodies.size()), pieces) << time;
    EXPECT_EQ(s.body_id, ids_by_distance(scene, s, 0.019)) << time;
    ++checked;
  }
  EXPECT_EQ(checked, 4);
  simulation->reset();
  EXPECT_EQ(number_of(snapshot_of(*simulation).body_id, scene.bodies.size()), 1u);
}

// Two pieces of one body are two bodies: they bounce off each other.
TEST(StateChange, PiecesOfABodyMeet) {
  for (const bool rigid : {false, true}) {
    Scene scene = melting_scene(1e5);
    if (rigid) scene.config.materials[0].rigid_below = kMelting - 5;
    const auto body = add_body(scene, "two", BodyKind::elastic, 0, {-0.05, -0.02, -0.02}, {0.05, 0.02, 0.02},
                               [](const Eigen::Vector3d& x) { return std::abs(x.x()) > 0.02; });
    for (std::size_t i = 0; i < scene.position.size(); ++i)
      scene.velocity[i] = {scene.position[i].x() > 0 ? -0.2 : 0.2, 0, 0};
    scene.temperature.assign(scene.position.size(), kMelting - 6);
    const auto simulation = simulate(scene);
    double closest = 1, gap = 1;
    const Motion start = motion_of(scene, snapshot_of(*simulation));
    for (int k = 0; k < 40; ++k) {
      run_until(*simulation, 0.01 * k);
      ASSERT_TRUE(simulation->output().health.ok);
      const Snapshot s = snapshot_of(*simulation);
      EXPECT_EQ(number_of(s.body_id, scene.bodies.size()), 2u);
      gap = 0;
      for (std::size_t i = 0; i < scene.position.size(); ++i)
        gap += (scene.position[i].x() > 0 ? 2.0 : -2.0) * s.position[3 * i] / scene.bodies[body].count;
      closest = std::min(closest, gap);
      const Motion now = motion_of(scene, s);
      EXPECT_LE(now.kinetic, start.kinetic * (1 + value_of(tol::kChangeEnergy)));
      EXPECT_TRUE(within(now.momentum.norm() / (0.2 * mass_of(scene)), tol::kChangeMomentum));
    }
    RecordProperty(rigid ? "rigid_closest" : "closest", std::to_string(closest));
    EXPECT_GT(closest, 2.5 * kSpacing) << "they are three spacings thick";
    EXPECT_GT(gap, closest + 0.5 * kSpacing);
  }
}

TEST(StateChange, WithAWrenchIsRefused) {
  Scene scene = on_a_floor(BodyKind::elastic, kMelting - 1);
  ProbeConfig probe;
  probe.name = "p";
  probe.quantity = Quantity::body;
  probe.body = "stuff";
  scene.config.probes.push_back(probe);
  EXPECT_THROW(make_plan(scene), ConfigError);
}

TEST(Lightness, ChangeIsPaidForWhereItHappens) {
  Scene scene = on_a_floor(BodyKind::fluid, kMelting + 1);
  Scene lasting = scene;
  lasting.config.materials[0].young_modulus.reset();
  const auto with = simulate(scene), without = simulate(lasting);
  for (int k = 0; k < 50; ++k) {
    with->step({});
    without->step({});
  }
  for (const auto& [name, bytes] : without->footprint().arrays) {
    EXPECT_EQ(name.find("change"), std::string::npos) << name;
    EXPECT_EQ(name.find("bond"), std::string::npos) << name;
    EXPECT_EQ(name.find("solid fraction"), std::string::npos) << name;
    EXPECT_EQ(name.find("piece"), std::string::npos) << name;
  }
  for (const std::string& name : without->footprint().launches) {
    EXPECT_EQ(name.find("bond"), std::string::npos) << name;
    EXPECT_EQ(name.find("fraction"), std::string::npos) << name;
    EXPECT_EQ(name.find("piece"), std::string::npos) << name;
  }
  const auto& launches = with->footprint().launches;
  EXPECT_NE(std::find(launches.begin(), launches.end(), "bonds"), launches.end());
}

}  // namespace
}  // namespace palp::test::state_change_test
