// The plan of heat: whether it runs and how often; its zones and bodies in the kernels' layout.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_server/physics/heat.h"
#include "sim_server/solver/plan.h"

namespace palp {

// Fills in the plan's heat part: it runs where temperatures can differ, or something changes state; the rest of the
// plan is ready. Throws ConfigError: a material without heat capacity, too many zones, a zone that follows no solid, a
// step that would need too many parts.
void plan_heat(const Scene& scene, Plan& plan);
// Returns ", heat every 50 haptic steps (20 Hz)", or nothing without heat.
std::string describe_heat(const Plan& plan, const Scene& scene);

std::vector<HeatZone> make_heat_zones(const Scene& scene);
// Returns what each body does with heat.
std::vector<HeatRole> heat_roles(const Scene& scene);
// Returns the temperature of each body at the start [K]; 0 where it has none of its own.
std::vector<real> body_temperatures(const Scene& scene);
// Returns one bit for each zone, 1 where it is on at this time [s].
std::uint32_t heat_zones_on(const SceneConfig& config, double time);

}  // namespace palp
