// Melting, freezing and setting: what bonds do, what is kept through a change, and what it costs.
#include <gtest/gtest.h>

#include "config/error.h"
#include "sim_server/state_change_plan.h"
#include "tests/support/change_scenes.h"
#include "tests/support/random_scene.h"
#include "tests/support/tolerance.h"

namespace palp::testing {
namespace {

// What is solid and stays so moves as an elastic body of the same stuff, which is another code (elastic.h).
TEST(StateChange, ASolidIsAnElasticBody) {
  Scene scene = melting_scene();
  scene.config.numerics.support_over_spacing = 2;
  add_body(scene, "block", BodyType::elastic, 0, {0, 0, 0}, {0.06, 0.05, 0.04});
  Random random(5);
  for (Eigen::Vector3d& v : scene.velocity) v = random_vector(random, 0.05);
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    scene.velocity[i] += Eigen::Vector3d(0, 0, 2).cross(scene.position[i]);
  scene.config.numerics.sub_steps = 4;
  Scene plain = scene;
  plain.config.materials[0].melting_temperature.reset();
  plain.config.materials[0].conductivity = 0;
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

TEST(StateChange, WithAWrenchIsRefused) {
  Scene scene = on_a_floor(BodyType::elastic, kMelting - 1);
  ProbeConfig probe;
  probe.name = "p";
  probe.quantity = Quantity::body;
  probe.body = "stuff";
  scene.config.probes.push_back(probe);
  EXPECT_THROW(make_plan(scene), ConfigError);
}

TEST(Lightness, ChangeIsPaidForWhereItHappens) {
  Scene scene = on_a_floor(BodyType::fluid, kMelting + 1);
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
  }
  for (const std::string& name : without->footprint().launches) {
    EXPECT_EQ(name.find("bond"), std::string::npos) << name;
    EXPECT_EQ(name.find("fraction"), std::string::npos) << name;
  }
  const auto& launches = with->footprint().launches;
  EXPECT_NE(std::find(launches.begin(), launches.end(), "bonds"), launches.end());
}

}  // namespace
}  // namespace palp::testing
