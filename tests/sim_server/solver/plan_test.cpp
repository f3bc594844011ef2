// The plan's limits: what it allows, and what it refuses.
#include <gtest/gtest.h>

#include "config/error.h"
#include "sim_server/solver/plan.h"
#include "tests/support/scenes.h"

namespace palp::test::plan_test {
namespace {

// Returns what a scene is refused with; empty where it is not.
std::string fault_of(const Scene& scene) {
  try {
    make_plan(scene);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(Plan, TakesMoreOfTheLimitBySoundThanOfOthers) {
  Scene scene = pool_of_water();
  scene.config.materials[0].viscosity = 0;
  scene.config.numerics.density_diffusion = 0;
  scene.config.rate_hz = 1;
  for (const auto& [support, share] :
       {std::pair(2.0, 1.3), {2.49, 1.3}, {2.5, 1.5}, {2.77, 1.5}, {2.79, 1.5}, {3.0, 1.5}})
    for (const double safety : {0.05, 0.5, 0.7, 0.9, 1.0}) {
      scene.config.numerics.support_over_spacing = support;
      scene.config.numerics.safety = safety;
      const Plan plan = make_plan(scene);
      ASSERT_EQ(plan.ruling.by, "sound");
      EXPECT_EQ(plan.sub_steps, std::ceil(1 / (std::min(1.0, share * safety) * plan.dt_limit) - 1e-9))
          << support << " " << safety;
    }
  scene.config.numerics.safety = 0.5;
  scene.config.materials[0].viscosity = 5000;
  scene.config.numerics.viscosity = ViscosityScheme::explicit_;
  const Plan thick = make_plan(scene);
  ASSERT_EQ(thick.ruling.by, "viscosity");
  EXPECT_EQ(thick.sub_steps, std::ceil(1 / (0.5 * thick.dt_limit) - 1e-9));
  scene.config.materials[0].viscosity = 0;
  scene.config.numerics.density_diffusion = 0.4;
  const Plan smoothed = make_plan(scene);
  ASSERT_EQ(smoothed.ruling.by, "density diffusion");
  EXPECT_EQ(smoothed.sub_steps, std::ceil(1 / (0.85 * smoothed.dt_limit) - 1e-9));
}

TEST(Plan, RefusesUnstableSubSteps) {
  Scene scene = pool_of_water();
  scene.config.rate_hz = 20;
  const Plan own = make_plan(scene);
  const int least = static_cast<int>(std::ceil(0.05 / own.dt_limit));
  ASSERT_GT(least, 1);
  scene.config.numerics.sub_steps = least;
  EXPECT_NO_THROW(make_plan(scene));
  scene.config.numerics.sub_steps = least - 1;
  EXPECT_NE(fault_of(scene).find("at least " + std::to_string(least)), std::string::npos) << fault_of(scene);
}

TEST(Plan, TakesRoundsAndSkinAsAsked) {
  Scene scene = pool_of_water();
  scene.config.numerics.skin_over_spacing = 0.4;
  EXPECT_DOUBLE_EQ(make_plan(scene, 0.2).skin, 0.4 * 0.05);
  Scene block = empty_scene(0.05, {-0.5, -0.5, -0.2}, {0.5, 0.5, 0.8});
  const auto rubber = add_material(block, 1000, 0);
  block.config.materials[rubber].young_modulus = 1e8;
  add_body(block, "block", BodyKind::elastic, rubber, {-0.2, -0.2, 0}, {0.2, 0.2, 0.3});
  block.config.numerics.elastic_solver = ElasticSolver::implicit;
  EXPECT_GT(make_plan(block).elastic_rounds, 7);
  block.config.numerics.elastic_rounds = 7;
  EXPECT_EQ(make_plan(block).elastic_rounds, 7);
}

TEST(Plan, KnowsWhetherFluidsOfSeveralMaterialsMeet) {
  Scene scene = pool_of_water();
  EXPECT_TRUE(make_plan(scene).one_fluid);
  const auto other = add_material(scene, 900, 1e-2);
  add_tray(scene, other, {-0.2, -0.2, 0}, {0.2, 0.2, 0.4}, 0.15);
  EXPECT_TRUE(make_plan(scene).one_fluid) << "a solid of another material is no fluid";
  add_body(scene, "more water", BodyKind::fluid, 0, {-0.2, -0.2, 0.35}, {0.2, 0.2, 0.4});
  EXPECT_TRUE(make_plan(scene).one_fluid);
  add_body(scene, "oil", BodyKind::fluid, other, {-0.2, -0.2, 0.45}, {0.2, 0.2, 0.5});
  EXPECT_FALSE(make_plan(scene).one_fluid);
}

TEST(Plan, RefusesAShortPeriodicAxis) {
  Scene scene = pool_of_water();
  scene.config.periodic = {true, false, false};
  scene.bounds_min.x() = -0.2;
  scene.bounds_max.x() = 0.2;
  EXPECT_THROW(make_plan(scene), ConfigError);
}

TEST(Plan, RefusesAnEndlessNumberOfSubSteps) {
  Scene scene = pool_of_water();
  scene.config.materials[0].viscosity = 1e9;
  EXPECT_THROW(make_plan(scene), ConfigError);
}

// A kilometre away places are rounded to a tenth of a millimetre.
TEST(Plan, RefusesScenesFarFromTheOrigin) {
  Scene scene = pool_of_water();
  const double far = 0.01 * scene.spacing / std::numeric_limits<real>::epsilon();
  for (Eigen::Vector3d& x : scene.position) x.x() += 0.9 * far;
  scene.bounds_max.x() += far;
  EXPECT_NO_THROW(make_plan(scene));
  for (Eigen::Vector3d& x : scene.position) x.x() += 0.2 * far;
  EXPECT_NE(fault_of(scene).find("move the scene to the origin"), std::string::npos) << fault_of(scene);
}

// A stone that falls moves by less and less of what places are rounded to.
TEST(Plan, RefusesRigidBodiesWhoseMotionIsRounded) {
  Scene scene = empty_scene(0.1, {-2000, -1, -1}, {2000, 1, 1});
  add_material(scene, 1000, 0);
  add_body(scene, "stone", BodyKind::rigid, 0, {0, 0, 0}, {0.2, 0.2, 0.2});
  EXPECT_EQ(fault_of(scene), "");
  scene.bodies[0].position.x() = 100;
  EXPECT_EQ(fault_of(scene), "");
  scene.bodies[0].position.x() = 1000;
  const std::string expected = sizeof(real) == 4 ? "expected 20 times the rounding: move the scene to the origin" : "";
  EXPECT_NE(fault_of(scene).find(expected), std::string::npos) << fault_of(scene);
  // a fluid there is none the worse for it
  scene.bodies[0].type = BodyKind::fluid;
  EXPECT_EQ(fault_of(scene), "");
}

TEST(Plan, RefusesExplicitElasticityThatRoundingAgitates) {
  Scene scene = empty_scene(0.02, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
  add_material(scene, 1000, 0);
  scene.config.materials[0].poisson_ratio = 0.3;
  add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, {0.08, 0.08, 0.06});
  scene.config.numerics.elastic_solver = ElasticSolver::explicit_;
  scene.config.materials[0].young_modulus = 1e9;
  EXPECT_EQ(fault_of(scene), "");
  scene.config.materials[0].young_modulus = 1e12;
  const std::string expected = sizeof(real) == 4 ? "or leave elastic_solver out" : "";
  EXPECT_NE(fault_of(scene).find(expected), std::string::npos) << fault_of(scene);
  scene.config.numerics.elastic_solver.reset();
  EXPECT_EQ(fault_of(scene), "");
}

TEST(Plan, RefusesMediaOfUnlikeDensityByMethodPaper) {
  Scene scene = pool_of_water();
  const auto foam = add_material(scene, 99, 1e-3);
  add_body(scene, "foam", BodyKind::fluid, foam, {-0.2, -0.2, 0.35}, {0.2, 0.2, 0.4});
  EXPECT_EQ(fault_of(scene), "");
  scene.config.method = Method::paper;
  EXPECT_NE(fault_of(scene).find("expected at most 10 times with method \"paper\""), std::string::npos)
      << fault_of(scene);
  scene.config.materials[foam].density = 101;
  EXPECT_EQ(fault_of(scene), "");
}

// By its equations a solid's particles push with the pressure of their own density.
TEST(Plan, FollowsTheDensityOfSolidsByMethodPaper) {
  Scene scene = pool_of_water();
  const auto heavy = add_material(scene, 80000, 0);
  add_body(scene, "tool", BodyKind::rigid, heavy, {-0.1, -0.1, 0.4}, {0.1, 0.1, 0.6});
  scene.config.method = Method::paper;
  scene.config.numerics.sound_speed = 10;
  const Plan dense = make_plan(scene);
  EXPECT_EQ(dense.ruling.by, "density");
  scene.config.materials[heavy].density = 5000;
  const Plan light = make_plan(scene);
  EXPECT_EQ(light.ruling.by, "sound");
  EXPECT_NEAR(light.dt_limit / dense.dt_limit, 4, 1e-6);
  scene.config.materials[heavy].density = 80000;
  scene.config.method = Method::accurate;
  for (const StepLimit& limit : make_plan(scene).limits) EXPECT_NE(limit.by, "density");
}

TEST(Plan, LetsNothingSleepThatConductsHeat) {
  Scene scene = pool_of_water();
  EXPECT_FALSE(make_plan(scene).sleeps);
  scene.config.numerics.sleep_speed = 0.01;
  EXPECT_TRUE(make_plan(scene).sleeps);
  EXPECT_GT(make_plan(scene).sleep_interval, 1);
  scene.config.numerics.region_of_interest = 0.1;
  EXPECT_EQ(fault_of(scene), "");
  scene.config.numerics.sleep_speed.reset();
  EXPECT_NE(fault_of(scene).find("in a scene without tools"), std::string::npos) << fault_of(scene);
  scene.config.numerics.region_of_interest.reset();
  scene.config.numerics.sleep_speed = 0.01;
  scene.temperature.assign(scene.position.size(), 300);
  scene.config.materials[0].conductivity = 1;
  scene.config.materials[0].heat_capacity = 1000;
  EXPECT_EQ(fault_of(scene), "");  // no heat flows
  scene.temperature[0] = 310;
  EXPECT_NE(fault_of(scene).find("numerics.sleep_speed is set in a scene with heat"), std::string::npos)
      << fault_of(scene);
}

// Heat is computed only where it can flow.
TEST(Plan, LeavesHeatOutWhereAllIsAsWarm) {
  Scene scene = pool_of_water();
  scene.config.materials[0].conductivity = 1;
  scene.config.materials[0].heat_capacity = 1000;
  scene.temperature.assign(scene.position.size(), 300);
  EXPECT_FALSE(make_plan(scene).heat);
  EXPECT_TRUE(make_plan(scene).temperature);
  scene.config.heat.air_temperature = 300;
  scene.config.heat.loss_to_air = 10;
  EXPECT_FALSE(make_plan(scene).heat);
  scene.config.heat.air_temperature = 290;
  EXPECT_TRUE(make_plan(scene).heat);
  scene.config.heat.loss_to_air = 0;
  EXPECT_FALSE(make_plan(scene).heat);
  scene.temperature.back() = 301;
  EXPECT_TRUE(make_plan(scene).heat);
  scene.temperature.back() = 300;
  HeatZoneConfig zone;
  zone.name = "hob";
  zone.size = {0.1, 0.1, 0.1};
  zone.power = 100;
  scene.config.heat_zones.push_back(zone);
  EXPECT_TRUE(make_plan(scene).heat);
}

// 0.06 m of it on a floor, on which it holds.
Scene elastic_block() {
  Scene scene = empty_scene(0.02, {-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2});
  scene.config.method = Method::paper;
  add_material(scene, 1000, 0);
  scene.config.materials[0].young_modulus = 1e5;
  scene.config.materials[0].poisson_ratio = 0.3;
  add_body(scene, "floor", BodyKind::fixed, 0, {0, 0, -0.04}, {0.08, 0.08, 0});
  const auto block = add_body(scene, "block", BodyKind::elastic, 0, {0, 0, 0}, {0.08, 0.08, 0.06});
  scene.bodies[block].bonded_to = {0};
  return scene;
}

TEST(Plan, RefusesBondedBodiesTooSoftForTheirWeightByMethodPaper) {
  Scene scene = elastic_block();
  MaterialConfig& m = scene.config.materials[0];
  m.damping = 100;
  EXPECT_EQ(fault_of(scene), "");
  m.young_modulus = 1000 * 9.81 * 0.06 / 0.31;
  EXPECT_NE(fault_of(scene).find("by 31 % under its own weight"), std::string::npos) << fault_of(scene);
  m.young_modulus = 1000 * 9.81 * 0.06 / 0.29;
  EXPECT_EQ(fault_of(scene), "");
  m.young_modulus = 1e3;
  scene.bodies[1].bonded_to.clear();
  EXPECT_EQ(fault_of(scene), "");
  scene.bodies[1].bonded_to = {0};
  scene.config.method = Method::accurate;
  EXPECT_EQ(fault_of(scene), "");
}

TEST(Plan, RefusesElasticBodiesWithTooLittleDampingByMethodPaper) {
  Scene scene = elastic_block();
  MaterialConfig& m = scene.config.materials[0];
  EXPECT_EQ(fault_of(scene), "");
  const double least = 0.03 * std::sqrt(1e5 * 1000) * 0.02;  // [Pa s]
  m.poisson_ratio = 0.46;
  EXPECT_EQ(fault_of(scene), "");
  scene.velocity.back() = {0, 0, 1};
  for (const double ratio : {-0.1, 0.46}) {
    m.poisson_ratio = ratio;
    m.damping = 0.99 * least;
    EXPECT_NE(fault_of(scene).find("expected at least 6 with method \"paper\""), std::string::npos) << fault_of(scene);
    m.damping = 1.01 * least;
    EXPECT_EQ(fault_of(scene), "");
  }
  m.damping = 0;
  m.poisson_ratio = 0.3;
  EXPECT_EQ(fault_of(scene), "");
  m.young_modulus = 1000 * 9.81 * 0.06 / 0.031;
  EXPECT_NE(fault_of(scene).find("what is bonded and so soft"), std::string::npos) << fault_of(scene);
  scene.bodies[1].bonded_to.clear();
  EXPECT_EQ(fault_of(scene), "");
}

TEST(Plan, BoundsTheCellsOfAHugeDomain) {
  Scene scene = pool_of_water();
  scene.bounds_min = Eigen::Vector3d::Constant(-500);
  scene.bounds_max = Eigen::Vector3d::Constant(500);
  const Plan plan = make_plan(scene);
  EXPECT_LE(double(plan.cells[0]) * plan.cells[1] * plan.cells[2], kMinCellLimit);
}

// A body force drives a channel to a speed that the sound speed must allow for.
TEST(Plan, ExpectsTheSpeedThatABodyForceDrives) {
  Scene scene = pool_of_water();
  scene.config.gravity.setZero();
  scene.config.body_force = {1, 0, 0};
  EXPECT_GT(make_plan(scene).max_speed, 0.1);
}

// A rigid body that falls through a fluid, or onto a floor, is as fast as its fall.
TEST(Plan, ExpectsTheSpeedOfAFall) {
  Scene scene = empty_scene(0.05, {-0.5, -0.5, -0.2}, {0.5, 0.5, 1.2});
  add_material(scene, 1000, 0);
  add_body(scene, "floor", BodyKind::fixed, 0, {-0.3, -0.3, -0.15}, {0.3, 0.3, 0});
  add_body(scene, "drop", BodyKind::fluid, 0, {-0.1, -0.1, 0.8}, {0.1, 0.1, 1});
  EXPECT_GT(make_plan(scene).max_speed, 0.9 * std::sqrt(2 * 9.81 * 0.8));
}

}  // namespace
}  // namespace palp::test::plan_test
