#include "sim_server/solver/heat_plan.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "config/error.h"
#include "sim_server/physics/wall_share.h"
#include "sim_server/scene/scene_heat.h"
#include "sim_server/solver/lattice.h"
#include "sim_server/solver/sub_steps.h"

namespace palp {
namespace {

const Body* find_body(const Scene& scene, const std::string& name) {
  const auto found =
      std::find_if(scene.bodies.begin(), scene.bodies.end(), [&](const Body& body) { return body.name == name; });
  return found == scene.bodies.end() ? nullptr : &*found;
}

void check(const Scene& scene) {
  const SceneConfig& config = scene.config;
  std::vector<std::string> faults;
  for (std::size_t m = 0; m < config.materials.size(); ++m) {
    const MaterialConfig& material = config.materials[m];
    const bool used =
        std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const Body& body) { return body.material == m; });
    if (used && !(material.heat_capacity > 0))
      faults.push_back(
          fmt::format("{}: material '{}' has no heat_capacity, expected one in J/(kg K): heat flows in this scene",
                      material.where.empty() ? config.path : material.where, material.name));
  }
  for (const HeatZoneConfig& zone : config.heat_zones) {
    const Body* body = zone.body.empty() ? nullptr : find_body(scene, zone.body);
    if (!zone.body.empty() && (body == nullptr || (body->type != BodyKind::rigid && body->type != BodyKind::fixed)))
      faults.push_back(fmt::format("{}: heat_zone '{}' follows '{}', expected a rigid or static body", zone.where,
                                   zone.name, zone.body));
  }
  if (config.heat_zones.size() > kMaxHeatZones)
    faults.push_back(
        fmt::format("{}: {} heat zones, expected at most {}", config.path, config.heat_zones.size(), kMaxHeatZones));
  if (!faults.empty()) throw ConfigError(faults);
}

// Returns by how much faster a particle relaxes beside one, two or three walls at right angles that hold their
// temperatures, at the distance at which they draw most, than the fastest pattern of a lattice fades; of what is left
// of its neighbours no more than their share counts. H: support radius over spacing.
double wall_contrast(double H) {
  const WallKernel kernel{FluidKernel::with_support(static_cast<real>(H), real(1)), real(1), real(0.25), real(0.01),
                          Vec3(0, 0, 0)};
  const PlaneSums wall = plane_sums(kernel, kernel.least);
  const double lattice = 2 / (viscous_limit(H, fluid_kernel_type(H)) * lattice_sums(H).moment);
  const double alone = 2 * double(wall.slope / kernel.least) / lattice_sums(H).moment;
  double most = 0, open = 1;
  for (int walls = 1; walls <= 3; ++walls) {
    const double beside = open * walls * alone;
    open *= 1 - double(wall.share);
    most = std::max(most, beside / lattice + open);
  }
  return most;
}

// Returns the largest rate at which one particle's temperature relaxes [1/s], over all materials.
double relaxation_rate(const Scene& scene, const Plan& plan) {
  const double dx = scene.spacing;
  double conduction = 0, loss = 0, slowest = 1e300, fastest = 0;
  bool held = false;
  for (const Body& body : scene.bodies) {
    held = held || body.holds_temperature;
    if (body.holds_temperature) continue;
    const MaterialConfig& m = material_of(scene, body);
    const double volumetric = m.density * m.heat_capacity;
    conduction = std::max(conduction, m.conductivity / volumetric);
    slowest = std::min(slowest, m.conductivity);
    fastest = std::max(fastest, m.conductivity);
    // an isolated particle has a free surface of about 8 dx^2 (heat.h)
    loss = std::max(loss, 8 * scene.config.heat.loss_to_air / (volumetric * dx));
  }
  const double H = plan.support / dx;
  // against a far better conductor a pair conducts up to twice as well as among its like
  double contrast = held ? 2 : 2 * fastest / std::max(fastest + slowest, 1e-300);
  if (held && plan.heat_walls) contrast = std::max(contrast, wall_contrast(H));
  return contrast * conduction / (dx * dx) / (viscous_limit(H, fluid_kernel_type(H)) * lattice_sums(H).moment) + loss;
}

