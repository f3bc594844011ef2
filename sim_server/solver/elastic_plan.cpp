#include "sim_server/solver/elastic_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include "config/error.h"
#include "sim_server/physics/elastic_contact.h"
#include "sim_server/solver/body_bounds.h"
#include "sim_server/solver/constants.h"
#include "sim_server/solver/elastic_limit.h"
#include "sim_server/solver/elastic_stencil.h"
#include "sim_server/solver/sub_steps.h"

namespace palp {
namespace {

constexpr double kMaxRounds = 1000;
// The share of the energy norm of its start that a solve leaves at most, by the bound of conjugate gradients. A clamped
// bar, where the bound is hard to beat, took 0.9 of these rounds to its last digit.
constexpr double kLeft = 1e-2;
// The costs of an explicit sub-step, of an implicit one without its rounds, and of a round, in passes over the elastic
// bodies' neighbours, as measured (tools/results/README.md).
constexpr double kExplicit = 2, kImplicit = 4, kRound = 1;
// The least saving for which an implicit solve is chosen: explicit sub-steps follow the waves that it damps.
constexpr double kWorth = 1.5;

// Returns why the scene cannot have an implicit solve; empty where it can.
std::string obstacle_of(const Scene& scene, const Plan& plan) {
  if (plan.method == Method::paper) return "method \"paper\" has no implicit solve";
  for (const std::uint32_t b : plan.elastic_bodies) {
    const Body& body = scene.bodies[b];
    const MaterialConfig& m = scene.config.materials[body.material];
    if (m.yield_stress) return fmt::format("body '{}' yields", body.name);
    if (m.tear_strain) return fmt::format("body '{}' tears", body.name);
    for (const std::uint32_t other : body.bonded_to)
      if (scene.bodies[other].type == BodyKind::rigid)
        return fmt::format("body '{}' is bonded to '{}', which moves", body.name, scene.bodies[other].name);
  }
  return "";
}

// Returns the extents of a box of the same spread as a body's particles, longest first.
Eigen::Vector3d extents(const Scene& scene, const Body& body) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i) middle += scene.position[i] / body.count;
  for (std::uint32_t i = body.first; i < body.first + body.count; ++i) {
    const Eigen::Vector3d r = scene.position[i] - middle;
    spread += r * r.transpose() / body.count;
  }
  const Eigen::Vector3d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues();
  Eigen::Vector3d out;
  for (int a = 0; a < 3; ++a) out[a] = std::sqrt(12 * std::max(0.0, values[2 - a]) + scene.spacing * scene.spacing);
  return out;
}

// Bodies of up to so many particles are looked at particle by particle, larger ones as a small block of their
// thickness, whose corners are like theirs.
constexpr std::uint32_t kLookedAt = 500;
// The share of the limit with free surfaces that a sub-step may use, whatever numerics.safety. That limit is exact, so
// rounding and contact are all that it leaves room for.
constexpr double kMostOfFree = 0.9;
// The share of its limit that is left to a large body read from a file, whose disorder is not looked at (a jitter of
// 0.15 spacings takes off 0.14).
constexpr double kDisordered = 0.8;

// Returns the largest stable sub-step of a body with its free surfaces [s].
double free_limit(const Scene& scene, const Plan& plan, const Body& body) {
  const MaterialConfig& m = scene.config.materials[body.material];
  const double dx = scene.spacing, ratio = plan.elastic_support / dx;
  const double unit = dx / pressure_wave_speed(m);
  const bool balanced = takes_balanced_bonds(m);
  std::vector<Eigen::Vector3d> points;
  if (body.count <= kLookedAt) {
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) points.push_back(scene.position[i] / dx);
    return unit * free_elastic_limit(points, ratio, m.poisson_ratio, balanced);
  }
  const Eigen::Vector3i n = (extents(scene, body) / dx).array().round().cast<int>().max(1).min(6);
  const auto index = static_cast<std::size_t>(&body - scene.bodies.data());
  const auto& from = scene.config.bodies;  // none, where a scene was not read from a file
  const bool loose =
      index < from.size() && !from[index].shapes.empty() && from[index].shapes.front().type == ShapeType::particles;
  return unit * (loose ? kDisordered : 1) * free_elastic_limit(lattice_block(n), ratio, m.poisson_ratio, balanced);
}

// Returns the frequency of a body's slowest vibration, as of a beam: free, or clamped at one end [rad/s].
double slowest(const Scene& scene, const Body& body) {
  const MaterialConfig& m = scene.config.materials[body.material];
  const Eigen::Vector3d L = extents(scene, body);
  const double c = std::sqrt(*m.young_modulus / m.density);
  const double bending = (body.bonded_to.empty() ? 6.46 : 1.015) * c * L.z() / (L.x() * L.x());
  return std::min(bending, 1.3 * c / L.x());
}

