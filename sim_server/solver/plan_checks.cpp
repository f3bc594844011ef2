#include "sim_server/solver/plan_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "config/error.h"
#include "sim_server/physics/real.h"
#include "sim_server/solver/elastic_plan.h"

namespace palp {
namespace {

constexpr double kRounding = std::numeric_limits<real>::epsilon();

// Returns the speed of what has fallen through a spacing on earth [m/s]: a measure for speeds in any scene.
double falling(const Scene& scene) { return std::sqrt(2 * 9.81 * scene.spacing); }

// Returns how far the farthest particle or body is from the origin along an axis [m].
double farthest(const Scene& scene) {
  double far = 0;
  for (const Eigen::Vector3d& x : scene.position) far = std::max(far, x.cwiseAbs().maxCoeff());
  for (const Body& body : scene.bodies) far = std::max(far, body.position.cwiseAbs().maxCoeff());
  return far;
}

// Says whether particles of a body begin with different velocities: it spins, or is being deformed.
bool moves_within(const Scene& scene, const Body& body) {
  const Eigen::Vector3d& first = scene.velocity[body.first];
  const auto begin = scene.velocity.begin() + body.first;
  return std::any_of(begin, begin + body.count,
                     [&](const Eigen::Vector3d& v) { return (v - first).norm() > 1e-6 * (v.norm() + first.norm()); });
}

}  // namespace

void check_places(const Scene& scene) {
  constexpr double kMost = 0.01;  // of a spacing
  const double far = farthest(scene), rounding = far * kRounding;
  if (rounding <= kMost * scene.spacing) return;
  throw ConfigError(fmt::format(
      "{}: bodies lie {:.3g} m from the origin, where places are rounded to {:.2g} mm, expected at most {:.2g} mm, "
      "{:g} % of the spacing: move the scene to the origin or raise the spacing",
      scene.config.path, far, 1e3 * rounding, 1e3 * kMost * scene.spacing, 100 * kMost));
}

void check_motion(const Scene& scene, const Plan& plan) {
  // of the motion in a sub-step. Fluids heat themselves by it: at 0.48 their energy grew by a fortieth of what they
  // turned over, at 0.84 by a fourteenth (tools/results/trade_remaining.md).
  constexpr double kMostOfBodies = 0.05, kMostOfFluids = 0.5;
  const double far = farthest(scene), rounding = far * kRounding, motion = falling(scene) * plan.dt;
  const bool rigid = std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                 [](const Body& body) { return body.type == BodyKind::rigid; });
  const double most = rigid || plan.change ? kMostOfBodies : kMostOfFluids;
  if ((!rigid && !plan.fluid) || rounding <= most * motion) return;
  throw ConfigError(fmt::format(
      "{}: bodies lie {:.3g} m from the origin, where places are rounded to {:.2g} um, and what falls through one "
      "spacing moves by {:.2g} um in a sub-step of {:.2g} us, expected {:g} times the rounding: move the scene to the "
      "origin, raise the spacing, or soften what limits the sub-step ({})",
      scene.config.path, far, 1e6 * rounding, 1e6 * motion, 1e6 * plan.dt, 1 / most, plan.ruling.by));
}

void check_stiffness(const Scene& scene, const Plan& plan) {
  constexpr double kMost = 3;  // of the speed of a fall through a spacing, in a second
  if (!plan.elastic || plan.elastic_rounds > 0) return;
  // velocities are rounded in proportion to dx / dt, and 1 / dt roundings add up as a random walk does
  const double noise = kRounding / 2 * scene.spacing * std::pow(plan.dt, -1.5), most = kMost * falling(scene);
  if (noise <= most) return;
  const char* other = plan.method == Method::paper ? "use method \"accurate\"" : "leave elastic_solver out";
  throw ConfigError(fmt::format(
      "{}: explicit elasticity takes sub-steps of {:.2g} us, whose rounding would agitate bodies by {:.2g} m/s in a "
      "second, expected at most {:.2g} m/s: lower young_modulus, raise the spacing, or {}",
      scene.config.path, 1e6 * plan.dt, noise, most, other));
}

