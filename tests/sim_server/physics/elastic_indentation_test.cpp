// A rigid ball that a hand presses into a bonded elastic layer. The reference is a finite-element solution of the same
// material at finite strain (axisymmetric, nine nodes an element, double precision), which at small strain agrees with
// the integral equation of a layer under a ball (Lebedev & Ufliand 1958) within 0.1 %.
#include "tests/sim_server/physics/contact_scenes.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::elastic_indentation_test {
namespace {

constexpr double kSpacing = 0.01, kYoung = 1e4, kStiff = 1000;  // [m], [Pa], of the hand [N/m]

// Lengths in spacings; the force in kYoung kSpacing^2. x, y: where the ball is, from a corner of four cells.
struct Ball {
  double radius, layer, poisson, depth, force;
  double x = 0, y = 0;
};

SceneConfig scene_of(const Ball& ball, ElasticSolver solver, std::optional<int> sub_steps) {
  SceneConfig config = contact_scene(kSpacing, 0, 0.2);
  config.gravity.setZero();
  config.numerics.elastic_solver = solver;
  config.numerics.sub_steps = sub_steps;
  MaterialConfig soft = config.materials[0];
  soft.name = "soft";
  soft.young_modulus = kYoung;
  soft.poisson_ratio = ball.poisson;
  soft.damping = 15;
  config.materials.push_back(soft);
  const double width = 2 * kSpacing * (ball.layer + ball.radius), high = ball.layer * kSpacing;
  config.bodies = {at(body("floor", BodyKind::fixed, box({width, width, 3 * kSpacing})), {0, 0, -1.5 * kSpacing}),
                   at(body("layer", BodyKind::elastic, box({width, width, high})), {0, 0, high / 2}),
                   at(body("ball", BodyKind::rigid, sphere(ball.radius * kSpacing)),
                      {ball.x * kSpacing, ball.y * kSpacing, high + ball.radius * kSpacing})};
  config.bodies[1].material = "soft";
  config.bodies[1].bonded_to = {"floor"};
  ProxyConfig proxy;
  proxy.body = "ball";
  config.proxies.push_back(proxy);
  config.probes.push_back(probe_of("floor"));
  return config;
}

struct Pressed {
  double force, carried;  // at the depth of the reference; what the floor bears over what the ball feels
};

Pressed press(const Ball& ball, ElasticSolver solver, std::optional<int> sub_steps = {}) {
  const auto simulation = simulate(sampled(scene_of(ball, solver, sub_steps)));
  const double top = (ball.layer + ball.radius) * kSpacing, unit = kYoung * kSpacing * kSpacing;
  const double down = ball.depth * kSpacing + ball.force * unit / kStiff;
  StepInput input;
  input[0].engaged = true;
  input[0].gains = {kStiff, 50, 10, 0.2};
  for (int k = 0; k < 600; ++k) {  // a ball of ten spacings swings in the hand for half a second
    input[0].state.position = {ball.x * kSpacing, ball.y * kSpacing, top - down * std::min(1.0, k / 120.0)};
    const StepOutput& out = simulation->step(input);
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) break;
  }
  const StepOutput& out = simulation->output();
  const double felt = out.proxies[0].contact_force.z();
  const double depth = (top - out.proxies[0].state.position.z()) / kSpacing;
  return {felt / unit * std::pow(ball.depth / depth, 1.5), -out.bodies[0].force.z() / felt};
}

// Beneath a ball of two spacings that comes down over a particle it is one particle that bears most.
constexpr const char* kOneParticle = "a ball of two spacings over a particle touches little else";

void judge(const Ball& ball, ElasticSolver solver, const Pressed& found) {
  const std::string how = solver == ElasticSolver::implicit ? "implicit" : "explicit";
  EXPECT_TRUE(
      within(found.force / ball.force - 1, tol::kBallOnLayer,
             {"ball, R = " + quantity(ball.radius, "dx") + ", on a bonded layer of " + quantity(ball.layer, "dx") +
                  ", nu = " + quantity(ball.poisson, "") + ", over a " + (ball.x > 0 ? "particle, " : "corner, ") + how,
              "finite elements, " + quantity(ball.force, "E dx^2"), quantity(found.force, "E dx^2"), Method::accurate,
              nullptr, ball.radius <= 2 && ball.x > 0 ? kOneParticle : nullptr}));
  EXPECT_TRUE(within(found.carried - 1, tol::kReactionOfFloor)) << how;
}

constexpr Ball kOverACorner{4, 4, 0.3, 0.5, 1.4057};

// Wherever it comes down between particles, and whichever solver computes the layer; the floor bears what it feels.
TEST(ElasticIndentation, ABallFeelsALayer) {
  Ball over_a_particle = kOverACorner;
  over_a_particle.x = over_a_particle.y = 0.5;
  judge(kOverACorner, ElasticSolver::explicit_, press(kOverACorner, ElasticSolver::explicit_));
  judge(over_a_particle, ElasticSolver::implicit, press(over_a_particle, ElasticSolver::implicit));
  if (!validating()) return;
  judge(kOverACorner, ElasticSolver::implicit, press(kOverACorner, ElasticSolver::implicit));
  judge(over_a_particle, ElasticSolver::explicit_, press(over_a_particle, ElasticSolver::explicit_));
}

// Other balls, layers and materials, over a corner and over a particle, by either solver.
TEST(ElasticIndentation, ABallFeelsOtherLayers) {
  if (!validating()) GTEST_SKIP() << "minutes on a CPU; under tools/validate";
  for (Ball ball : {Ball{6, 4, 0.3, 0.4, 1.3113}, Ball{6, 8, 0.3, 0.8, 3.1899}, Ball{2, 4, 0.45, 0.32, 0.4689},
                    Ball{3, 6, 0.45, 0.48, 1.0550}, Ball{4, 8, 0.45, 0.64, 1.8756}, Ball{10, 5, 0.45, 0.5, 3.0351}})
    for (const double place : {0.0, 0.5})
      for (const ElasticSolver solver : {ElasticSolver::explicit_, ElasticSolver::implicit}) {
        ball.x = ball.y = place;
        judge(ball, solver, press(ball, solver));
      }
}

// Contact is a spring of the matter itself, so a shorter sub-step changes nothing.
TEST(ElasticIndentation, TheForceDoesNotFollowTheSubStep) {
  const auto follows = [](ElasticSolver solver, int few, int many) {
    const double change = press(kOverACorner, solver, many).force / press(kOverACorner, solver, few).force - 1;
    EXPECT_TRUE(within(change, tol::kForceBySubStep)) << few << " and " << many << " sub-steps";
  };
  follows(ElasticSolver::explicit_, 5, 10);
  if (!validating()) return;
  follows(ElasticSolver::explicit_, 5, 20);
  follows(ElasticSolver::implicit, 3, 6);
  follows(ElasticSolver::implicit, 3, 12);
}

}  // namespace
}  // namespace palp::test::elastic_indentation_test