// Returns the square root of the solve's condition number, rigid motion left out, which takes no rounds.
double root_condition(const Scene& scene, const Plan& plan, double dt) {
  // longer kernels have no longer gradients: all that is solved implicitly has balanced bonds (elastic_stencil.h)
  const double ratio = std::min(plan.elastic_support / scene.spacing, 2.0);
  double worst = 1;
  for (const std::uint32_t b : plan.elastic_bodies) {
    const Body& body = scene.bodies[b];
    const double waves = dt * pressure_wave_speed(scene.config.materials[body.material]) / scene.spacing;
    // the face that touches is as heavy to the solve as contact is stiff
    const double layers = extents(scene, body).z() / scene.spacing;
    const double heavier = plan.fields ? std::sqrt(1 + contact_stiffness(waves, 0.0) / layers) : 1;
    worst = std::max(
        worst, std::hypot(1, 2 * waves / elastic_limit(ratio)) / std::hypot(1, slowest(scene, body) * dt / heavier));
  }
  return worst;
}

// Returns the largest sub-step of an implicit solve [s]. Velocities are off by the rounding of a strain, times the
// square of the time that waves take to cross a spacing: by eps c^2 dt / dx. Where that came near a spacing a sub-step,
// blocks at rest burst (at 1e12 Pa and 0.9 of this limit after 50 steps, at 0.45 never). Contact takes only what
// pushes, so what lies on a fixed body is thrown off it at about kThrown of that speed (0.2 to 0.45 of it, blocks of
// 1e10 to 5e12 Pa in 1 to 29 sub-steps); at 0.57 m/s one leapt by 16 mm.
StepLimit limit_by_rounding(const Scene& scene, const Plan& plan) {
  constexpr double kMostRounding = 0.1, kMostThrown = 0.5 /* m/s */, kThrown = 0.4;
  constexpr double epsilon = std::numeric_limits<real>::epsilon();
  StepLimit least;
  for (const std::uint32_t b : plan.elastic_bodies) {
    const MaterialConfig& m = scene.config.materials[scene.bodies[b].material];
    const double c = pressure_wave_speed(m);
    double waves = std::sqrt(kMostRounding / epsilon);
    if (plan.fields) waves = std::min(waves, kMostThrown / (kThrown * epsilon * c));
    const double dt = waves * scene.spacing / c;
    if (dt < least.dt) least = {dt, "rounding", fmt::format("material '{}'", m.name), ""};
  }
  return least;
}

// Returns the share of its sub-step at rest that a body needs once it has flowed. Matter that a tool has flattened to
// less than half its thickness needs less than half of it. What its own weight makes flow flattens as a whole, as far
// as matter flows (kMaxFlow), and the softer it is the further that weight then compresses it. The shares at which
// blocks diverged, by their strain under weight: 0.26 at 0.03, 0.22 at 0.1 and 0.2, 0.15 at 0.3, 0.13 at 0.7 to 3; with
// a weight of less than 1.8 times the yield stress 0.4 held.
double left_of_flow(const Scene& scene, const Body& body) {
  constexpr double kFlattened = 0.4, kFlows = 1.5, kFlowed = 0.2, kLeast = 0.12;
  const MaterialConfig& m = scene.config.materials[body.material];
  const double strain = strain_under_weight(scene, body);
  if (strain * *m.young_modulus < kFlows * *m.yield_stress) return kFlattened;
  return std::max(kLeast, kFlowed * (1 - strain));
}

// Returns the limit of a sub-step under stiffness and damping together, each of which has its own: symplectic Euler is
// stable while (dt / waves)^2 + dt / damped < 1.
double with_damping(double waves, double damped) {
  const double half = waves / (2 * damped);
  return waves * (std::hypot(half, 1) - half);
}

}  // namespace

double strain_under_weight(const Scene& scene, const Body& body) {
  const MaterialConfig& m = scene.config.materials[body.material];
  const Eigen::Vector3d size = body_bounds(scene, body).sizes().array() + scene.spacing;
  return m.density * scene.config.gravity.cwiseAbs().dot(size) / *m.young_modulus;
}

