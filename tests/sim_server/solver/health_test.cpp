// Whatever goes wrong inside stops with a cause, never with a crash or with silence.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/random_scene.h"

namespace palp::test::health_test {
namespace {

Scene drop() {
  Scene scene = empty_scene(0.05, {-0.5, -0.5, -0.2}, {0.5, 0.5, 0.8});
  add_material(scene, 1000, 1e-3);
  add_body(scene, "water", BodyKind::fluid, 0, {-0.2, -0.2, 0}, {0.2, 0.2, 0.3});
  return scene;
}

TEST(Health, ReportsEnergySpeedAndCompression) {
  Scene scene = drop();
  scene.config.gravity.setZero();
  for (Eigen::Vector3d& v : scene.velocity) v = {0.3, 0, 0.4};
  scene.config.numerics.max_speed = 1;
  const auto simulation = simulate(scene);
  const Health& h = simulation->step({}).health;
  EXPECT_TRUE(h.ok);
  EXPECT_NEAR(h.max_speed, 0.5, 1e-4);
  EXPECT_NEAR(h.kinetic_energy, 0.5 * 1000 * scene.bodies[0].volume * 0.25, 1e-3 * 1000 * scene.bodies[0].volume);
  EXPECT_LT(h.max_compression, 1e-4);
  EXPECT_EQ(h.outside, 0u);
}

TEST(Health, NanStopsWithACause) {
  for (Method method : {Method::accurate, Method::paper}) {
    Scene scene = drop();
    scene.config.method = method;
    scene.velocity[17].y() = std::numeric_limits<double>::quiet_NaN();
    scene.config.numerics.max_speed = 2;
    const auto simulation = simulate(scene);
    const StepOutput& out = simulation->step({});
    EXPECT_FALSE(out.health.ok);
    EXPECT_GE(out.health.non_finite, 1u);
    EXPECT_NE(out.health.cause.find("non-finite"), std::string::npos);
    for (int k = 0; k < 20; ++k) EXPECT_FALSE(simulation->step({}).health.ok) << "it must not heal by itself";
    Snapshot s;
    simulation->snapshot(s);
  }
}

// For a body whose state is no longer a number its last finite state is given out, and the sums that status carries
// stay finite.
TEST(Health, ABodyThatIsNoLongerFiniteGivesNothingNonFiniteOut) {
  Scene scene = empty_scene(0.05, {-0.5, -0.5, -0.2}, {0.5, 0.5, 0.8});
  add_material(scene, 1000, 1e-3);
  const std::uint32_t stone = add_body(scene, "stone", BodyKind::rigid, 0, {-0.2, -0.2, 0}, {0.2, 0.2, 0.3});
  Proxy proxy;
  proxy.body = stone;
  scene.proxies.push_back(proxy);
  scene.config.gravity.z() = std::numeric_limits<double>::quiet_NaN();
  const auto simulation = simulate(scene);
  StepInput input{};
  input[0].engaged = true;
  input[0].gains = proxy.limit;
  const StepOutput& out = simulation->step(input);
  EXPECT_FALSE(out.health.ok);
  EXPECT_NE(out.health.cause.find("'stone'"), std::string::npos) << out.health.cause;
  EXPECT_TRUE(std::isfinite(out.health.kinetic_energy));
  EXPECT_TRUE(out.bodies[stone].state.position.allFinite() && out.bodies[stone].state.linear.allFinite());
  EXPECT_TRUE(out.proxies[0].state.position.allFinite() && out.proxies[0].state.linear.allFinite());
}

TEST(Health, ParticlesOutsideTheDomainAreCounted) {
  Scene scene = drop();
  scene.bounds_min.z() = 0.1;
  const auto simulation = simulate(scene);
  const Health& h = simulation->step({}).health;
  EXPECT_EQ(h.outside, scene.position.size() / 3);
  EXPECT_TRUE(h.ok);
}

TEST(Health, SpeedPastSoundIsADivergence) {
  Scene scene = drop();
  scene.config.numerics.sound_speed = 5;
  scene.config.numerics.max_speed = 1;
  for (Eigen::Vector3d& v : scene.velocity) v = {0, 0, 6};
  const auto simulation = simulate(scene);
  const Health& h = simulation->step({}).health;
  EXPECT_FALSE(h.ok);
  EXPECT_NE(h.cause.find("sound speed"), std::string::npos) << h.cause;
}

// Two blocks pushed into each other.
TEST(Health, OverlappingFluidsNeverCrash) {
  Scene scene = drop();
  add_body(scene, "more", BodyKind::fluid, 0, {-0.2, -0.2, 0.01}, {0.2, 0.2, 0.31});
  const auto simulation = simulate(scene);
  for (int k = 0; k < 200; ++k) simulation->step({});
  Snapshot s;
  simulation->snapshot(s);
  EXPECT_EQ(s.position.size(), 3 * scene.position.size());
}

// Coincident particles have no direction to part in; the state must stay finite.
TEST(Health, CoincidentParticlesStayFinite) {
  for (Method method : {Method::accurate, Method::paper}) {
    Scene scene = drop();
    scene.config.method = method;
    scene.config.numerics.max_speed = 2;
    scene.position[5] = scene.position[6];
    scene.position[7] = scene.position[8] + Eigen::Vector3d(1e-7, 0, 0);
    const auto simulation = simulate(scene);
    for (int k = 0; k < 50; ++k) EXPECT_EQ(simulation->step({}).health.non_finite, 0u);
  }
}

// A rigid body that drifts through a periodic domain again and again keeps its particles inside.
TEST(Health, ABodyCrossesAPeriodicDomainManyTimes) {
  Scene scene = empty_scene(0.05, {-0.4, -0.4, -0.4}, {0.4, 0.4, 0.4});
  scene.config.periodic = {true, true, true};
  scene.config.gravity.setZero();
  add_material(scene, 1000, 0);
  add_body(scene, "box", BodyKind::rigid, 0, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
  scene.bodies[0].velocity = {5, -3, 1};
  scene.velocity.assign(scene.velocity.size(), scene.bodies[0].velocity);
  const auto simulation = simulate(scene);
  for (int k = 0; k < 1000; ++k) simulation->step({});
  Snapshot s;
  simulation->snapshot(s);
  for (std::size_t i = 0; i < s.position.size(); ++i) {
    ASSERT_GE(s.position[i], -0.4001f) << "particle " << i / 3;
    ASSERT_LE(s.position[i], 0.4001f) << "particle " << i / 3;
  }
}

}  // namespace
}  // namespace palp::test::health_test
