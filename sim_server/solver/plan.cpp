#include "sim_server/solver/plan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "config/error.h"
#include "config/quantity.h"
#include "sim_server/physics/cohesion.h"
#include "sim_server/physics/rigid.h"
#include "sim_server/scene/particle_reason.h"
#include "sim_server/scene/scene_heat.h"
#include "sim_server/solver/body_bounds.h"
#include "sim_server/solver/elastic_plan.h"
#include "sim_server/solver/fluid_room.h"
#include "sim_server/solver/heat_plan.h"
#include "sim_server/solver/levels.h"
#include "sim_server/solver/plan_checks.h"
#include "sim_server/solver/shift_plan.h"
#include "sim_server/solver/sleep_plan.h"
#include "sim_server/solver/state_change_plan.h"
#include "sim_server/solver/sub_steps.h"
#include "sim_server/solver/viscosity_plan.h"

namespace palp {
namespace {

constexpr double kLeastSpeed = 1e-3;  // for which a scene without motion of its own is planned [m/s]

// The largest speed of a fluid that runs off over that of a free fall through its depth: the front goes at up to
// 2 sqrt(g h) (Ritter 1892), 1.4 times as fast, and is thrown up where it strikes. Water that breaks onto the box of
// dam_break_box reaches 2.1 of it for moments. With 1 its gauge reads 1.69 times the measured peak in the mean of 15
// spacings, with 2 1.48, and no less with 3 and 4 (tools/results/felt_remaining.md).
constexpr double kRunOff = 2;

// Returns the height that fluids, or where there are none rigid bodies, can fall along an axis [m].
double fall_along(const Scene& scene, int axis, bool fluid) {
  const double up = scene.config.gravity[axis] < 0 ? 1 : -1;
  if (scene.left_out) return scene.left_out->fall[static_cast<std::size_t>(axis)][up > 0 ? 1 : 0];
  std::vector<bool> moves;
  for (const Body& body : scene.bodies) {
    const bool flows = body.type == BodyKind::fluid || changes_state(scene, body);
    moves.push_back(fluid ? flows : body.type == BodyKind::rigid);
  }
  return fall_height(scene, moves, axis, up);
}

// Returns the speed that a body force drives [m/s]: that of a laminar channel across the domain's smallest extent, or,
// if that is less, of free acceleration over it.
double driven_speed(const Scene& scene) {
  const double force = scene.config.body_force.norm();
  if (force == 0) return 0;
  double across = 1e30, nu = 1e30;
  for (int a = 0; a < 3; ++a) {
    const double length = scene.bounds_max[a] - scene.bounds_min[a];
    if (!scene.config.periodic[a]) across = std::min(across, length);
  }
  if (across > 1e29) across = (scene.bounds_max - scene.bounds_min).minCoeff();
  for (const Body& body : scene.bodies) {
    const MaterialConfig& m = scene.config.materials[body.material];
    if (body.type == BodyKind::fluid) nu = std::min(nu, m.viscosity / m.density);
  }
  const double free = std::sqrt(2 * force * across);
  return nu > 0 ? std::min(free, force * across * across / (8 * nu)) : free;
}

// The compression that bodies which press on a fluid with their weight may bring about.
constexpr double kPressed = 0.1;

// Returns the least sound speed with which no solid's weight, were it to rest on the fluids, would compress these by
// more than kPressed [m/s]. It matters for bodies tens of times as heavy as the fluid that they lie on.
double carrying_sound_speed(const Scene& scene) {
  double lightest = 1e30, pressure = 0;
  for (const Body& body : scene.bodies)
    if (body.type == BodyKind::fluid) lightest = std::min(lightest, scene.config.materials[body.material].density);
  for (const Body& body : scene.bodies) {
    const Eigen::AlignedBox3d box = world_bounds(scene, body);
    if (box.isEmpty() || (body.type != BodyKind::rigid && body.type != BodyKind::elastic)) continue;
    const Eigen::Vector3d size = box.sizes().array() + scene.spacing;
    const double density = body.mass / std::max(body.volume, 1e-30);
    pressure = std::max(pressure, density * scene.config.gravity.cwiseAbs().dot(size));
  }
  return lightest < 1e30 ? std::sqrt(pressure / (kPressed * lightest)) : 0;
}

// Plans elastic bodies. Bodies bonded to one another share a group; elastic bodies and those that they are bonded to
// come first in the order of forces.
void plan_elastic(const Scene& scene, Plan& plan) {
  const std::size_t count = scene.bodies.size();
  plan.group.resize(count);
  for (std::uint32_t b = 0; b < count; ++b) plan.group[b] = b;
  std::vector<bool> held(count, false);
  for (std::uint32_t b = 0; b < count; ++b) {
    const bool lasting = scene.bodies[b].type == BodyKind::elastic && !plan.changes[b];
    if (lasting) plan.elastic_bodies.push_back(b);
    if (lasting) held[b] = true;
    for (const std::uint32_t other : scene.bodies[b].bonded_to) {
      held[other] = held[other] || lasting;
      const std::uint32_t from = plan.group[other], to = plan.group[b];
      std::replace(plan.group.begin(), plan.group.end(), from, to);
    }
  }
  for (std::uint32_t b = 0; b < count; ++b) {
    if (!held[b]) continue;
    plan.force_first[b] = plan.force_count;
    plan.force_count += scene.bodies[b].count;
  }
  plan.elastic = !plan.elastic_bodies.empty();
  for (const std::uint32_t b : plan.elastic_bodies) {
    const MaterialConfig& m = scene.config.materials[scene.bodies[b].material];
    if ((m.yield_stress || m.tear_strain) && plan.method == Method::paper)
      throw ConfigError(fmt::format(
          "{}: material '{}' has a {}, which method \"paper\" knows nothing of; expected method \"accurate\": change "
          "it, or leave that key out",
          m.where.empty() ? scene.config.path : m.where, m.name, m.yield_stress ? "yield_stress" : "tear_strain"));
    plan.plastic = plan.plastic || m.yield_stress;
    plan.tears = plan.tears || m.tear_strain;
  }
  plan.elastic_count = plan.force_count;
}

// Plans the kinds of contact that can come about.
void plan_contact(const Scene& scene, Plan& plan) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Body &a = scene.bodies[i], &b = scene.bodies[j];
      const bool freezes = (plan.changes[i] && b.contact != nullptr) || (plan.changes[j] && a.contact != nullptr);
      if (freezes && plan.method == Method::accurate && plan.group[i] != plan.group[j]) plan.fields = true;
      const SolidContact contact = contact_between(scene, plan, i, j);
      plan.fields = plan.fields || contact == SolidContact::fields;
      plan.contact = plan.contact || contact == SolidContact::springs;
    }
}

