#include "sim_server/solver/plan_checks.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "config/error.h"
#include "sim_server/physics/real.h"
#include "sim_server/solver/body_bounds.h"

namespace palp {

void check_rounding(const Scene& scene) {
  constexpr double kMostRounding = 0.01;  // of a spacing
  double far = 0;
  for (const Eigen::Vector3d& x : scene.position) far = std::max(far, x.cwiseAbs().maxCoeff());
  for (const Body& body : scene.bodies) far = std::max(far, body.position.cwiseAbs().maxCoeff());
  const double rounding = far * std::numeric_limits<real>::epsilon();
  if (rounding <= kMostRounding * scene.spacing) return;
  throw ConfigError(fmt::format(
      "{}: bodies lie {:.3g} m from the origin, where places are rounded to {:.2g} mm, expected at most {:.2g} mm, "
      "{:g} % of the spacing: move the scene to the origin or raise the spacing",
      scene.config.path, far, 1e3 * rounding, 1e3 * kMostRounding * scene.spacing, 100 * kMostRounding));
}

void check_weight(const Scene& scene, const Plan& plan) {
  constexpr double kMostStrain = 0.3;
  if (plan.method != Method::paper) return;
  for (const Body& body : scene.bodies) {
    const MaterialConfig& m = scene.config.materials[body.material];
    if (body.count == 0 || !plan.changes[static_cast<std::size_t>(&body - scene.bodies.data())]) continue;
    const Eigen::Vector3d size = body_bounds(scene, body).sizes().array() + scene.spacing;
    const double strain = m.density * scene.config.gravity.cwiseAbs().dot(size) / *m.young_modulus;
    if (strain <= kMostStrain) continue;
    throw ConfigError(fmt::format(
        "{}: the solid of material '{}' would be compressed by {:.2g} % under its own weight, expected at most {:g} % "
        "with method \"paper\": raise young_modulus, or use method \"accurate\"",
        scene.config.path, m.name, 100 * strain, 100 * kMostStrain));
  }
}

}  // namespace palp