void check_weight(const Scene& scene, const Plan& plan) {
  constexpr double kMostStrain = 0.3;
  if (plan.method != Method::paper) return;
  for (const Body& body : scene.bodies) {
    const MaterialConfig& m = scene.config.materials[body.material];
    const bool changes = plan.changes[static_cast<std::size_t>(&body - scene.bodies.data())];
    if (body.count == 0 || (!changes && body.bonded_to.empty())) continue;
    const double strain = strain_under_weight(scene, body);
    if (strain <= kMostStrain) continue;
    throw ConfigError(fmt::format(
        "{}: the solid of material '{}' would be compressed by {:.2g} % under its own weight, expected at most {:g} % "
        "with method \"paper\": raise young_modulus, or use method \"accurate\"",
        scene.config.path, m.name, 100 * strain, 100 * kMostStrain));
  }
}

void check_damping(const Scene& scene, const Plan& plan) {
  constexpr double kLeastPoisson = 0, kMostPoisson = 0.45, kMostStrain = 0.03;
  constexpr double kShare = 0.03;  // of the damping whose forces are as large as those of stiffness for a sound wave
  if (plan.method != Method::paper) return;
  for (const std::uint32_t b : plan.elastic_bodies) {
    const Body& body = scene.bodies[b];
    const MaterialConfig& m = scene.config.materials[body.material];
    const bool uneven =
        (m.poisson_ratio < kLeastPoisson || m.poisson_ratio > kMostPoisson) && moves_within(scene, body);
    const bool soft = !body.bonded_to.empty() && strain_under_weight(scene, body) > kMostStrain;
    const double least = kShare * std::sqrt(*m.young_modulus * m.density) * scene.spacing;
    if ((!uneven && !soft) || m.damping >= least) continue;
    throw ConfigError(fmt::format(
        "{}: elastic material '{}' has a damping of {:.3g} Pa s, expected at least {:.3g} with method \"paper\", by "
        "whose "
        "forces {} would swing ever further: raise damping, or use method \"accurate\"",
        scene.config.path, m.name, m.damping, least,
        uneven ? fmt::format("what begins to spin or to deform with a poisson_ratio of {:g}", m.poisson_ratio)
               : "what is bonded and so soft"));
  }
}

void check_densities(const Scene& scene, const Plan& plan) {
  constexpr double kMostRatio = 10, kMostRatioToSolids = 100;
  if (plan.method != Method::paper) return;
  const auto is_soft = [](const Body& body) { return body.type == BodyKind::fluid || body.type == BodyKind::elastic; };
  const MaterialConfig *light = nullptr, *heavy = nullptr, *solid = nullptr;
  for (const Body& body : scene.bodies) {
    if (body.count == 0) continue;
    const MaterialConfig& m = scene.config.materials[body.material];
    const auto keep = [&m](const MaterialConfig*& one, bool instead) {
      if (one == nullptr || instead) one = &m;
    };
    if (is_soft(body)) {
      keep(light, light != nullptr && m.density < light->density);
      keep(heavy, heavy != nullptr && m.density > heavy->density);
    } else {
      keep(solid, solid != nullptr && m.density > solid->density);
    }
  }
  const auto check = [&](const MaterialConfig* other, double most) {
    if (light == nullptr || other == nullptr || other->density <= most * light->density) return;
    throw ConfigError(fmt::format(
        "{}: material '{}' is {:.3g} times as dense as '{}', expected at most {:g} times with method \"paper\": bring "
        "the densities nearer, or use method \"accurate\"",
        scene.config.path, other->name, other->density / light->density, light->name, most));
  };
  check(heavy, kMostRatio);
  check(solid, kMostRatioToSolids);
}

}  // namespace palp
