// Fluid that rests sleeps, and nothing that a hand feels tells: a tool stirs one of two vessels, then dips into the
// other one, which sleeps by then. The same scene in which nothing sleeps says what is right.
#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "sim_server/solver/plan.h"
#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/backend.h"
#include "tests/support/random_scene.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::sleep_test {
namespace {

using Eigen::Vector3d;

constexpr double kSleepSpeed = 0.01;  // [m/s]
constexpr double kSpacing = 0.0125, kWall = 0.025;
constexpr double kInner = 0.125, kApart = 0.5, kDepth = 0.075;
constexpr double kNear = 0.2;  // a region of interest that holds a vessel [m]

// Two vessels of fluid beside each other along x, and a cube of wood above the first one that a hand holds.
Scene two_vessels(double viscosity) {
  Scene scene = empty_scene(kSpacing, {-0.15, -0.15, -0.05}, {0.65, 0.15, 0.3});
  const auto fluid = add_material(scene, 1000, viscosity), wood = add_material(scene, 400, 0);
  for (const double x : {0.0, kApart}) {
    add_tray(scene, wood, {x - kInner / 2, -kInner / 2, 0}, {x + kInner / 2, kInner / 2, 0.125}, kWall);
    add_body(scene, "fluid", BodyKind::fluid, fluid, {x - kInner / 2, -kInner / 2, 0},
             {x + kInner / 2, kInner / 2, kDepth});
  }
  Proxy proxy;
  proxy.body = add_body(scene, "tool", BodyKind::rigid, wood, {-0.025, -0.025, 0.125}, {0.025, 0.025, 0.175});
  proxy.limit = {1e6, 1e4, 1e5, 1e3};
  scene.proxies.push_back(proxy);
  return scene;
}

// Where the hand is: above the first vessel for 0.4 s, in it until 1 s, out and over to the second one until 1.6 s (at
// 1 m/s: what is faster strikes the vessel with the fluid that hangs from the tool harder than the plan foresees),
// then in that one. In a vessel it goes to and fro by 2.5 cm twice a second, 3.5 cm deep.
constexpr int kDips = 400, kLeaves = 1000, kArrives = 1600, kEnds = 2000;

Vector3d hand_at(int step) {
  const double above = kDepth + 0.05, in = kDepth - 0.01;
  const auto share = [step](int from, int to) { return std::clamp((step - from) / double(to - from), 0.0, 1.0); };
  const double z = above + (in - above) * (share(kDips, kDips + 100) - share(kLeaves, kLeaves + 100) +
                                           share(kArrives, kArrives + 100));
  const int begin = step < kArrives ? kDips : kArrives, end = step < kArrives ? kLeaves : kEnds;
  const double turn = 4e-3 * static_cast<double>(EIGEN_PI) * (std::clamp(step, begin, end) - begin);
  const double sway = 0.025 * std::sin(turn);
  return {kApart * share(kLeaves + 100, kArrives) + sway, 0, z};
}

struct Felt {
  std::vector<Vector3d> force;  // on the hand, in each step [N]
  std::uint32_t most_asleep = 0;
  double most_jump = 0;  // of the force from one step to the next [N]
};

Felt stir(Scene scene, std::optional<double> sleep_speed, std::optional<double> region = std::nullopt) {
  scene.config.numerics.sleep_speed = sleep_speed;
  scene.config.numerics.region_of_interest = region;
  const auto simulation = simulate(scene);
  StepInput input;
  input[0].engaged = true;
  input[0].gains = {2000, 40, 50, 1};
  Felt felt;
  for (int k = 0; k < kEnds; ++k) {
    input[0].state.position = hand_at(k);
    const StepOutput& out = simulation->step(input);
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) return felt;
    const Vector3d& force = out.proxies[0].force;
    if (!felt.force.empty()) felt.most_jump = std::max(felt.most_jump, (force - felt.force.back()).norm());
    felt.force.push_back(force);
    felt.most_asleep = std::max(felt.most_asleep, out.health.asleep);
  }
  return felt;
}

double rms(const std::vector<Vector3d>& a, int first, int end) {
  double sum = 0;
  for (int k = first; k < end; ++k) sum += a[std::size_t(k)].squaredNorm();
  return std::sqrt(sum / (end - first));
}

std::vector<Vector3d> difference(std::vector<Vector3d> a, const std::vector<Vector3d>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] -= b[k];
  return a;
}

