// What heat needs of a scene: whether it runs and how often, and its constants in the kernels' layout.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim_server/physics/heat.h"
#include "sim_server/solver/plan.h"

namespace palp {

// Whether particles have temperatures and something conducts, heats or cools them.
bool has_heat(const Scene& scene);

// Fills in the plan's heat part; the rest of the plan is ready. Throws ConfigError: a material without heat capacity,
// too many zones, a zone that follows no solid, a step that would need too many parts.
void plan_heat(const Scene& scene, Plan& plan);
// ", heat every 50 haptic steps (20 Hz)", or nothing.
std::string describe_heat(const Plan& plan, const Scene& scene);

// For a plan with heat.
HeatMedium make_heat_medium(const Scene& scene, const Plan& plan);
std::vector<HeatZone> make_heat_zones(const Scene& scene);
std::vector<std::uint32_t> held_bodies(const Scene& scene);  // by body: 1 when its temperature is held
// One bit for each zone that is on at this time.
std::uint32_t heat_zones_on(const SceneConfig& config, double time);

}  // namespace palp