void plan_bodies(const Scene& scene, Plan& plan) {
  std::vector<bool> probed(scene.bodies.size(), false);
  for (const ProbeConfig& probe : scene.config.probes)
    for (std::size_t b = 0; b < scene.bodies.size(); ++b)
      if (probe.quantity == Quantity::body && probe.body == scene.bodies[b].name) probed[b] = true;
  plan.probed = probed;
  bool solids = false;
  std::set<std::uint32_t> fluids;
  plan.force_first.assign(scene.bodies.size(), kNone);
  plan_slots(scene, plan);
  plan_elastic(scene, plan);
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    if (body.type == BodyKind::fluid || plan.changes[b]) {
      fluids.insert(body.material);
      continue;
    }
    solids = true;
    if (body.type == BodyKind::rigid) plan.rigid.push_back(b);
    // nobody reads the wrench of another fixed body, though its particles may bear what is bonded to them
    if (body.type == BodyKind::fixed && !probed[b]) continue;
    plan.reactive.push_back(b);
    if (plan.force_first[b] != kNone) continue;
    plan.force_first[b] = plan.force_count;
    plan.force_count += body.count;
  }
  plan.fluid = !fluids.empty();
  plan.one_fluid = fluids.size() == 1;
  plan.solids = solids;
  plan.wrench = !plan.reactive.empty();
  plan.moving = !plan.rigid.empty();
  plan_contact(scene, plan);
  plan.neighbors = plan.fluid || plan.contact;
  plan.geometry =
      plan.fluid && plan.method == Method::accurate &&
      std::any_of(scene.bodies.begin(), scene.bodies.end(), [](const Body& b) { return b.contact != nullptr; });
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    plan.walls = plan.walls || (plan.method == Method::accurate && is_wall_of_particles(scene, plan, b));
}

