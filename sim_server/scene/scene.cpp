#include "sim_server/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "config/looks.h"
#include "sim_server/geometry/contact_shape.h"
#include "sim_server/geometry/solid.h"
#include "sim_server/geometry/surface.h"
#include "sim_server/scene/open_sides.h"
#include "sim_server/scene/packing.h"
#include "sim_server/scene/particle_csv.h"
#include "sim_server/scene/particle_reason.h"
#include "sim_server/scene/sampling.h"
#include "sim_server/scene/scene_checks.h"
#include "sim_server/scene/scene_heat.h"
#include "sim_server/scene/thick_walls.h"

namespace palp {

namespace {

// A particle's share of the arrays in Scene.
constexpr double kBytesPerParticle = 2 * sizeof(Eigen::Vector3d) + 2 * sizeof(double) + sizeof(std::uint32_t);
constexpr double kThickWall = 2;  // of method "paper", whose particles keep others out in two layers [spacings]

// A body that does not fit into what the bodies before it left.
struct BodyTooLarge {
  double needed;  // particles, about
};

std::string too_many(const SceneConfig& config, double needed, std::size_t max_particles) {
  const double spacing = *config.numerics.spacing;
  return fmt::format(
      "{}: the scene needs about {:.3g} particles at spacing {:g} m ({:.3g} GB for the host's copy alone), "
      "and memory here allows {}; a spacing of {:.2g} m would fit",
      config.path, needed, spacing, needed * kBytesPerParticle / 1e9, max_particles,
      1.05 * spacing * std::cbrt(needed / static_cast<double>(max_particles)));
}

// Returns the material of a body, or null where it is not declared.
const MaterialConfig* material_of(const SceneConfig& config, const BodyConfig& body) {
  const auto found = std::find_if(config.materials.begin(), config.materials.end(),
                                  [&](const MaterialConfig& item) { return item.name == body.material; });
  return found == config.materials.end() ? nullptr : &*found;
}

Body start_body(const SceneConfig& config, const BodyConfig& from) {
  Body body;
  body.name = from.name;
  body.type = from.type;
  const MaterialConfig* material = material_of(config, from);
  if (material == nullptr) {
    throw ConfigError(
        fmt::format("{}: body '{}': material '{}' is not declared", from.where, from.name, from.material));
  }
  body.material = static_cast<std::uint32_t>(material - config.materials.data());
  body.position = from.position;
  body.orientation = from.orientation.normalized();
  body.velocity = from.velocity;
  body.angular_velocity = from.angular_velocity;
  body.holds_temperature = from.hold_temperature;
  body.temperature = from.temperature;
  for (std::uint32_t b = 0; b < config.bodies.size(); ++b) {
    if (std::find(from.bonded_to.begin(), from.bonded_to.end(), config.bodies[b].name) != from.bonded_to.end())
      body.bonded_to.push_back(b);
  }
  const ColoredLook look = look_of(from.type, *material, from.look, from.color);
  body.color = look.color;
  body.look = look.look;
  const ColoredLook changed = changed_look_of(from.type, *material, look);
  body.changed_color = changed.color;
  body.changed_look = changed.look;
  return body;
}

// Loose particles as small cubes, for volume and inertia.
Moments moments_of(const Particles& particles) {
  Moments sum;
  for (std::size_t i = 0; i < particles.position.size(); ++i) {
    sum += box_moments(Eigen::Vector3d::Constant(std::cbrt(particles.volume[i])))
               .moved(Eigen::Isometry3d(Eigen::Translation3d(particles.position[i])));
  }
  return sum;
}

void move(Particles& particles, const Eigen::Isometry3d& pose) {
  for (Eigen::Vector3d& p : particles.position) p = pose * p;
  for (Eigen::Vector3d& v : particles.velocity) v = pose.linear() * v;
}

// Returns whether any solid, or what can become one, can run into another, keeps a fluid out, or bounds heat.
bool needs_distances(const SceneConfig& config) {
  std::size_t moving = 0, solids = 0;
  for (const BodyConfig& body : config.bodies) {
    const MaterialConfig* m = material_of(config, body);
    if (body.temperature && (body.hold_temperature || (m != nullptr && m->conductivity == 0))) return true;
    const bool sets = m != nullptr && m->young_modulus && (m->melting_temperature || m->cooking_temperature);
    const bool solid = body.type != BodyKind::fluid || sets;
    moving += solid && body.type != BodyKind::fixed ? 1 : 0;
    solids += solid ? 1 : 0;
    if (body.type == BodyKind::fluid) return true;
  }
  return moving > 0 && solids > 1;
}

// Returns in which of a body's shapes no particle lies, one sentence each.
std::vector<std::string> thin_shapes(const BodyConfig& from, const Solid& solid, const Particles& particles,
                                     double spacing) {
  if (particles.position.empty())
    return {fmt::format("{}: body '{}' holds no particle at spacing {:g} m; make it larger or the spacing finer",
                        from.where, from.name, spacing)};
  std::vector<std::string> out;
  for (const std::size_t part : empty_parts(solid, particles))
    out.push_back(
        fmt::format("{}: this shape of body '{}' holds no particle at spacing {:g} m; make it thicker or the "
                    "spacing finer",
                    from.shapes[part].where, from.name, spacing));
  return out;
}

// Particles in the body frame; for a solid body also its volume, mass properties and surface. thin: thin_shapes().
Particles sample_body(const SceneConfig& config, const BodyConfig& from, std::size_t room, Body& body,
                      std::optional<Solid>& solid, std::vector<std::string>& thin) {
  const double spacing = *config.numerics.spacing;
  const ShapeConfig& first = from.shapes.front();
  Particles particles;
  Moments moments;
  if (first.type == ShapeType::particles) {
    particles = read_particle_csv(first.file, spacing * spacing * spacing, room);
    move(particles, Eigen::Translation3d(first.position) * first.orientation.normalized());
    moments = moments_of(particles);
    body.lattice.reset();
  } else {
    const bool by_particles = body.type == BodyKind::fixed && config.method == Method::paper;
    solid = make_solid(by_particles ? with_thick_walls(from.shapes, kThickWall * spacing) : from.shapes);
    moments = solid_moments(*solid);
    const double expected = moments.volume / (spacing * spacing * spacing);
    const double most = static_cast<double>(room);
    if (expected > 1.5 * most + 1000) throw BodyTooLarge{expected};
    particles = fill_solid(*solid, moments.volume, spacing, room);
    if (particles.position.size() > room) throw BodyTooLarge{std::max(expected, most)};
    thin = thin_shapes(from, *solid, particles, spacing);
    const bool matter = body.type == BodyKind::fluid || body.type == BodyKind::elastic;
    if (!thin.empty() && matter) throw ConfigError(thin);
    move(particles, solid->frame);
    body.lattice = Eigen::Quaterniond(solid->frame.linear());
    moments = moments.moved(solid->frame);
    if (body.type == BodyKind::rigid || body.type == BodyKind::fixed) body.surface = solid_surface(*solid, spacing / 2);
    if (body.type == BodyKind::elastic) body.skin = solid_surface(*solid, spacing / 2);
    if (particles.position.empty())
      for (const Eigen::Vector3d& corner : body.surface.vertices)
        body.extent.extend(Eigen::Vector3d(body.orientation.conjugate() * body.position + corner));
    if (!body.surface.triangles.empty() && config.method == Method::accurate && needs_distances(config))
      body.contact = make_contact_shape(*solid, body.surface, spacing);
    // the particles of a solid that is not filled exactly share its exact volume
    if (body.type != BodyKind::fluid && !particles.exact && !particles.position.empty()) {
      std::fill(particles.volume.begin(), particles.volume.end(),
                moments.volume / static_cast<double>(particles.volume.size()));
    }
  }
  const double density = config.materials[body.material].density;
  body.volume = moments.volume;
  body.mass = density * moments.volume;
  body.center = moments.center();
  body.inertia = density * moments.inertia();
  return particles;
}

void append(Scene& scene, const BodyConfig& from, Body body, const Particles& particles) {
  body.first = static_cast<std::uint32_t>(scene.position.size());
  body.count = body.sites = static_cast<std::uint32_t>(particles.position.size());
  const Eigen::Isometry3d pose = pose_of(body);
  for (std::size_t i = 0; i < particles.position.size(); ++i) {
    scene.position.push_back(pose * particles.position[i]);
    Eigen::Vector3d velocity = body.velocity;
    if (!particles.velocity.empty()) velocity += body.orientation * particles.velocity[i];
    if (body.type == BodyKind::rigid) {
      velocity += body.angular_velocity.cross(body.orientation * (particles.position[i] - body.center));
    }
    scene.velocity.push_back(velocity);
  }
  scene.volume.insert(scene.volume.end(), particles.volume.begin(), particles.volume.end());
  scene.body.resize(scene.position.size(), static_cast<std::uint32_t>(scene.bodies.size()));
  if (!particles.temperature.empty()) {
    scene.temperature.insert(scene.temperature.end(), particles.temperature.begin(), particles.temperature.end());
  } else if (from.temperature) {
    scene.temperature.resize(scene.temperature.size() + body.count, *from.temperature);
  }
  scene.bodies.push_back(std::move(body));
}

// Every body has a temperature, from one source, or none has.
void check_temperature(const BodyConfig& from, const Particles& particles, const Scene& scene,
                       std::vector<std::string>& faults) {
  if (from.temperature && !particles.temperature.empty()) {
    faults.push_back(
        fmt::format("{}: body '{}' has a temperature and so have the particles of its file, expected one of them",
                    from.where, from.name));
  }
  const bool warm = from.temperature || !particles.temperature.empty();
  if (!scene.bodies.empty() && warm != has_temperatures(scene)) {
    faults.push_back(fmt::format("{}: body '{}' has {} temperature, expected one for every body or for none",
                                 from.where, from.name, warm ? "a" : "no"));
  }
}

void add_proxies(Scene& scene) {
  for (const ProxyConfig& from : scene.config.proxies) {
    const auto body = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                                   [&](const Body& item) { return item.name == from.body; });
    if (body == scene.bodies.end() || body->type != BodyKind::rigid) {
      throw ConfigError(fmt::format("{}: proxy: body '{}' is not a rigid body of the scene", from.where, from.body));
    }
    scene.proxies.push_back(
        {from.device, static_cast<std::uint32_t>(body - scene.bodies.begin()), from.handle, from.coupling_limit});
  }
}

}  // namespace

