// One and a few sub-steps of random scenes against the equations restated in tests/support/equations.h.
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/equations.h"
#include "tests/support/random_scene.h"
#include "tests/support/seed.h"
#include "tests/support/tolerance.h"

namespace palp::test::equations_test {
namespace {

struct Case {
  const char* name;
  Method method;
  std::array<bool, 3> periodic;
  bool engaged;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

Eigen::Vector3d vector_at(const std::vector<float>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

// Largest differences over all particles: positions relative to the spacing, velocities to the largest change,
// pressures to the largest, densities to themselves.
struct Residuals {
  double position = 0, velocity = 0, pressure = 0, density = 0;
};

Residuals compare(const Restated& w, const Snapshot& s) {
  Residuals r;
  r.position = places_apart(w, s);
  double v_scale = 0, p_scale = 1e-3;
  for (std::size_t i = 0; i < w.x.size(); ++i) {
    v_scale = std::max(v_scale, (w.v[i] - w.scene->velocity[i]).norm());
    p_scale = std::max(p_scale, std::abs(w.p[i]));
  }
  for (std::size_t i = 0; i < w.x.size(); ++i) {
    const Body& body = w.scene->bodies[w.scene->body[i]];
    r.velocity = std::max(r.velocity, (vector_at(s.velocity, i) - w.v[i]).norm() / v_scale);
    if (body.type != BodyKind::fluid) continue;
    const double acting = w.plan.tension ? w.p[i] : std::max(0.0, w.p[i]);
    r.pressure = std::max(r.pressure, std::abs(s.pressure[i] - acting) / p_scale);
    r.density = std::max(r.density, std::abs(s.density[i] / density_of(w, i) - 1));
  }
  return r;
}

void expect_bodies_agree(const Restated& w, const StepOutput& out) {
  double force_scale = 1e-6, torque_scale = 1e-6;
  for (const RestatedBody& b : w.body) {
    force_scale = std::max(force_scale, b.force_size);
    torque_scale = std::max(torque_scale, b.torque_size);
  }
  for (std::size_t k = 0; k < w.body.size(); ++k) {
    const Body& body = w.scene->bodies[k];
    if (body.type == BodyKind::fluid) continue;
    SCOPED_TRACE("body " + body.name);
    const RestatedBody& b = w.body[k];
    const BodyOutput& o = out.bodies[k];
    EXPECT_TRUE(within((o.state.position + o.state.orientation * body.center - b.x).norm(), tol::kBodyState));
    EXPECT_TRUE(within(o.state.orientation.angularDistance(b.q), tol::kBodyState));
    EXPECT_TRUE(within((o.state.linear + o.state.angular.cross(o.state.orientation * body.center) - b.v).norm(),
                       tol::kBodyWrench));
    EXPECT_TRUE(within((o.state.angular - b.w).norm(), tol::kBodyWrench));
    EXPECT_TRUE(within((o.force - b.force).norm() / force_scale, tol::kBodyWrench));
    EXPECT_TRUE(within((o.torque - b.torque).norm() / torque_scale, tol::kBodyWrench));
  }
}

void expect_proxy_agrees(const Restated& w, const StepOutput& out, const StepInput& input) {
  const RestatedBody& b = w.body[w.scene->proxies[0].body];
  const RigidState handle = handle_of(w, 0);
  const ProxyOutput& o = out.proxies[0];
  EXPECT_TRUE(within((o.state.position - handle.position).norm(), tol::kBodyState));
  EXPECT_TRUE(within((o.state.linear - handle.linear).norm(), tol::kBodyWrench));
  EXPECT_TRUE(within((o.contact_force - b.force).norm() / (1 + b.force_size), tol::kBodyWrench));
  if (!input[0].engaged) {
    EXPECT_EQ(o.force.norm(), 0);
    return;
  }
  const double dt = 1 / w.scene->config.rate_hz;
  const Eigen::Vector3d at_end =
      input[0].gains.stiffness * (handle.position - input[0].state.position - dt * input[0].state.linear) +
      input[0].gains.damping * (handle.linear - input[0].state.linear);
  // what a contact answers is of the states at the end of the step; of all else the device gets the mean
  const Eigen::Vector3d expected = o.blend[0] * at_end - (1 - o.blend[0]) * b.coupling;
  EXPECT_TRUE(within((o.force - expected).norm() / expected.norm(), tol::kBodyWrench));
  // the work is of the way that the tool's place goes, which is rounded (proxy.h)
  const double rounding[] = {b.work_rounding, 0};
  for (std::size_t k = 0; k < 2; ++k) {
    const double error = std::max(0.0, std::abs(o.energy[k] - b.work[k]) - rounding[k]);
    EXPECT_TRUE(within(error / (1e-3 + b.work_size[k]), tol::kBodyWrench));
  }
}

RandomSceneOptions options_of(const Case& c) {
  RandomSceneOptions options;
  options.method = c.method;
  options.periodic = c.periodic;
  return options;
}

class Equations : public ::testing::TestWithParam<Case> {};

void expect_equations_hold(const Scene& scene, const StepInput& input) {
  const auto simulation = simulate(scene);
  Restated world = restate(scene);
  ASSERT_EQ(world.plan.sub_steps, 1);
  Snapshot snapshot;
  simulation->snapshot(snapshot);
  const Residuals start = compare(world, snapshot);
  EXPECT_TRUE(within(start.pressure, tol::kOneStep));
  for (int step = 1; step <= 4; ++step) {
    const StepOutput& out = simulation->step(input);
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    sub_step(world, input, world.plan.dt);
    simulation->snapshot(snapshot);
    const Residuals r = compare(world, snapshot);
    const Tolerance& tolerance = step == 1 ? tol::kOneStep : tol::kFewSteps;
    SCOPED_TRACE("step " + std::to_string(step));
    EXPECT_TRUE(within(r.position, tolerance));
    EXPECT_TRUE(within(r.velocity, tolerance));
    EXPECT_TRUE(within(r.pressure, tolerance));
    EXPECT_TRUE(within(r.density, tolerance));
    expect_bodies_agree(world, out);
    if (!scene.proxies.empty()) expect_proxy_agrees(world, out, input);
  }
}

TEST_P(Equations, HoldOnRandomScenes) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const Scene scene = random_scene(random, options_of(GetParam()));
  StepInput input = random_input(random, scene);
  input[0].engaged = GetParam().engaged;
  expect_equations_hold(scene, input);
}

// Most particles have few neighbours, or none.
TEST_P(Equations, HoldInASpray) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  RandomSceneOptions options = options_of(GetParam());
  options.spray = 0.85;
  options.solids = false;
  Scene scene = random_scene(random, options);
  scene.config.gravity.setZero();  // a spray has no pressure to start with
  scene.config.body_force.setZero();
  expect_equations_hold(scene, {});
}

// Particles outside the domain are all in its outermost cells, far from where those lie, and act on each other still,
// up to a support radius past it, where liquid becomes inactive (outside_test.cpp).
TEST_P(Equations, HoldBeyondTheDomain) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  RandomSceneOptions options = options_of(GetParam());
  Scene scene = random_scene(random, options);
  StepInput input = random_input(random, scene);
  input[0].engaged = GetParam().engaged;
  for (int a = 0; a < 3; ++a) {
    if (options.periodic[static_cast<std::size_t>(a)]) continue;
    scene.bounds_min[a] += uniform(random, 0.1, 0.25);
    scene.bounds_max[a] -= uniform(random, 0.1, 0.25);
  }
  expect_equations_hold(scene, input);
}

// Long enough, and fast enough, that particles change their neighbours many times over.
TEST_P(Equations, HoldWhileNeighborsChange) {
  Random random(99);
  Scene scene = random_scene(random, options_of(GetParam()));
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const std::string& name = scene.bodies[scene.body[i]].name;
    if (name == "water") scene.velocity[i] += Eigen::Vector3d(1.5, 1, 0);
    if (name == "oil") scene.velocity[i] += Eigen::Vector3d(-2.5, 1, 0);
  }
  StepInput input = random_input(random, scene);
  input[0].engaged = GetParam().engaged;
  const auto simulation = simulate(scene);
  Restated world = restate(scene);
  for (int step = 1; step <= 40; ++step) {
    const StepOutput& out = simulation->step(input);
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    sub_step(world, input, world.plan.dt);
  }
  Snapshot snapshot;
  simulation->snapshot(snapshot);
  const Residuals r = compare(world, snapshot);
  EXPECT_TRUE(within(r.position, tol::kManySteps));
  EXPECT_TRUE(within(r.velocity, tol::kManySteps));
  EXPECT_TRUE(within(r.pressure, tol::kManySteps));
}

INSTANTIATE_TEST_SUITE_P(Methods, Equations,
                         ::testing::Values(Case{"accurate_closed", Method::accurate, {false, false, false}, true},
                                           Case{"accurate_periodic", Method::accurate, {true, true, false}, true},
                                           Case{"accurate_without_hand", Method::accurate, {true, false, false}, false},
                                           Case{"paper_closed", Method::paper, {false, false, false}, true},
                                           Case{"paper_periodic", Method::paper, {true, true, true}, true}),
                         [](const auto& param) { return std::string(param.param.name); });

}  // namespace
}  // namespace palp::test::equations_test