Vector3d mean(const std::vector<Vector3d>& a, int first, int end) {
  return std::accumulate(a.begin() + first, a.begin() + end, Vector3d(0, 0, 0)) / (end - first);
}

// A thin fluid, and one whose viscosity is computed in stages.
class Sleep : public testing::TestWithParam<double> {};

// The second vessel sleeps while the first one is stirred. Once the hand dips into it, its particles begin from other
// places than without sleep, and where a fluid is stirred the least such difference grows until single values have
// nothing in common: then means count.
TEST_P(Sleep, IsNotFelt) {
  const Scene scene = two_vessels(GetParam());
  const Felt awake = stir(scene, std::nullopt), asleep = stir(scene, kSleepSpeed, kNear);
  ASSERT_EQ(awake.force.size(), asleep.force.size());
  EXPECT_EQ(awake.most_asleep, 0u);
  EXPECT_GT(asleep.most_asleep, scene.position.size() / 3);
  const std::vector<Vector3d> change = difference(asleep.force, awake.force);
  const double stirred = rms(change, 0, kLeaves) / rms(awake.force, 0, kLeaves);
  const double woken = mean(change, kArrives, kEnds).norm() / rms(awake.force, kArrives, kEnds);
  RecordProperty("while_stirring", std::to_string(stirred));
  RecordProperty("in_what_slept", std::to_string(woken));
  RecordProperty("jump", std::to_string(asleep.most_jump / awake.most_jump));
  EXPECT_TRUE(within(stirred, tol::kSleepStirred));
  EXPECT_TRUE(within(woken, tol::kSleepWoken));
  EXPECT_TRUE(within(asleep.most_jump / awake.most_jump - 1, tol::kSleepWoken));
}

INSTANTIATE_TEST_SUITE_P(Fluids, Sleep, testing::Values(0.05, 50.0), [](const testing::TestParamInfo<double>& fluid) {
  return fluid.param < 1 ? "thin" : "staged";
});

Scene one_vessel() {
  Scene scene = empty_scene(kSpacing, {-0.15, -0.15, -0.05}, {0.15, 0.15, 0.4});
  const auto fluid = add_material(scene, 1000, 0.05);
  add_tray(scene, fluid, {-kInner / 2, -kInner / 2, 0}, {kInner / 2, kInner / 2, 0.1}, kWall);
  add_body(scene, "fluid", BodyKind::fluid, fluid, {-kInner / 2, -kInner / 2, 0}, {kInner / 2, kInner / 2, kDepth});
  scene.config.numerics.sleep_speed = kSleepSpeed;
  return scene;
}

std::uint32_t asleep_after(Simulation& simulation, int steps) {
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(simulation.step({}).health.ok);
  return simulation.output().health.asleep;
}

TEST(SleepOfAVessel, ComesAndGoesWithGravity) {
  const Scene scene = one_vessel();
  const auto simulation = simulate(scene);
  EXPECT_EQ(asleep_after(*simulation, 100), 0u);
  EXPECT_EQ(asleep_after(*simulation, 1900), scene.position.size());
  EXPECT_EQ(simulation->output().health.kinetic_energy, 0);
  simulation->set_parameter("gravity", "1 0 -9.81");
  EXPECT_EQ(asleep_after(*simulation, 20), 0u);
  EXPECT_GT(simulation->output().health.kinetic_energy, 0);
  simulation->reset();
  EXPECT_EQ(asleep_after(*simulation, 100), 0u);
}

// The pressure on the ground of a sleeping vessel is that of its depth, and the fluid is where it was.
TEST(SleepOfAVessel, KeepsPlaceAndPressure) {
  const Scene scene = one_vessel();
  const auto simulation = simulate(scene);
  ASSERT_EQ(asleep_after(*simulation, 2000), scene.position.size());
  Snapshot before, after;
  simulation->snapshot(before);
  asleep_after(*simulation, 500);
  simulation->snapshot(after);
  EXPECT_EQ(before.position, after.position);
  EXPECT_EQ(before.pressure, after.pressure);
  double most = 0;
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (scene.bodies[scene.body[i]].type == BodyKind::fluid) most = std::max<double>(most, after.pressure[i]);
  const double depth = kDepth - kSpacing / 2;
  EXPECT_NEAR(most, 1000 * 9.81 * depth, 0.15 * 1000 * 9.81 * depth);
}