void plan_cells(const Scene& scene, int cells_per_reach, Plan& plan) {
  const SceneConfig& config = scene.config;
  for (int a = 0; a < 3; ++a) {
    if (!config.periodic[a]) continue;
    const double length = scene.bounds_max[a] - scene.bounds_min[a];
    if (length * (1 + 1e-9) < 3 * plan.support)  // rounding must not refuse an axis of just three
      throw ConfigError(
          fmt::format("{}: the domain is periodic along {} but only {:.4g} m long; expected at least three support "
                      "radii, {:.4g} m: lengthen the domain or reduce the spacing",
                      config.path, "xyz"[a], length, 3 * plan.support));
    plan.skin = std::min(plan.skin, std::max(0.0, length / 3 - plan.support));
  }
  double cells = 1;
  for (int a = 0; a < 3; ++a) {
    const double length = scene.bounds_max[a] - scene.bounds_min[a];
    // a periodic axis of just three cells must not lose one to rounding
    plan.cells[a] = std::max(
        1, static_cast<int>(std::min(cells_per_reach * length / (plan.support + plan.skin) * (1 + 1e-9), 1e6)));
    cells *= plan.cells[a];
  }
  // an airy domain needs no finer cells than about eight per particle
  const double limit = std::max(kMinCellLimit, 8.0 * static_cast<double>(scene.position.size()));
  for (int a = 0; cells > limit && a < 3; ++a) {
    const int fewest = config.periodic[a] ? 3 : 1;
    const int n = std::max(fewest, static_cast<int>(plan.cells[a] * std::pow(limit / cells, 1.0 / (3 - a))));
    cells *= static_cast<double>(n) / plan.cells[a];
    plan.cells[a] = n;
  }
}

bool has_cohesion(const Scene& scene) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const Body& body) {
    const MaterialConfig& m = scene.config.materials[body.material];
    return body.type == BodyKind::fluid && (m.surface_tension > 0 || m.adhesion > 0);
  });
}

}  // namespace

SolidContact contact_between(const Scene& scene, const Plan& plan, std::size_t i, std::size_t j) {
  const Body &a = scene.bodies[i], &b = scene.bodies[j];
  const auto moves = [](const Body& body) { return body.type == BodyKind::rigid || body.type == BodyKind::elastic; };
  const auto flows = [&](std::size_t k) { return scene.bodies[k].type == BodyKind::fluid || plan.changes[k]; };
  if (flows(i) || flows(j) || !(moves(a) || moves(b)) || plan.group[i] == plan.group[j]) return SolidContact::none;
  const auto soft = [](const Body& body) { return body.type == BodyKind::elastic; };
  const bool shaped = a.contact != nullptr && b.contact != nullptr;
  const bool by_field = shaped || (a.contact != nullptr && soft(b)) || (b.contact != nullptr && soft(a));
  return plan.method == Method::accurate && by_field ? SolidContact::fields : SolidContact::springs;
}

double expected_speed(const Scene& scene) {
  const SceneConfig& config = scene.config;
  double speed = driven_speed(scene);
  bool fluid = false;
  for (const Body& body : scene.bodies) fluid = fluid || body.type == BodyKind::fluid || changes_state(scene, body);
  for (const Eigen::Vector3d& v : scene.velocity) speed = std::max(speed, v.norm());
  const double run_off = scene.runs_off ? kRunOff : 1;
  for (int a = 0; a < 3; ++a)
    if (!config.periodic[a] && config.gravity[a] != 0)
      speed = std::max(speed, run_off * std::sqrt(2 * std::abs(config.gravity[a]) * fall_along(scene, a, fluid)));
  for (const Body& body : scene.bodies) {  // a drop of one spacing, by its own pressure
    const MaterialConfig& m = config.materials[body.material];
    const double strength = std::max(m.surface_tension, m.adhesion) / kCohesionShare;
    if (body.type == BodyKind::fluid) speed = std::max(speed, std::sqrt(2 * strength / (m.density * scene.spacing)));
  }
  if (!scene.proxies.empty()) speed = std::max(speed, 1.0);
  return speed;
}

double expected_compression(const Plan& plan) {
  const double mach = plan.max_speed / plan.sound_speed;
  return mach * mach;
}

