#include "sim_server/solver/sub_steps.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "config/error.h"
#include "sim_server/physics/cohesion.h"
#include "sim_server/solver/constants.h"
#include "sim_server/solver/elastic_plan.h"
#include "sim_server/solver/viscosity_plan.h"

namespace palp {
namespace {

// The share of the limit by sound that a sub-step may use, over numerics.safety. Up to the limit itself the force on a
// stirred ladle errs by the same (tools/results/felt_remaining.md).
constexpr double kSoundShare = 1.3;
// The same for the splines, whose limits are the shorter by their finest waves: the quartic one with H = 2.7 dx, the
// quintic one and Wendland's with 3 dx, all allow 1.7 dx / c.
constexpr double kSplineSoundShare = 1.5;
// The longest sub-step that density diffusion allows, times delta c / dx, and the share of it that one may use. With
// delta from 0.1 to 0.5 oil at rest in tray_fluid is calm up to 0.196 and diverges from 0.200 on where H = 3 dx, and
// up to 0.234 and from 0.245 on where H = 2 dx.
constexpr double kDiffusionLimit = 0.2, kDiffusionShare = 1.7;
// The part of that share which is left where viscosity is taken in stages, beside which the drag of walls is not
// limited. Where a lid drives its fluid into a corner (tests/cases/lid_corner_test.cpp) 0.62 of the limit by sound is
// calm, and 0.71 is not.
constexpr double kSoundBesideStages = 0.8;

// Returns a tabulated limit at x = H / dx, linear between and past the entries.
double interpolate(const std::array<std::array<double, 2>, 4>& table, double x) {
  std::size_t k = 1;
  while (k + 1 < table.size() && x > table[k][0]) ++k;
  const auto [x0, y0] = table[k - 1];
  const auto [x1, y1] = table[k];
  return y0 + (y1 - y0) * (x - x0) / (x1 - x0);
}

// Limits the sub-step by contact: not for stability, which contact has at any step, but for the depth to which solids
// enter one another. Like the others this limit is halved by the default safety.
void limit_by_contact(const Scene& scene, Plan& plan) {
  if (!plan.fields) return;
  // a bounce reaches a depth of 1.6 v dt (physics/contact_law.h): at the default share less than a spacing
  limit_by({scene.spacing / plan.max_speed, "contact", "numerics.max_speed", ""}, scene.config.numerics, plan);
  // under a hand: an edge, behind which there is a quarter of the tool's mass, is ten times as stiff as the coupling
  for (const Proxy& proxy : scene.proxies) {
    const double stiffness = std::clamp(proxy.limit.stiffness, 1.0, 3000.0);
    const Body& tool = scene.bodies[proxy.body];
    const double limit = 2 * std::sqrt(0.1 * tool.mass / (10 * stiffness));
    limit_by({limit, "contact", fmt::format("the hand on '{}'", tool.name), ""}, scene.config.numerics, plan);
  }
}

// Limits the sub-step by the viscosity with which solids of method "paper" act on each other, which slows a particle
// among the other body's as if all of these moved against it.
void limit_by_viscous_contact(const Scene& scene, Plan& plan) {
  if (plan.method != Method::paper || !plan.contact) return;
  const double dx = scene.spacing, most = laplacian_limit(plan.support / dx) * dx * dx;
  const auto viscosity = [&](const Body& body) { return scene.config.materials[body.material].viscosity; };
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    for (std::size_t j = 0; j < scene.bodies.size(); ++j) {
      const Body &a = scene.bodies[i], &b = scene.bodies[j];
      if (i == j || a.type == BodyKind::fixed || contact_between(scene, plan, i, j) != SolidContact::springs) continue;
      const double nu = 0.5 * (viscosity(a) + viscosity(b)) * a.volume / a.mass;
      if (nu > 0)
        limit_by({most / nu, "viscosity", fmt::format("contact of body '{}'", a.name), ""}, scene.config.numerics,
                 plan);
    }
}

// Limits the sub-step by solids of method "paper" that are denser than what they push. By Eq. 2 each particle's
// pressure is that of its own density, so that what is between them swings as in a medium that stiff. Blocks of fluid
// in a tray of 13, 50, 200 and 2000 times their density made energy from 0.9, 0.5, 0.25 and 0.08 of the limit by sound
// on.
void limit_by_density(const Scene& scene, double sound, Plan& plan) {
  constexpr double kDenser = 5;  // solids up to so many times as dense need no limit of their own
  if (plan.method != Method::paper) return;
  const auto density = [&](const Body& body) { return scene.config.materials[body.material].density; };
  const auto held = [&](std::uint32_t b) {  // its coupling weighs more than a light tool
    return std::any_of(scene.proxies.begin(), scene.proxies.end(), [&](const Proxy& p) { return p.body == b; });
  };
  StepLimit least;
  for (std::uint32_t i = 0; i < scene.bodies.size(); ++i)
    for (const Body& solid : scene.bodies) {
      const Body& pushed = scene.bodies[i];
      const bool moves = pushed.type != BodyKind::fixed && !held(i);
      if (!moves || (solid.type != BodyKind::rigid && solid.type != BodyKind::fixed)) continue;
      const double times = density(solid) / density(pushed), limit = sound * std::sqrt(kDenser / times);
      if (times > kDenser && limit < least.dt)
        least = {limit, "density", fmt::format("'{}' against '{}'", solid.name, pushed.name), ""};
    }
  limit_by(least, scene.config.numerics, plan);
}

// Limits the sub-step by the shortest capillary wave, of length 2 dx (Brackbill, Kothe & Zemach 1992).
void limit_by_tension(const Scene& scene, Plan& plan) {
  if (!plan.cohesion) return;
  if (plan.method == Method::paper)
    throw ConfigError(fmt::format(
        "{}: a material has surface_tension or adhesion, which method \"paper\" does not know: use method \"accurate\"",
        scene.config.path));
  for (const Body& body : scene.bodies) {
    const MaterialConfig& m = scene.config.materials[body.material];
    const double strength = std::max(m.surface_tension, m.adhesion) / kCohesionShare;
    if (body.type != BodyKind::fluid || strength == 0) continue;
    const double limit = std::sqrt(m.density * std::pow(scene.spacing, 3) / (2 * EIGEN_PI * strength));
    limit_by({limit, "surface tension", fmt::format("material '{}'", m.name), ""}, scene.config.numerics, plan);
  }
}

void choose_sub_steps(const SceneConfig& config, Plan& plan) {
  const double step = 1.0 / config.rate_hz;
  const double needed = std::ceil(step / plan.dt_allowed - 1e-9);
  if (needed > 10000)
    throw ConfigError(fmt::format(
        "{}: a haptic step of {:.3g} ms would need {:.7g} sub-steps (limited by {}); expected at most 10000: "
        "raise the spacing or rate_hz, or lower the sound speed or viscosity",
        config.path, 1e3 * step, needed, plan.ruling.by));
  plan.sub_steps = std::max(1, static_cast<int>(needed));
  if (config.numerics.sub_steps) {
    plan.sub_steps = *config.numerics.sub_steps;
    if (step / plan.sub_steps > plan.dt_limit)
      throw ConfigError(
          fmt::format("{}: numerics.sub_steps is {} but a stable step needs at least {:.0f} (limited by {}): raise it "
                      "or leave it out",
                      config.path, plan.sub_steps, std::ceil(step / plan.dt_limit), plan.ruling.by));
  }
  plan.dt = step / plan.sub_steps;
}

// Returns why fluids cannot take several haptic steps at once; empty: they can.
std::string bound_to_each_step(const Plan& plan) {
  if (!plan.fluid || plan.method == Method::paper) return "no fluid of method \"accurate\" is in the scene";
  if (plan.elastic || plan.change) return "elastic bodies and matter that changes state move with fluids";
  if (plan.heat) return "heat flows in haptic steps of its own";
  if (plan.contact || plan.walls) return "bodies act by their particles";
  if (plan.viscous_stages > 0) return "viscosity is taken in stages, which bodies share";
  if (plan.sub_steps > 1) return "a haptic step has several sub-steps";
  return "";
}

// Returns the longest step that a share of the limits of fluids allows [s].
template <class Allowed>
double fluid_step(const Plan& plan, Allowed&& allowed) {
  double least = 1e30;
  for (const StepLimit& limit : plan.limits)
    if (limit.by != "contact" && limit.avoided_by.empty()) least = std::min(least, allowed(limit));
  return least;
}

// Returns the limit by sound where viscosity is taken in stages.
StepLimit beside_stages(StepLimit sound) {
  sound.of += ", beside stages of viscosity";
  sound.share *= kSoundBesideStages;
  return sound;
}

// Adds the limit of the fluids' own viscosity to that of the artificial one, which it takes in. Where viscosity is
// taken in stages that by sound becomes the one beside them; where it is not, that of sound and viscosity together is
// added: a sub-step of symplectic Euler is stable while (w dt)^2 + 2 a dt < 4 for what swings with w and decays with a,
// so the two limits share a sub-step. With 1.5 in place of kBothLimits a box of 12 spacings whose lid moves diverged
// from its start.
void limit_by_viscosity(const Scene& scene, double limit, const std::string& material, const StepLimit& sound,
                        Plan& plan) {
  constexpr double kBothLimits = 1.1;
  const NumericsConfig& numerics = scene.config.numerics;
  const bool staged = plan.viscous_stages > 0;
  const char* replaced = staged ? "sound" : "viscosity";
  std::erase_if(plan.limits, [&](const StepLimit& one) { return one.by == replaced; });
  if (staged) limit_by(beside_stages(sound), numerics, plan);
  const StepLimit alone{limit, "viscosity", material, staged ? "stages" : ""};
  limit_by(alone, numerics, plan);
  if (staged || plan.method != Method::accurate) return;
  // (dt / s)^2 + dt / v = kBothLimits
  const double s = allowed_by(sound, numerics), v = allowed_by(alone, numerics), b = s / v;
  const double both = 2 * kBothLimits * s / (b + std::sqrt(b * b + 4 * kBothLimits));
  if (both < std::min(s, v))
    limit_by({both / std::min(1.0, numerics.safety), "sound and viscosity", material, ""}, numerics, plan);
}

// The longest time that fluids take at once where the scene does not say [s]. The force on a ladle that stirs
// tray_fluid is the same, within what two runs differ by, from one to five milliseconds. But at three a vortex decays
// from a lattice at 1.10 of its rate in place of 1.04, and at four a block squeezed what was beneath it flat
// (tools/results/felt_remaining.md).
constexpr double kLongestFluidStep = 2e-3;
// Fewer particles cost what their launches cost, however seldom they move.
constexpr std::size_t kFewParticles = 200;

}  // namespace

void plan_fluid_interval(const Scene& scene, Plan& plan) {
  const NumericsConfig& n = scene.config.numerics;
  const double step = 1 / scene.config.rate_hz;
  const auto steps_in = [&](double time) { return static_cast<int>(std::min(time / step + 1e-9, 1e6)); };
  const std::string bound = bound_to_each_step(plan);
  if (n.fluid_interval) {
    plan.fluid_interval = *n.fluid_interval;
    const int most =
        bound.empty() ? std::max(1, steps_in(fluid_step(plan, [](const StepLimit& one) { return one.dt; }))) : 1;
    if (plan.fluid_interval > most)
      throw ConfigError(fmt::format(
          "{}: numerics.fluid_interval is {} but fluids can take {} haptic step{} at once{}: "
          "lower it or leave it out",
          scene.config.path, plan.fluid_interval, most, most > 1 ? "s" : "", bound.empty() ? "" : ", since " + bound));
    return;
  }
  if (!bound.empty() || n.sub_steps || scene.position.size() < kFewParticles) return;
  const double allowed = fluid_step(plan, [&](const StepLimit& one) { return allowed_by(one, n); });
  plan.fluid_interval = std::max(1, steps_in(std::min(allowed, kLongestFluidStep)));
}

double allowed_by(const StepLimit& limit, const NumericsConfig& numerics) {
  return std::min(1.0, numerics.safety * limit.share) * limit.dt;
}

int steps_between(double interval, const Scene& scene, const Plan& plan) {
  const double moves = interval * scene.config.rate_hz / plan.fluid_interval;
  return plan.fluid_interval * std::max(1, static_cast<int>(moves));
}

void limit_by(const StepLimit& limit, const NumericsConfig& numerics, Plan& plan) {
  if (!(limit.dt < 1e30)) return;
  plan.limits.push_back(limit);
  if (!limit.avoided_by.empty()) return;
  plan.dt_limit = std::min(plan.dt_limit, limit.dt);
  if (allowed_by(limit, numerics) >= plan.dt_allowed) return;
  plan.dt_allowed = allowed_by(limit, numerics);
  plan.ruling = limit;
}

double acoustic_limit(double support_over_spacing, KernelType kernel) {
  if (kernel == KernelType::quintic)
    return interpolate({{{2.5, 1.92}, {2.75, 2.08}, {3.0, 2.27}, {4.0, 3.03}}}, support_over_spacing);
  if (kernel == KernelType::quartic)
    return interpolate({{{2.5, 2.07}, {2.75, 2.27}, {3.0, 2.47}, {4.0, 3.30}}}, support_over_spacing);
  return interpolate({{{2.0, 1.76}, {2.6, 2.23}, {3.0, 2.59}, {4.0, 3.67}}}, support_over_spacing);
}

double viscous_limit(double support_over_spacing, KernelType kernel) {
  if (kernel == KernelType::quintic)
    return interpolate({{{2.5, 0.351}, {2.6, 0.378}, {3.0, 0.499}, {4.0, 0.888}}}, support_over_spacing);
  if (kernel == KernelType::quartic)
    return interpolate({{{2.5, 0.418}, {2.75, 0.506}, {3.0, 0.599}, {4.0, 1.06}}}, support_over_spacing);
  return interpolate({{{2.0, 0.311}, {2.6, 0.504}, {3.0, 0.654}, {4.0, 1.15}}}, support_over_spacing);
}

double laplacian_limit(double support_over_spacing) {
  return interpolate({{{2.0, 0.506}, {2.6, 0.853}, {3.0, 1.18}, {4.0, 2.07}}}, support_over_spacing);
}

double elastic_limit(double support_over_spacing) {
  return interpolate({{{2.0, 1.76}, {2.6, 2.23}, {3.0, 2.60}, {4.0, 3.67}}}, support_over_spacing);
}

void plan_sub_steps(const Scene& scene, Plan& plan) {
  const SceneConfig& config = scene.config;
  const double dx = scene.spacing, ratio = plan.support / dx;
  double physical = 0, fastest = plan.sound_speed;
  std::string thickest = "numerics.artificial_viscosity";
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    if (body.type != BodyKind::fluid && !plan.changes[b]) continue;
    const MaterialConfig& m = config.materials[body.material];
    if (m.viscosity / m.density > physical) thickest = fmt::format("material '{}'", m.name);
    physical = std::max(physical, m.viscosity / m.density);
    fastest = std::max(fastest, sound_speed_in(scene, plan, m));
  }
  const double nu = plan.artificial * fastest * 0.5 * plan.support / 10;  // equivalent of the artificial viscosity
  // that of the paper's kernel is no shorter than that of Wendland's
  const KernelType kernel = plan.method == Method::paper ? KernelType::wendland : fluid_kernel_type(ratio);
  const double sound = acoustic_limit(ratio, kernel) * dx / (fastest + plan.max_speed);
  const auto viscous = [&](double n) { return n > 0 ? viscous_limit(ratio, kernel) * dx * dx / n : 1e30; };
  StepLimit by_sound{sound, "sound", fmt::format("c {:.3g} m/s", fastest), ""};
  plan.dt_limit = 1e30;
  plan.dt_allowed = 1e30;
  plan.ruling = {1e30, "sound", "", ""};
  // by method "paper" solids push each other with the pressure of fluids
  if (plan.fluid || (plan.method == Method::paper && plan.contact)) {
    const double accurate = kernel == KernelType::wendland ? kSoundShare : kSplineSoundShare;
    by_sound.share = plan.method == Method::accurate ? accurate : 1;
    limit_by(by_sound, scene.config.numerics, plan);
    limit_by({viscous(nu), "viscosity", "numerics.artificial_viscosity", ""}, scene.config.numerics, plan);
    if (plan.diffusion > 0)
      limit_by({kDiffusionLimit * dx / (plan.diffusion * fastest), "density diffusion",
                fmt::format("numerics.density_diffusion, {:.3g}", plan.diffusion), "", kDiffusionShare},
               scene.config.numerics, plan);
    limit_by_density(scene, sound, plan);
  }
  limit_by_viscous_contact(scene, plan);
  for (const StepLimit& limit : limits_by_elasticity(scene, plan, true)) limit_by(limit, scene.config.numerics, plan);
  limit_by_tension(scene, plan);
  limit_by_contact(scene, plan);
  const std::vector<StepLimit> elastic = limits_by_elasticity(scene, plan, false);
  double least = 1e30;
  for (const StepLimit& limit : elastic) least = std::min(least, limit.dt);
  plan_elastic_solver(scene, least, plan);
  for (StepLimit limit : elastic) {
    if (plan.elastic_rounds > 0) limit.avoided_by = "implicit solve";
    limit_by(limit, scene.config.numerics, plan);
  }
  plan_viscosity(scene, plan.dt_allowed,
                 std::min(plan.dt_allowed, allowed_by(beside_stages(by_sound), config.numerics)),
                 plan.fluid ? viscous(nu + physical) : 1e30, plan);
  if (plan.fluid)
    limit_by_viscosity(scene, viscous(nu + physical), physical > nu ? thickest : "numerics.artificial_viscosity",
                       by_sound, plan);
  choose_sub_steps(config, plan);
}

}  // namespace palp