Scene sample_scene(const SceneConfig& config, std::size_t max_particles, const LoadingProgress& progress) {
  if (!config.numerics.spacing) throw ConfigError(config.path + ": the scene has no particle spacing");
  max_particles = std::min<std::size_t>(max_particles, 0xffffffffu);
  Scene scene;
  scene.config = config;
  scene.spacing = *config.numerics.spacing;
  scene.bounds_min = config.domain_min;
  scene.bounds_max = config.domain_max;
  std::vector<std::string> faults;
  std::vector<std::optional<Solid>> solids;
  std::vector<std::vector<std::string>> thin;  // thin_shapes() by body
  std::size_t sampled = 0;
  double left_out = 0;  // particles of bodies that do not fit
  ThreadTeam team;
  const auto tell = [&](const char* doing, double share) {
    if (progress) progress(doing, share);
  };
  for (const BodyConfig& from : config.bodies) {
    tell("filling bodies with particles",
         static_cast<double>(solids.size()) / static_cast<double>(config.bodies.size()));
    Body body = start_body(config, from);
    std::optional<Solid> solid;
    try {
      std::vector<std::string> of_body;
      const Particles particles =
          sample_body(config, from, max_particles - scene.position.size(), body, solid, of_body);
      check_temperature(from, particles, scene, faults);
      append(scene, from, std::move(body), particles);
      solids.push_back(std::move(solid));
      thin.push_back(std::move(of_body));
      ++sampled;
    } catch (const BodyTooLarge& body_too_large) {
      left_out += body_too_large.needed;
    } catch (const ConfigError& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  }
  if (left_out > 0)
    faults.push_back(too_many(config, left_out + static_cast<double>(scene.position.size()), max_particles));
  if (sampled < config.bodies.size()) throw ConfigError(faults);  // where the others are cannot be judged without them
  add_proxies(scene);
  // what acts by its geometry may be thinner than a particle
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const ParticleReason reason = particle_reason(scene, b);
    if (reason == ParticleReason::none || reason == ParticleReason::asked) continue;
    faults.insert(faults.end(), thin[b].begin(), thin[b].end());
  }
  tell("looking for bodies that overlap", 0);
  check_inside_domain(scene, faults);
  check_apart(scene, solids, team, faults);
  if (!faults.empty()) throw ConfigError(faults);
  tell("packing fluids around solids", 0);
  pack_fluids(scene, solids, team, progress);
  tell("looking for particles that overlap", 0);
  check_distances(scene, team, faults);
  if (!faults.empty()) throw ConfigError(faults);
  leave_out_particles(scene);
  scene.runs_off = runs_off(scene, solids, team);
  return scene;
}

}  // namespace palp