Plan make_plan(const Scene& scene, double skin_over_spacing, int cells_per_reach) {
  const SceneConfig& config = scene.config;
  const NumericsConfig& n = config.numerics;
  const Level level = level_of(config.accuracy);
  if (config.materials.size() > kMaxMaterials)
    throw ConfigError(
        fmt::format("{}: {} materials; expected at most {}", config.path, config.materials.size(), kMaxMaterials));
  check_places(scene);
  Plan plan;
  plan.method = config.method;
  plan_bodies(scene, plan);
  check_weight(scene, plan);
  check_damping(scene, plan);
  check_densities(scene, plan);
  plan.temperature = !scene.temperature.empty();
  plan.cohesion = has_cohesion(scene);
  // with two spacings attraction freezes the particles on their lattice: a cube does not become a ball
  const double lowest = plan.cohesion ? 3 : 0;
  plan.support = n.support_over_spacing.value_or(std::max(lowest, level.support_over_spacing)) * scene.spacing;
  plan.elastic_support = plan.method == Method::paper ? plan.support : elastic_support(scene);
  plan.max_speed = n.max_speed.value_or(std::max(kLeastSpeed, expected_speed(scene)));
  plan.sound_speed = n.sound_speed.value_or(std::max(level.mach * plan.max_speed, carrying_sound_speed(scene)));
  const bool rough = !plan.one_fluid || plan.change;
  const double smooth = plan.cohesion ? level.cohesive_viscosity
                        : plan.walls  ? level.wall_viscosity
                                      : level.artificial_viscosity;
  plan.artificial = n.artificial_viscosity.value_or(rough ? level.rough_viscosity : smooth);
  plan.diffusion = n.density_diffusion.value_or(0.1);
  // without a free surface nothing can come apart, and clamping pressure would bias it
  plan.tension = n.tension.value_or(config.gravity.isZero());
  if (plan.method == Method::paper) {
    plan.artificial = plan.diffusion = 0;
    plan.tension = false;
  }
  // past two spacings a particle would have more partners than it has room for (state_change.h)
  plan.change_support = std::min(plan.elastic_support, 2 * scene.spacing);
  plan.skin = n.skin_over_spacing.value_or(skin_over_spacing) * scene.spacing;
  plan_cells(scene, cells_per_reach, plan);
  plan_sub_steps(scene, plan);
  check_motion(scene, plan);
  check_stiffness(scene, plan);
  plan_heat(scene, plan);
  plan_fluid_interval(scene, plan);
  plan_sleep(scene, plan);
  plan_shift(scene, plan);
  return plan;
}

std::string describe(const Plan& plan, const Scene& scene) {
  std::size_t left_out = 0;
  for (const Body& body : scene.bodies) left_out += body.sites > body.count ? body.sites - body.count : 0;
  std::string text = fmt::format("method {}, accuracy {}, {} particles{}, dx {:.4g} mm, H {:.3g} dx, ",
                                 to_string(plan.method), to_string(scene.config.accuracy), scene.position.size(),
                                 left_out > 0 ? fmt::format(" ({} that solids do not need left out)", left_out) : "",
                                 1e3 * scene.spacing, plan.support / scene.spacing);
  if (plan.fluid)
    text += fmt::format("c {:.3g} m/s for speeds to {:.3g} m/s, alpha {:.3g}, delta {:.3g}, {}{}", plan.sound_speed,
                        plan.max_speed, plan.artificial, plan.diffusion,
                        plan.shifts ? fmt::format("shift {:.3g}, ", plan.shift) : "",
                        plan.cohesion ? "surface tension, " : "");
  text += fmt::format("{} sub-steps of {:.4g} ms a haptic step", plan.sub_steps, 1e3 * plan.dt);
  if (plan.fluid || plan.elastic || plan.fields)
    text += fmt::format(" ({:.0f} % of the limit set by {})", 100 * plan.dt / plan.ruling.dt, plan.ruling.by);
  if (plan.fluid_interval > 1) text += fmt::format(", fluids take {} haptic steps at once", plan.fluid_interval);
  text += describe_elastic_solver(plan) + describe_viscosity(plan) + describe_heat(plan, scene);
  text += describe_sleep(plan, scene);
  if (const auto& choice = scene.config.choice)
    text += fmt::format(", chosen for {}: a step of {} and an error of {} of the force are expected", choice->asked,
                        duration_text(choice->expected_step), share_text(choice->expected_error));
  return text;
}

}  // namespace palp
