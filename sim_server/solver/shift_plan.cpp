#include "sim_server/solver/shift_plan.h"

#include <algorithm>

#include <fmt/format.h>

#include "config/error.h"
#include "sim_server/physics/shift.h"
#include "sim_server/solver/body_bounds.h"
#include "sim_server/solver/constants.h"
#include "sim_server/solver/levels.h"
#include "sim_server/solver/sub_steps.h"

namespace palp {
namespace {

// Returns whether particles of a fluid can be in its depths: it is more than six support radii across along every axis
// that is not periodic, and its viscosity smooths over a spacing what flows at the largest speed all along it.
bool has_depths(const Scene& scene, const Plan& plan, const Body& body) {
  if (body.type != BodyKind::fluid) return false;
  const Eigen::Vector3d size = world_bounds(scene, body).sizes().array() + scene.spacing;
  for (int a = 0; a < 3; ++a)
    if (!scene.config.periodic[a] && size[a] <= 6 * plan.support) return false;
  const MaterialConfig& fluid = material_of(scene, body);
  const double strain = plan.max_speed / size.maxCoeff();
  return strain * scene.spacing * scene.spacing * fluid.density < kSmoothedStrain * fluid.viscosity;
}

}  // namespace

void plan_shift(const Scene& scene, Plan& plan) {
  const bool can = plan.fluid && plan.method == Method::accurate && !plan.heat && is_uniform(scene, plan);
  const auto asked = scene.config.numerics.shift;
  if (asked.value_or(0) > 0 && !can)
    throw ConfigError(fmt::format(
        "{}: numerics.shift is {:g} in a scene that is not of one fluid alone, without heat, by method \"accurate\", "
        "expected 0 there: leave that key out",
        scene.config.path, *asked));
  const bool smooth = plan.support >= (1 - 1e-9) * kQuarticFrom * scene.spacing;
  const bool deep = std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                [&](const Body& body) { return has_depths(scene, plan, body); });
  plan.shift = asked.value_or(can && smooth && deep ? kShift : 0);
  plan.shifts = plan.shift > 0;
  if (plan.shifts) plan.layer_interval = steps_between(kLayerInterval, scene, plan);
}

}  // namespace palp
