// Neighbour lists that are kept while particles move give what lists made at each sub-step give.
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/random_scene.h"
#include "tests/support/tolerance.h"

namespace palp::test::neighbor_lists_test {
namespace {

struct Case {
  const char* name;
  Method method;
  std::array<bool, 3> periodic;
  double speed;  // that water and oil have past each other, in spacings a sub-step
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class KeptLists : public ::testing::TestWithParam<Case> {};

constexpr int kSteps = 12, kSubSteps = 4;

Scene make_scene(const Case& c) {
  Random random(7);
  RandomSceneOptions options;
  options.method = c.method;
  options.periodic = c.periodic;
  Scene scene = random_scene(random, options);
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const double v = 0.5 * c.speed * scene.spacing * scene.config.rate_hz;
    const std::string& name = scene.bodies[scene.body[i]].name;
    if (name == "water") scene.velocity[i].x() += v;
    if (name == "oil") scene.velocity[i].x() -= v;
  }
  return scene;
}

StepInput make_input(const Scene& scene) {
  Random random(8);
  return random_input(random, scene);
}

void run(Simulation& simulation, const StepInput& input, int steps, Snapshot& end) {
  for (int k = 0; k < steps; ++k) {
    const StepOutput& out = simulation.step(input);
    ASSERT_TRUE(out.health.ok) << out.health.cause;
  }
  simulation.snapshot(end);
}

double difference(const std::vector<float>& a, const std::vector<float>& b) {
  double worst = 0, scale = 1e-30;
  for (std::size_t i = 0; i < a.size(); ++i) {
    worst = std::max(worst, std::abs(double(a[i]) - b[i]));
    scale = std::max(scale, std::abs(double(a[i])));
  }
  return a.size() == b.size() ? worst / scale : 1e30;
}

// Like difference, the nearest image taken along periodic axes.
double position_difference(const Scene& scene, const Snapshot& a, const Snapshot& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.position.size(); ++i) {
    const auto axis = static_cast<int>(i % 3);
    const double period = scene.bounds_max[axis] - scene.bounds_min[axis];
    double d = double(a.position[i]) - b.position[i];
    if (scene.config.periodic[i % 3]) d -= period * std::round(d / period);
    worst = std::max(worst, std::abs(d));
  }
  return worst;
}

// With one sub-step a step and a parameter set before it, new lists are made for each sub-step.
TEST_P(KeptLists, GiveWhatNewListsGive) {
  Scene scene = make_scene(GetParam());
  const StepInput input = make_input(scene);
  const auto fresh = simulate(scene);
  Snapshot expected, actual;
  for (int k = 0; k < kSteps * kSubSteps; ++k) {
    fresh->set_parameter("body_force", "0.2 0 0");
    ASSERT_NO_FATAL_FAILURE(run(*fresh, input, 1, expected));
  }
  const auto kept = simulate(scene);
  ASSERT_NO_FATAL_FAILURE(run(*kept, input, kSteps * kSubSteps, actual));
  EXPECT_TRUE(within(position_difference(scene, expected, actual), tol::kManySteps));
  EXPECT_TRUE(within(difference(expected.velocity, actual.velocity), tol::kManySteps));
  EXPECT_TRUE(within(difference(expected.pressure, actual.pressure), tol::kManySteps));
}

TEST_P(KeptLists, GiveTheSameBitsEachTime) {
  Scene scene = make_scene(GetParam());
  scene.config.rate_hz /= kSubSteps;
  scene.config.numerics.sub_steps = kSubSteps;
  const StepInput input = make_input(scene);
  const auto one = simulate(scene), other = simulate(scene);
  Snapshot first, second, again;
  ASSERT_NO_FATAL_FAILURE(run(*one, input, kSteps, first));
  ASSERT_NO_FATAL_FAILURE(run(*other, input, kSteps, second));
  one->reset();
  ASSERT_NO_FATAL_FAILURE(run(*one, input, kSteps, again));
  for (const Snapshot* s : {&second, &again}) {
    EXPECT_EQ(first.position, s->position);
    EXPECT_EQ(first.velocity, s->velocity);
    EXPECT_EQ(first.pressure, s->pressure);
  }
}

// Lists that reach farther serve longer: they change no result but by the order of its sums.
TEST_P(KeptLists, GiveTheSameWithAnySkin) {
  Scene scene = make_scene(GetParam());
  const StepInput input = make_input(scene);
  Snapshot expected, actual;
  ASSERT_NO_FATAL_FAILURE(run(*simulate(scene), input, kSteps * kSubSteps, expected));
  for (const double skin : {0.02, 0.6}) {
    scene.config.numerics.skin_over_spacing = skin;
    ASSERT_NO_FATAL_FAILURE(run(*simulate(scene), input, kSteps * kSubSteps, actual));
    EXPECT_TRUE(within(position_difference(scene, expected, actual), tol::kManySteps)) << skin;
    EXPECT_TRUE(within(difference(expected.velocity, actual.velocity), tol::kManySteps)) << skin;
    EXPECT_TRUE(within(difference(expected.pressure, actual.pressure), tol::kManySteps)) << skin;
  }
}

// At eight times its density a fluid has more neighbours than the GPU's lists have room for; the CPU's grow.
TEST(Lists, WithoutRoomAreReported) {
  Scene scene = empty_scene(0.1, {0, 0, 0}, {1, 1, 1});
  scene.config.gravity.setZero();
  add_material(scene, 1000, 1e-3);
  scene.spacing = 0.05;
  add_body(scene, "water", BodyKind::fluid, 0, {0.3, 0.3, 0.3}, {0.7, 0.7, 0.7});
  scene.spacing = 0.1;
  const auto simulation = simulate(scene);
  for (int k = 0; k < 2; ++k) {
    const Health& health = simulation->step({}).health;
    EXPECT_EQ(health.ok, tested_backend() == Backend::cpu) << health.cause;
    EXPECT_EQ(health.cause.find("crowded") != std::string::npos, tested_backend() == Backend::cuda) << health.cause;
  }
}

INSTANTIATE_TEST_SUITE_P(Flows, KeptLists,
                         ::testing::Values(Case{"still", Method::accurate, {false, false, false}, 0},
                                           Case{"fast", Method::accurate, {true, true, false}, 0.08},
                                           Case{"faster", Method::accurate, {true, false, false}, 0.2},
                                           Case{"paper", Method::paper, {true, true, true}, 0.08}),
                         [](const auto& param) { return std::string(param.param.name); });

}  // namespace
}  // namespace palp::test::neighbor_lists_test
