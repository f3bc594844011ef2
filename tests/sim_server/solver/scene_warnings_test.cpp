// A scene is refused or warned of before it runs, and a run is doubted, each for its reasons.
#include "sim_server/solver/scene_warnings.h"

#include <gtest/gtest.h>

#include "config/error.h"
#include "sim_server/solver/fluid_watch.h"
#include "sim_server/solver/health_report.h"
#include "sim_server/solver/make_simulation.h"
#include "tests/support/scenes.h"

namespace palp::test::scene_warnings_test {
namespace {

std::vector<std::string> warnings_of(const Scene& scene) { return scene_warnings(scene, make_plan(scene)); }

Scene bar(double gap) {
  Scene scene = empty_scene(0.01, {-1, -1, -1}, {1, 1, 1});
  add_material(scene, 1000, 0);
  scene.config.materials[0].young_modulus = 1e5;
  add_body(scene, "clamp", BodyKind::fixed, 0, {-0.05, -0.05, -0.05}, {0.05, 0.05, 0});
  const std::uint32_t b = add_body(scene, "bar", BodyKind::elastic, 0, {-0.05, -0.05, gap}, {0.05, 0.05, gap + 0.1});
  scene.bodies[b].bonded_to = {0};
  return scene;
}

TEST(SceneWarnings, ABondOutOfReachIsRefused) {
  EXPECT_NO_THROW(make_cpu_simulation(bar(0)));
  try {
    make_cpu_simulation(bar(0.03));
    FAIL() << "a bond that holds nothing was taken";
  } catch (const ConfigError& error) {
    for (const char* part : {"'bar'", "'clamp'", "within 0.02 m"})
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

// Water that is this deep, in a tank whose walls have this thickness.
Scene tank(double depth, double wall) {
  Scene scene = empty_scene(0.02, {-0.5, -0.5, -0.5}, {0.5, 0.5, 1});
  scene.config.accuracy = Accuracy::fast;
  add_material(scene, 1000, 1e-3);
  add_body(scene, "water", BodyKind::fluid, 0, {-0.1, -0.1, 0}, {0.1, 0.1, depth});
  add_tray(scene, 0, {-0.1, -0.1, 0}, {0.1, 0.1, depth + 0.1}, wall);
  return scene;
}

TEST(SceneWarnings, ASpeedBelowWhatTheSceneReachesIsWarnedOf) {
  Scene scene = tank(0.2, 0.06);
  EXPECT_TRUE(warnings_of(scene).empty());
  const double reached = std::sqrt(2 * 9.81 * 0.2);
  scene.config.numerics.max_speed = reached;
  EXPECT_TRUE(warnings_of(scene).empty());
  scene.config.numerics.max_speed = 0.5 * reached;
  scene.config.numerics.where = "tank.toml:7";
  ASSERT_EQ(warnings_of(scene).size(), 1u);
  EXPECT_EQ(warnings_of(scene)[0].find("tank.toml:7: [numerics] max_speed"), 0u) << warnings_of(scene)[0];
  EXPECT_NE(warnings_of(scene)[0].find("max_speed is 0.99 m/s"), std::string::npos) << warnings_of(scene)[0];
  scene.config.numerics.sound_speed = 10 * reached;  // which it was chosen for, so it does no harm
  EXPECT_TRUE(warnings_of(scene).empty());
}

// At rest the floor is compressed by g h / c^2, the mean by half of that.
TEST(FluidWatch, ARunThatIsCompressedIsNotHealthy) {
  Scene scene = tank(0.2, 0.06);
  for (const double sound : {14.0, 4.0}) {
    scene.config.numerics.sound_speed = sound;
    const double mean = 0.5 * 9.81 * 0.2 / (sound * sound);
    const auto simulation = make_cpu_simulation(scene);
    HealthRecord record;
    for (int k = 0; k < 150; ++k) record.add(simulation->step({}).health);
    EXPECT_NEAR(simulation->output().health.mean_compression, mean, 0.2 * mean);
    EXPECT_EQ(record.healthy(), sound > 10) << describe(record);
    if (sound > 10) continue;
    EXPECT_NE(record.trouble().find("raise numerics.sound_speed"), std::string::npos) << record.trouble();
    simulation->reset();
    EXPECT_TRUE(simulation->step({}).health.doubt.empty()) << "a reset forgets";
  }
}

Health calm() {
  Health health;
  health.max_speed = 0.5;
  return health;
}

TEST(FluidWatch, AMomentOfCompressionIsNone) {
  const Scene scene = tank(0.2, 0.06);
  const Plan plan = make_plan(scene);
  FluidWatch watch(scene, plan);
  for (int k = 0; k < 1000; ++k) {
    Health health = calm();
    if (k % 200 < 20) health.max_compression = 0.3;  // a fifth of each window
    watch.judge(health);
    ASSERT_TRUE(health.doubt.empty()) << "step " << k << ": " << health.doubt;
  }
}

TEST(FluidWatch, SpeedsPastMaxSpeedAreSaid) {
  const Scene scene = tank(0.2, 0.06);
  const Plan plan = make_plan(scene);
  FluidWatch watch(scene, plan);
  Health health;
  for (int k = 0; k < 200; ++k) {
    health = calm();
    health.max_speed = 2 * plan.max_speed;
    watch.judge(health);
  }
  EXPECT_NE(health.notice.find("numerics.max_speed"), std::string::npos) << health.notice;
  EXPECT_TRUE(health.doubt.empty());
  HealthRecord record;
  record.add(health);
  EXPECT_TRUE(record.healthy());
}

TEST(HealthRecord, SaysWhatWasChecked) {
  HealthRecord record;
  Health health = calm();
  health.expected_speed = 2;
  health.expected_compression = 0.01;
  health.max_compression = 0.008;
  health.mean_compression = 0.004;
  record.add(health);
  health.max_compression = 0.002;
  record.add(health);
  EXPECT_EQ(
      describe(record),
      "finite, speeds to 0.5 m/s of 2 expected, compression 0.4 % on average and 0.8 % at a peak of 1 % expected, "
      "nothing left the domain");
  health.solves = true;
  health.unsolved = 0.2;
  health.outside = 3;
  record.add(health);
  EXPECT_NE(describe(record).find("elastic solve left 20 % unsolved, 3 particles left the domain"), std::string::npos);
}

TEST(SceneWarnings, AWallOfLessThanASpacingIsWarnedOf) {
  EXPECT_TRUE(warnings_of(tank(0.2, 0.02)).empty());
  EXPECT_TRUE(warnings_of(tank(0.2, 0.03)).empty()) << "two layers of three quarters";
  Scene thin = tank(0.2, 0.02);
  for (std::uint32_t i = thin.bodies[1].first; i < thin.bodies[1].first + thin.bodies[1].count; ++i)
    thin.volume[i] *= 0.75;
  EXPECT_TRUE(warnings_of(thin).empty()) << "enough for a support of two spacings";
  thin.config.accuracy = Accuracy::accurate;
  ASSERT_EQ(warnings_of(thin).size(), 1u);
  EXPECT_NE(warnings_of(thin)[0].find("'tray'"), std::string::npos) << warnings_of(thin)[0];
}

}  // namespace
}  // namespace palp::test::scene_warnings_test