// A drop that is let go above a sleeping vessel falls as if nothing slept, and wakes what it meets.
TEST(SleepOfAVessel, IsBrokenByADrop) {
  Scene scene = one_vessel();
  scene.config.domain_max.z() = scene.bounds_max.z() = 6;
  add_body(scene, "drop", BodyKind::fluid, 0, {-0.025, -0.025, 5}, {0.025, 0.025, 5.05});
  scene.config.numerics.max_speed = 10;
  const auto simulation = simulate(scene);
  const std::uint32_t drop = scene.bodies.back().count;
  EXPECT_EQ(asleep_after(*simulation, 950), scene.position.size() - drop);
  Snapshot snapshot;
  simulation->snapshot(snapshot);
  const std::size_t first = scene.bodies.back().first;
  EXPECT_NEAR(snapshot.position[3 * first + 2], scene.position[first].z() - 0.5 * 9.81 * 0.95 * 0.95, 0.01);
  EXPECT_LT(asleep_after(*simulation, 150), scene.position.size() / 4);
}

// Without a sleep_speed fluid beyond the region of interest is held where it is, and within it all is computed.
TEST(SleepOfAVessel, IsAskedForFarFromTheHand) {
  Scene scene = two_vessels(0.05);
  scene.config.numerics.region_of_interest = kNear;
  const auto simulation = simulate(scene);
  StepInput input;
  input[0].engaged = true;
  input[0].gains = {2000, 40, 50, 1};
  input[0].state.position = {0, 0, kDepth};
  Snapshot at_first, before, after;
  simulation->snapshot(at_first);
  for (Snapshot* snapshot : {&before, &after}) {
    for (int k = 0; k < 300; ++k) ASSERT_TRUE(simulation->step(input).health.ok);
    simulation->snapshot(*snapshot);
  }
  bool moved_at_first = false, moved_near = false;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const bool far = scene.position[i].x() > kApart - kInner / 2;
    const bool moved = before.position[3 * i] != after.position[3 * i];
    ASSERT_FALSE(far && moved) << i;
    moved_near = moved_near || moved;
    moved_at_first = moved_at_first || (far && at_first.position[3 * i] != before.position[3 * i]);
  }
  EXPECT_TRUE(moved_near);
  EXPECT_TRUE(moved_at_first) << "until it had been out of the region for long enough";
}

TEST(SleepOfAVessel, IsTheSameAgain) {
  const Scene scene = two_vessels(0.05);
  const Felt first = stir(scene, kSleepSpeed), second = stir(scene, kSleepSpeed);
  EXPECT_GT(first.most_asleep, 0u);
  EXPECT_EQ(first.force, second.force);
}

// Two soft blocks on a floor, apart from each other, the second one bonded to it, and a ball in a hand above the first.
SceneConfig two_blocks(ElasticSolver solver) {
  SceneConfig config = contact_scene(0.02, 0.3, 0.2);
  add_soft(config, 100);
  BodyConfig block = at(body("block", BodyKind::elastic, box({0.1, 0.1, 0.1})), {-0.3, 0, 0.05});
  block.material = "soft";
  BodyConfig bonded = at(block, {0.3, 0, 0.05});
  bonded.name = "bonded";
  bonded.bonded_to = {"foot"};
  config.bodies = {at(body("floor", BodyKind::fixed, box({0.3, 0.3, 0.04})), {-0.3, 0, -0.02}),
                   at(body("foot", BodyKind::fixed, box({0.16, 0.16, 0.12})), {0.3, 0, -0.06}), block, bonded,
                   at(body("tool", BodyKind::rigid, sphere(0.04)), {-0.3, 0, 0.2})};
  ProxyConfig proxy;
  proxy.body = "tool";
  config.proxies.push_back(proxy);
  config.probes = {probe_of("foot")};
  config.numerics.elastic_solver = solver;
  config.numerics.solid_particles = true;  // those of the foot, too, that are out of reach of the bonds
  return config;
}

struct Pressed {
  std::vector<Vector3d> force;                 // on the hand, in each step [N]
  std::vector<double> foot;                    // force along z on the foot [N]
  std::uint32_t most_asleep = 0, of_foot = 0;  // particles: that sleep, that the foot has
};

