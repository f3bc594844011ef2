#include "sim_server/scene/support_radii.h"

#include <algorithm>

#include "sim_server/scene/levels.h"

namespace palp {

bool has_cohesion(const Scene& scene) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(), [&](const Body& body) {
    const MaterialConfig& m = material_of(scene, body);
    return body.type == BodyKind::fluid && (m.surface_tension > 0 || m.adhesion > 0);
  });
}

double fluid_support(const Scene& scene) {
  // with two spacings attraction freezes the particles on their lattice: a cube does not become a ball
  const double lowest = has_cohesion(scene) ? 3 : 0;
  const double level = level_of(scene.config.accuracy).support_over_spacing;
  return scene.config.numerics.support_over_spacing.value_or(std::max(lowest, level)) * scene.spacing;
}

double elastic_support(const Scene& scene) {
  // Where gradients are taken from the 26 nearest bonds alone (elastic_stencil.h), a longer kernel would but weaken the
  // force against hourglass modes. What tears has all bonds.
  const double ratio = scene.config.numerics.support_over_spacing.value_or(2.0);
  for (const Body& body : scene.bodies)
    if (body.type == BodyKind::elastic && material_of(scene, body).tear_strain) return ratio * scene.spacing;
  return std::min(ratio, 2.0) * scene.spacing;
}

}  // namespace palp
