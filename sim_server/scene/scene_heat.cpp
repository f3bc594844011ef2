#include "sim_server/scene/scene_heat.h"

#include <algorithm>

namespace palp {

bool has_temperatures(const Scene& scene) {
  return !scene.temperature.empty() || std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                                   [](const Body& body) { return body.temperature.has_value(); });
}

bool has_heat(const Scene& scene) {
  if (!has_temperatures(scene)) return false;
  if (scene.config.heat.loss_to_air > 0 || !scene.config.heat_zones.empty()) return true;
  return std::any_of(scene.bodies.begin(), scene.bodies.end(),
                     [&](const Body& body) { return material_of(scene, body).conductivity > 0; });
}

bool changes_state(const Scene& scene, const Body& body) {
  const MaterialConfig& m = material_of(scene, body);
  const bool matter = body.type == BodyKind::fluid || body.type == BodyKind::elastic;
  return matter && has_heat(scene) && m.young_modulus && (m.melting_temperature || m.cooking_temperature);
}

bool bounds_heat(const Scene& scene, const Body& body) {
  if (body.contact == nullptr || !body.temperature || scene.config.numerics.solid_particles) return false;
  return body.holds_temperature || (material_of(scene, body).conductivity == 0 && scene.config.heat_zones.empty());
}

}  // namespace palp