// Presses the ball 1 cm into the first block from 0.5 to 1 s, then into the second one, which has slept.
Pressed press(SceneConfig config, std::optional<double> sleep_speed) {
  config.numerics.sleep_speed = sleep_speed;
  const Scene scene = sampled(config);
  const auto simulation = simulate(scene);
  StepInput input;
  input[0].engaged = true;
  input[0].gains = {20000, 200, 10, 0.2};
  Pressed pressed;
  pressed.of_foot = scene.bodies[1].count;
  for (int k = 0; k < 2000; ++k) {
    const auto share = [k](int from, int to) { return std::clamp((k - from) / double(to - from), 0.0, 1.0); };
    const double down = share(500, 700) - share(1000, 1100) + share(1500, 1700);
    input[0].state.position = {-0.3 + 0.6 * share(1200, 1400), 0, 0.2 - 0.07 * down};
    const StepOutput& out = simulation->step(input);
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) return pressed;
    pressed.force.push_back(out.proxies[0].force);
    pressed.foot.push_back(out.bodies[1].force.z());
    pressed.most_asleep = std::max(pressed.most_asleep, out.health.asleep);
  }
  return pressed;
}

// alone: there is only the second block, so that no neighbours are listed.
struct Blocks {
  const char* name;
  ElasticSolver solver;
  bool alone;
};
class SleepOfBlocks : public testing::TestWithParam<Blocks> {};

TEST_P(SleepOfBlocks, IsNotFelt) {
  SceneConfig config = two_blocks(GetParam().solver);
  if (GetParam().alone) config.bodies.erase(config.bodies.begin() + 2);
  const Pressed awake = press(config, std::nullopt), asleep = press(config, kSleepSpeed);
  ASSERT_EQ(awake.force.size(), asleep.force.size());
  ASSERT_EQ(awake.force.size(), 2000u);
  EXPECT_EQ(awake.most_asleep, 0u);
  EXPECT_EQ(asleep.of_foot, 8u * 8 * 6);
  EXPECT_GE(asleep.most_asleep, GetParam().alone ? 125 : 125 + asleep.of_foot);  // with neighbour lists all of the foot
  const double change = rms(difference(asleep.force, awake.force), 0, 2000) / rms(awake.force, 0, 2000);
  RecordProperty("change", std::to_string(change));
  EXPECT_GT(rms(awake.force, 1700, 2000), 5);
  EXPECT_TRUE(within(change, tol::kSleepStirred));
  double most = 0;
  for (std::size_t k = 0; k < 2000; ++k) most = std::max(most, std::abs(asleep.foot[k] - awake.foot[k]));
  const double scale = *std::max_element(awake.foot.begin(), awake.foot.end(),
                                         [](double a, double b) { return std::abs(a) < std::abs(b); });
  RecordProperty("foot", std::to_string(most / std::abs(scale)));
  EXPECT_TRUE(within(most / scale, tol::kSleepFoot));
}

// Whatever is changed wakes all, and nothing is thrown about by that.
TEST_P(SleepOfBlocks, EndsGentlyWithAChange) {
  SceneConfig config = two_blocks(GetParam().solver);
  if (GetParam().alone) config.bodies.erase(config.bodies.begin() + 2);
  config.numerics.sleep_speed = kSleepSpeed;
  const auto simulation = simulate(sampled(config));
  EXPECT_GT(asleep_after(*simulation, 800), 0u);
  const double weight = simulation->output().bodies[1].force.z();
  // a block that lies on the floor touches it in every other step of an implicit solve, too fast to sleep
  double usual = kSleepSpeed;
  for (int k = 0; k < 20; ++k) usual = std::max(usual, simulation->step({}).health.max_speed);
  simulation->set_parameter("gravity", "0 0 -9.81");
  bool woken = false;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(simulation->step({}).health.ok);
    woken = woken || simulation->output().health.asleep == 0;
    ASSERT_LT(simulation->output().health.max_speed, 1.05 * usual) << k;
    ASSERT_NEAR(simulation->output().bodies[1].force.z(), weight, 0.01 * std::abs(weight)) << k;
  }
  EXPECT_TRUE(woken);
}

INSTANTIATE_TEST_SUITE_P(All, SleepOfBlocks,
                         testing::Values(Blocks{"explicit", ElasticSolver::explicit_, false},
                                         Blocks{"implicit", ElasticSolver::implicit, false},
                                         Blocks{"explicit_alone", ElasticSolver::explicit_, true},
                                         Blocks{"implicit_alone", ElasticSolver::implicit, true}),
                         [](const testing::TestParamInfo<Blocks>& blocks) { return blocks.param.name; });

}  // namespace
}  // namespace palp::test::sleep_test