std::vector<StepLimit> limits_by_elasticity(const Scene& scene, const Plan& plan, bool changing) {
  const double dx = scene.spacing, ratio = (changing ? plan.change_support : plan.elastic_support) / dx;
  StepLimit by_waves, by_damping;
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    if (plan.changes[b] != changing || (!changing && scene.bodies[b].type != BodyKind::elastic)) continue;
    const MaterialConfig& m = scene.config.materials[scene.bodies[b].material];
    // neighbourhoods that are torn are stiffer than whole ones: a sheet that was pierced at 0.42 of this limit
    // diverged, at 0.21 it did not
    double left = m.yield_stress ? left_of_flow(scene, scene.bodies[b]) : m.tear_strain ? 0.5 : 1;
    // Matter that froze in disorder is stiffer than a lattice. Splashes that freeze at once
    // (tests/sim_server/physics/state_change_motion_test.cpp) held up to 0.29 to 0.30 of a lattice's limit at 1e5 and
    // 1e6 Pa, and diverged at 0.31 and 0.32. The fluid's stiffness does not add to that: bonds get the share of a
    // pair's forces that the fluid loses. At 2e3 and 1e4 Pa, where sound limits, they held to 0.9 of that limit.
    if (plan.changes[b]) left = 0.3;
    // method "paper" has no gradient's correction to look at; of a nearly incompressible block the corners diverged at
    // 0.9 of this limit, at 0.85 they did not
    if (plan.method == Method::paper) left = std::min(left, 0.85);
    const NumericsConfig& n = scene.config.numerics;
    const bool corrected = plan.method == Method::accurate && !plan.changes[b];
    const double free = corrected ? free_limit(scene, plan, scene.bodies[b]) : 1e30;
    double waves = std::min(elastic_limit(ratio) * left * dx / pressure_wave_speed(m),
                            n.sub_steps ? free : kMostOfFree * free / n.safety);
    // the damping is central, as Monaghan's viscosity, whose limit is less than half that of Morris's
    const double damping = elastic_damping(scene, plan, m);
    const double damped =
        damping > 0 ? 0.4 * viscous_limit(ratio, KernelType::wendland) * dx * dx * m.density / damping : 1e30;
    if (plan.method == Method::paper) waves = with_damping(waves, damped);
    const std::string of = fmt::format("material '{}'", m.name);
    if (waves < by_waves.dt) by_waves = {waves, "elasticity", of, ""};
    if (damped < by_damping.dt) by_damping = {damped, "damping", of, ""};
  }
  std::vector<StepLimit> out;
  for (const StepLimit& limit : {by_waves, by_damping})
    if (!limit.by.empty()) out.push_back(limit);
  return out;
}

void plan_elastic_solver(const Scene& scene, double explicit_limit, Plan& plan) {
  plan.elastic_rounds = 0;
  if (!plan.elastic) return;
  const NumericsConfig& n = scene.config.numerics;
  const double step = 1 / scene.config.rate_hz;
  const auto needed = [&](double limit) { return std::max(1.0, std::ceil(step / (n.safety * limit) - 1e-9)); };
  const std::string obstacle = obstacle_of(scene, plan);
  const bool asked = n.elastic_solver == ElasticSolver::implicit;
  if (asked && !obstacle.empty())
    throw ConfigError(
        fmt::format("{}: numerics.elastic_solver is \"implicit\", but {}: leave it out", scene.config.path, obstacle));
  // in one sub-step nothing may move by more than its neighbours' distance
  const StepLimit rounding = limit_by_rounding(scene, plan);
  const double others = plan.dt_allowed / n.safety;
  const double limit = std::min({others, scene.spacing / plan.max_speed, rounding.dt});
  const double sub_steps = n.sub_steps ? double(*n.sub_steps) : needed(limit);
  const double needed_rounds = std::ceil(0.5 * std::log(2 / kLeft) * root_condition(scene, plan, step / sub_steps));
  const double rounds = n.elastic_rounds ? double(*n.elastic_rounds) : needed_rounds;
  const double particles = static_cast<double>(scene.position.size()) / plan.elastic_count;
  const double rest = plan.neighbors ? 4 * particles : 0.0;  // of a sub-step, the same for both
  plan.elastic_sub_steps = needed(std::min(explicit_limit, others));
  const double saving =
      plan.elastic_sub_steps * (kExplicit + rest) / (sub_steps * (kImplicit + kRound * rounds + rest));
  plan.elastic_choice =
      !obstacle.empty()
          ? obstacle
          : fmt::format("an implicit solve in {:.0f} rounds would cost {:.2g} times that", rounds, 1 / saving);
  if (!obstacle.empty() || n.elastic_solver == ElasticSolver::explicit_) return;
  if (!asked && (saving <= kWorth || rounds > kMaxRounds)) return;
  plan.elastic_rounds = static_cast<int>(std::min(rounds, kMaxRounds));
  plan.elastic_choice =
      fmt::format("explicit: {:.0f} sub-steps, {:.2g} times the work", plan.elastic_sub_steps, saving);
  limit_by({scene.spacing / plan.max_speed, "motion", "numerics.max_speed", ""}, n, plan);
  limit_by(rounding, n, plan);
}

std::string describe_elastic_solver(const Plan& plan) {
  if (!plan.elastic) return "";
  if (plan.elastic_rounds == 0) return fmt::format(", elasticity explicit ({})", plan.elastic_choice);
  return fmt::format(", elasticity implicit in up to {} rounds a sub-step ({})", plan.elastic_rounds,
                     plan.elastic_choice);
}

std::vector<std::uint32_t> free_elastic_bodies(const Scene& scene, const Plan& plan) {
  std::vector<std::uint32_t> out;
  for (const std::uint32_t b : plan.elastic_bodies)
    if (scene.bodies[b].bonded_to.empty()) out.push_back(b);
  return out;
}

}  // namespace palp
