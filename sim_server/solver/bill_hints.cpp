// The ways to make a scene cheaper, as far as its plan tells.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim_server/solver/bill.h"

namespace palp {
namespace {

// Returns what lengthens the sub-step that a limit allows.
std::string remedy_for(const StepLimit& limit, const Scene& scene, const Plan& plan) {
  const NumericsConfig& n = scene.config.numerics;
  if (limit.by == "sound")
    return fmt::format(
        "it follows the sound speed, {:.3g} times the {:.3g} m/s that the scene is expected to reach: if it is slower, "
        "say so in numerics.max_speed",
        plan.sound_speed / plan.max_speed, plan.max_speed);
  if (limit.by == "viscosity" && limit.of == "numerics.artificial_viscosity")
    return "lower numerics.artificial_viscosity";
  if (limit.by == "viscosity")
    return n.viscosity == ViscosityScheme::explicit_
               ? "leave out numerics.viscosity, so that stages may take the place of sub-steps"
               : fmt::format("lower the viscosity of {}", limit.of);
  if (limit.by == "elasticity")
    return n.elastic_solver == ElasticSolver::explicit_
               ? "leave out numerics.elastic_solver, so that an implicit solve may take the place of sub-steps"
               : fmt::format("lower the young_modulus of {}", limit.of);
  if (limit.by == "density")
    return fmt::format("bring the densities of {} nearer to one another, or use method \"accurate\"", limit.of);
  if (limit.by == "density diffusion") return "lower numerics.density_diffusion";
  if (limit.by == "damping") return fmt::format("lower the damping of {}", limit.of);
  if (limit.by == "surface tension") return fmt::format("lower the surface_tension or adhesion of {}", limit.of);
  if (limit.of == "numerics.max_speed") return "lower numerics.max_speed, if the scene is slower than that";
  return fmt::format("lower the coupling_limit of {}, or make that tool heavier", limit.of);
}

std::string hint_of_sub_steps(const Scene& scene, const Plan& plan, const Bill& bill) {
  if (scene.config.numerics.sub_steps && !bill.limits.empty() && bill.limits[0].sub_steps < plan.sub_steps)
    return fmt::format("numerics.sub_steps asks for {} sub-steps where {:.0f} would do: leave it out", plan.sub_steps,
                       bill.limits[0].sub_steps);
  if (plan.sub_steps == 1 || bill.limits.empty()) return "";
  const BillLimit& first = bill.limits[0];
  const bool another = bill.limits.size() > 1 && bill.limits[1].limit.avoided_by.empty();
  return fmt::format(
      "{} rules the {} sub-steps: {} ({})", first.limit.by, plan.sub_steps, remedy_for(first.limit, scene, plan),
      another
          ? fmt::format("the next limit, {}, would ask for {:.0f}", bill.limits[1].limit.by, bill.limits[1].sub_steps)
          : "there is no other limit");
}

void hint_of_bodies(const Plan& plan, const Bill& bill, std::vector<std::string>& hints) {
  for (const BillBody& body : bill.bodies) {
    if (body.particles > 0 && body.reasons.empty())
      hints.push_back(
          fmt::format("nobody meets the {} particles of '{}': they change nothing, and a coarser numerics.spacing "
                      "costs no accuracy "
                      "there",
                      body.particles, body.name));
    if (body.out_of_reach * 10 > body.particles)
      hints.push_back(fmt::format(
          "{} of the {} particles of '{}' lie deeper than the support radius of {:.3g} mm, where no fluid within it "
          "meets them: make its walls thinner, or hollow",
          body.out_of_reach, body.particles, body.name, 1e3 * plan.support));
  }
}

std::string hint_of_sleep(const Plan& plan) {
  if (!(plan.fluid || plan.elastic) || plan.sleeps || plan.heat || plan.change) return "";
  return "what rests is computed like what moves: with numerics.sleep_speed = 0.01 it sleeps";
}

std::string hint_of_spacing(const Plan& plan, const Bill& bill) {
  const auto order = [](const std::string& by) {
    return by == "viscosity" || by == "damping" ? 2.0 : by == "surface tension" ? 1.5 : 1.0;
  };
  const double fewer =
      bill.limits.empty() ? 1 : std::min<double>(plan.sub_steps, std::pow(2, order(bill.limits[0].limit.by)));
  if (bill.particles() == 0) return "";
  return fmt::format("twice the spacing, {:.3g} mm, leaves about {} of the particles and {} of the sub-steps",
                     2e3 * bill.spacing, "1/8", fewer > 1 ? fmt::format("1/{:.2g}", fewer) : "all");
}

}  // namespace

std::vector<std::string> bill_hints(const Scene& scene, const Plan& plan, const Bill& bill) {
  std::vector<std::string> hints;
  hint_of_bodies(plan, bill, hints);
  for (const std::string& hint : {hint_of_sub_steps(scene, plan, bill), hint_of_sleep(plan)})
    if (!hint.empty()) hints.push_back(hint);
  const auto most = std::max_element(bill.stages.begin(), bill.stages.end(),
                                     [](const BillStage& a, const BillStage& b) { return a.share < b.share; });
  if (most != bill.stages.end() && most->share > 0.5)
    hints.push_back(fmt::format("stage '{}' takes {:.0f} % of the time: what makes it cheaper makes the step cheaper",
                                most->name, 100 * most->share));
  if (const std::string hint = hint_of_spacing(plan, bill); !hint.empty()) hints.push_back(hint);
  return hints;
}

}  // namespace palp
