// The plan of what sleeps in a scene, and of what wakes it (physics/sleep.h). Host only.
#pragma once

#include <vector>

#include "sim_server/physics/elastic_sleep.h"
#include "sim_server/solver/elastic_store.h"
#include "sim_server/solver/plan.h"

namespace palp {

// Plans sleep where the scene asks for it. Throws a ConfigError in a scene with heat, which what sleeps would not
// conduct, and for a region of interest around no tool.
void plan_sleep(const Scene& scene, Plan& plan);

// Returns ", what is slower than 10 mm/s sleeps"; empty without sleep.
std::string describe_sleep(const Plan& plan, const Scene& scene);

// Returns the box around each rigid body, in the order of Plan::rigid.
std::vector<SleepBox> sleep_boxes(const Scene& scene, const Plan& plan);

// The units of elastic particles that sleep together (ElasticSleepViews).
struct SleepUnits {
  std::vector<SleepUnit> unit;
  std::vector<std::uint32_t> member;
};

// Returns the units of a scene. A body that is bonded to a rigid one is in none, for it moves with it.
SleepUnits sleep_units(const Scene& scene, const ElasticStore& store);

}  // namespace palp
