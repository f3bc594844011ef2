#include "sim_server/scene/particle_reason.h"

#include <algorithm>

#include "sim_server/geometry/point_grid.h"
#include "sim_server/scene/scene_heat.h"

namespace palp {

namespace {

using Eigen::Vector3d;

bool is_solid(const Body& body) { return body.type == BodyKind::rigid || body.type == BodyKind::fixed; }
bool is_shapeless(const Body& body) { return is_solid(body) && body.surface.triangles.empty(); }

bool holds_on_to(const Body& body, std::size_t other) {
  return std::find(body.bonded_to.begin(), body.bonded_to.end(), other) != body.bonded_to.end();
}

// Returns whether matter that changes state holds on to a body. It may melt, and freeze to it anywhere.
bool freezes_to(const Scene& scene, std::size_t index) {
  return std::any_of(scene.bodies.begin(), scene.bodies.end(),
                     [&](const Body& other) { return changes_state(scene, other) && holds_on_to(other, index); });
}

// Returns the particles to keep. Of a body to which elastic matter is bonded that lasts those within two support radii
// of it: those nearer than one are strained, and their neighbours feel it.
std::vector<bool> needed_particles(const Scene& scene) {
  const PeriodicBox box = box_of(scene);
  const double reach = 2 * elastic_support(scene);
  std::vector<Vector3d> elastic;
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (scene.bodies[scene.body[i]].type == BodyKind::elastic) elastic.push_back(scene.position[i]);
  const PointGrid grid(elastic, box, reach);
  const auto is_near = [&](const Vector3d& x) {
    bool near = false;
    grid.near(x, [&](std::uint32_t k) { near = near || box.between(elastic[k], x).norm() < reach; });
    return near;
  };
  std::vector<bool> needed(scene.position.size(), false);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const ParticleReason reason = particle_reason(scene, b);
    if (reason == ParticleReason::none) continue;
    const bool all = reason != ParticleReason::bonded || freezes_to(scene, b);
    for (std::size_t i = body.first; i < body.first + body.count; ++i) needed[i] = all || is_near(scene.position[i]);
  }
  return needed;
}

LeftOut measure(const Scene& scene) {
  LeftOut out;
  std::vector<bool> moves;
  const auto flows = [&](const Body& body) { return body.type == BodyKind::fluid || changes_state(scene, body); };
  const bool fluid = std::any_of(scene.bodies.begin(), scene.bodies.end(), flows);
  for (const Body& body : scene.bodies) moves.push_back(fluid ? flows(body) : body.type == BodyKind::rigid);
  for (int axis = 0; axis < 3; ++axis)
    for (const int up : {0, 1})
      out.fall[static_cast<std::size_t>(axis)][static_cast<std::size_t>(up)] =
          fall_height(scene, moves, axis, 2.0 * up - 1);
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    if (is_solid(scene.bodies[scene.body[i]])) out.speed = std::max(out.speed, scene.velocity[i].norm());
  return out;
}

}  // namespace

ParticleReason particle_reason(const Scene& scene, std::size_t index) {
  const Body& body = scene.bodies[index];
  if (!is_solid(body)) return ParticleReason::matter;
  if (scene.config.method == Method::paper) return ParticleReason::paper;
  if (scene.config.numerics.solid_particles) return ParticleReason::asked;
  const auto any = [&](auto holds) { return std::any_of(scene.bodies.begin(), scene.bodies.end(), holds); };
  if (any([&](const Body& other) {
        return other.type == BodyKind::fluid && scene.config.materials[other.material].adhesion > 0;
      }))
    return ParticleReason::adhesion;
  if (is_shapeless(body)) return ParticleReason::shapeless;
  if (has_temperatures(scene) && !bounds_heat(scene, body)) return ParticleReason::temperature;
  if (any([&](const Body& other) {
        return is_shapeless(other) && (other.type == BodyKind::rigid || body.type == BodyKind::rigid);
      }))
    return ParticleReason::springs;
  if (any([&](const Body& other) { return other.type == BodyKind::elastic && holds_on_to(other, index); }))
    return ParticleReason::bonded;
  return ParticleReason::none;
}