// Returns false where all is as warm as all else, the air included, and nothing heats or cools it: then nothing ever
// flows.
bool temperatures_differ(const Scene& scene) {
  double low = 1e300, high = -1e300;
  const auto take = [&](double T) {
    low = std::min(low, T);
    high = std::max(high, T);
  };
  for (const double T : scene.temperature) take(T);
  for (const Body& body : scene.bodies)
    if (body.temperature) take(*body.temperature);
  const HeatConfig& heat = scene.config.heat;
  const bool cooled = heat.loss_to_air > 0 && heat.air_temperature != low;
  return low != high || cooled || !scene.config.heat_zones.empty();
}

}  // namespace

void plan_heat(const Scene& scene, Plan& plan) {
  // what changes state forms and ends its bonds when heat has been computed
  plan.heat = has_heat(scene) && !scene.temperature.empty() && (plan.change || temperatures_differ(scene));
  if (!plan.heat) return;
  plan.heat_walls =
      std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const Body& body) { return bounds_heat(scene, body); });
  plan.neighbors = true;  // conduction is between neighbours
  check(scene);
  const SceneConfig& config = scene.config;
  const double step = 1 / config.rate_hz, rate = relaxation_rate(scene, plan);
  plan.heat_limit = rate > 0 ? 1 / rate : 1e30;
  const double allowed = config.numerics.safety * plan.heat_limit;
  // a hand would feel changes in larger steps
  const double rate_hz = config.heat.rate_hz.value_or(plan.change ? 100 : 20);
  const double longest = std::max(step, 1 / rate_hz);
  plan.heat_interval = std::max(1, static_cast<int>(std::min(allowed, longest) / step * (1 + 1e-9)));
  const double needed = std::ceil(plan.heat_interval * step / allowed * (1 - 1e-9));
  if (needed > 10000)
    throw ConfigError(fmt::format(
        "{}: a haptic step of {:.3g} ms would need {:.7g} steps of heat; expected at most 10000: raise the spacing or "
        "rate_hz, or lower conductivities or loss_to_air",
        config.path, 1e3 * step, needed));
  plan.heat_steps = std::max(1, static_cast<int>(needed));
  plan.heat_dt = plan.heat_interval * step / plan.heat_steps;
}

std::string describe_heat(const Plan& plan, const Scene& scene) {
  if (!plan.heat) return "";
  std::string text = fmt::format(", heat every {} haptic steps ({:.4g} Hz", plan.heat_interval,
                                 scene.config.rate_hz / plan.heat_interval);
  if (plan.heat_interval == 1) text = fmt::format(", heat every haptic step ({:.4g} Hz", scene.config.rate_hz);
  if (plan.heat_steps > 1) text += fmt::format(", in {} parts", plan.heat_steps);
  return text + fmt::format(", {:.2g} % of the limit)", 100 * plan.heat_dt / plan.heat_limit);
}

std::vector<HeatZone> make_heat_zones(const Scene& scene) {
  std::vector<HeatZone> zones;
  for (const HeatZoneConfig& from : scene.config.heat_zones) {
    const Body* body = from.body.empty() ? nullptr : find_body(scene, from.body);
    HeatZone zone{};
    zone.center = (body != nullptr ? Eigen::Vector3d(from.position - body->center) : from.position).cast<real>();
    zone.half = (0.5 * from.size).cast<real>();
    zone.q = from.orientation.cast<real>();
    zone.body = body != nullptr ? static_cast<std::uint32_t>(body - scene.bodies.data()) : kNone;
    zone.holds = from.temperature.has_value();
    zone.temperature = static_cast<real>(from.temperature.value_or(0));
    zone.power = static_cast<real>(from.power);
    zones.push_back(zone);
  }
  return zones;
}

std::vector<HeatRole> heat_roles(const Scene& scene) {
  std::vector<HeatRole> roles;
  for (const Body& body : scene.bodies) {
    const bool wall = bounds_heat(scene, body);
    if (body.holds_temperature)
      roles.push_back(wall ? HeatRole::held_wall : HeatRole::held);
    else
      roles.push_back(wall ? HeatRole::insulator : HeatRole::conducts);
  }
  return roles;
}

std::vector<real> body_temperatures(const Scene& scene) {
  std::vector<real> out;
  for (const Body& body : scene.bodies) out.push_back(static_cast<real>(body.temperature.value_or(0)));
  return out;
}

std::uint32_t heat_zones_on(const SceneConfig& config, double time) {
  std::uint32_t on = 0;
  for (std::size_t z = 0; z < config.heat_zones.size() && z < kMaxHeatZones; ++z)
    if (time >= config.heat_zones[z].start && time < config.heat_zones[z].end) on |= 1u << z;
  return on;
}

}  // namespace palp
