#include "sim_server/scene/particle_count.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "sim_server/geometry/solid.h"
#include "sim_server/scene/sampling.h"

namespace palp {
namespace {

constexpr int kTries = 16;              // lattices tried, each half a percent finer and coarser than the one before
constexpr double kCloseEnough = 0.005;  // of the number wanted
constexpr double kManyParticles = 2e5;  // whose number hardly depends on how the lattice meets the faces

bool is_tool(const SceneConfig& config, const std::string& body) {
  return std::any_of(config.proxies.begin(), config.proxies.end(),
                     [&](const ProxyConfig& proxy) { return proxy.body == body; });
}

// By index of the scene's bodies.
std::vector<bool> is_matter(const SceneConfig& config) {
  std::vector<bool> moves, fixed;
  for (const BodyConfig& body : config.bodies) {
    fixed.push_back(body.type == BodyKind::fixed);
    moves.push_back(!fixed.back() && !is_tool(config, body.name));
  }
  return std::find(moves.begin(), moves.end(), true) != moves.end() ? moves : fixed;
}

struct Matter {
  Solid solid;
  double volume = 0;
};

double count(const std::vector<Matter>& matter, double spacing) {
  double sum = 0;
  for (const Matter& part : matter)
    sum += static_cast<double>(fill_solid(part.solid, part.volume, spacing, 0xffffffffu).position.size());
  return sum;
}

}  // namespace

std::size_t matter_particles(const Scene& scene) {
  const std::vector<bool> matter = is_matter(scene.config);
  std::size_t sum = 0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) sum += matter[b] ? scene.bodies[b].sites : 0;
  return sum;
}

double matter_spacing(const SceneConfig& config, std::size_t wanted) {
  const std::vector<bool> counts = is_matter(config);
  std::vector<Matter> matter;
  double volume = 0;
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    const BodyConfig& body = config.bodies[b];
    if (!counts[b]) continue;
    if (body.shapes.front().type == ShapeType::particles) {
      throw ConfigError(fmt::format(
          "{}: the particles of body '{}' are read from a file, expected shapes where their number is to be "
          "chosen",
          body.where, body.name));
    }
    Matter part{make_solid(body.shapes), 0};
    part.volume = solid_moments(part.solid).volume;
    volume += part.volume;
    matter.push_back(std::move(part));
  }
  if (!(volume > 0))
    throw ConfigError(config.path +
                      ": the bodies that particles are to be counted of hold no volume, expected some: make them "
                      "larger, or cut less from them");
  const double start = std::cbrt(volume / static_cast<double>(wanted));
  if (static_cast<double>(wanted) > kManyParticles) return start;
  double best = start, off = 1e300;
  for (int k = 0; k <= kTries && off > kCloseEnough; ++k) {
    for (const double scale : {1 + 0.005 * k, 1 - 0.005 * k}) {
      const double now = std::abs(count(matter, scale * start) / static_cast<double>(wanted) - 1);
      if (now >= off) continue;
      off = now;
      best = scale * start;
    }
  }
  return best;
}

SceneConfig load_scene_with_particles(const std::string& path, SceneOverrides overrides, std::size_t wanted) {
  overrides.spacing = matter_spacing(load_scene(path, overrides), wanted);
  return load_scene(path, overrides);
}

std::string particle_choice(const Scene& scene, std::size_t wanted) {
  const std::vector<bool> matter = is_matter(scene.config);
  std::string names;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    if (matter[b]) names += fmt::format("{}'{}'", names.empty() ? "" : ", ", scene.bodies[b].name);
  return fmt::format("{} particles wanted: a spacing of {:.4g} m gives {} to {}, {} in all", wanted, scene.spacing,
                     matter_particles(scene), names, scene.position.size());
}

}  // namespace palp