const char* describe(ParticleReason reason) {
  switch (reason) {
    case ParticleReason::none:
      return "nothing needs them";
    case ParticleReason::matter:
      return "it deforms";
    case ParticleReason::paper:
      return "method \"paper\" computes every contact between particles";
    case ParticleReason::asked:
      return "numerics.solid_particles asks for them";
    case ParticleReason::adhesion:
      return "a fluid of the scene clings to them";
    case ParticleReason::temperature:
      return "its temperature changes, of which they keep account";
    case ParticleReason::shapeless:
      return "it consists of loose particles";
    case ParticleReason::springs:
      return "it can meet a body of loose particles";
    case ParticleReason::bonded:
      return "an elastic body holds on to it";
  }
  return "";
}

double elastic_support(const Scene& scene) {
  // Where gradients are taken from the 26 nearest bonds alone (elastic_stencil.h), a longer kernel would but weaken the
  // force against hourglass modes. What tears has all bonds.
  const double ratio = scene.config.numerics.support_over_spacing.value_or(2.0);
  for (const Body& body : scene.bodies)
    if (body.type == BodyKind::elastic && scene.config.materials[body.material].tear_strain)
      return ratio * scene.spacing;
  return std::min(ratio, 2.0) * scene.spacing;
}

void leave_out_particles(Scene& scene) {
  bool some = false;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const ParticleReason reason = particle_reason(scene, b);
    some = some || reason == ParticleReason::none || reason == ParticleReason::bonded;
  }
  if (!some) return;
  const std::vector<bool> needed = needed_particles(scene);
  if (std::find(needed.begin(), needed.end(), false) == needed.end()) return;
  scene.left_out = measure(scene);
  const bool warm = !scene.temperature.empty();
  std::size_t kept = 0;
  for (Body& body : scene.bodies) {
    const std::size_t begin = body.first, end = begin + body.count;
    body.first = static_cast<std::uint32_t>(kept);
    for (std::size_t i = begin; i < end; ++i) {
      body.extent.extend(Vector3d(body.orientation.conjugate() * scene.position[i]));
      if (!needed[i]) continue;
      scene.position[kept] = scene.position[i];
      scene.velocity[kept] = scene.velocity[i];
      scene.volume[kept] = scene.volume[i];
      scene.body[kept] = scene.body[i];
      if (warm) scene.temperature[kept] = scene.temperature[i];
      ++kept;
    }
    body.count = static_cast<std::uint32_t>(kept) - body.first;
    if (body.count == body.sites && body.sites > 0) body.extent.setEmpty();
  }
  scene.position.resize(kept);
  scene.velocity.resize(kept);
  scene.volume.resize(kept);
  scene.body.resize(kept);
  if (warm) scene.temperature.resize(kept);
  scene.position.shrink_to_fit();
  scene.velocity.shrink_to_fit();
  scene.volume.shrink_to_fit();
  scene.body.shrink_to_fit();
  scene.temperature.shrink_to_fit();
}

double fall_height(const Scene& scene, const std::vector<bool>& moves, int axis, double up) {
  Vector3d low = Vector3d::Constant(1e30), high = -low;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    if (!moves[scene.body[i]]) continue;
    low = low.cwiseMin(scene.position[i]);
    high = high.cwiseMax(scene.position[i]);
  }
  if (!(low.x() <= high.x())) return 0;
  const double bottom = up > 0 ? low[axis] : -high[axis];
  double floor = -1e30;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    if (scene.bodies[scene.body[i]].type != BodyKind::fixed) continue;
    const Vector3d& x = scene.position[i];
    bool below = up * x[axis] < bottom;
    for (int a = 0; a < 3; ++a) below = below && (a == axis || (x[a] >= low[a] && x[a] <= high[a]));
    if (below) floor = std::max(floor, up * x[axis]);
  }
  const double gap = floor > -1e29 ? std::max(0.0, bottom - floor - scene.spacing) : 0;
  return high[axis] - low[axis] + scene.spacing + gap;
}

}  // namespace palp
