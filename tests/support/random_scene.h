// Random scenes that hold one of everything: two fluids of different density, a wall whose surface moves, a rigid body
// and a proxy that touch each other. Particles sit on a jittered lattice.
#pragma once

#include "sim_server/solver/simulation.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace palp::test {

// A body of given particles. Its frame lies away from its centre of mass and is turned.
inline std::uint32_t add_points(Scene& scene, const std::string& name, BodyKind type, std::uint32_t material,
                                const std::vector<Eigen::Vector3d>& points, Random& random) {
  Body body;
  body.name = name;
  body.type = type;
  body.material = material;
  body.first = static_cast<std::uint32_t>(scene.position.size());
  body.count = static_cast<std::uint32_t>(points.size());
  const double volume = std::pow(scene.spacing, 3), density = scene.config.materials[material].density;
  const double m = volume * density;
  body.volume = volume * static_cast<double>(points.size());
  body.mass = m * static_cast<double>(points.size());
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& x : points) center += x / static_cast<double>(points.size());
  body.orientation = random_rotation(random);
  body.center = random_vector(random, scene.spacing);
  body.position = center - body.orientation * body.center;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& x : points) {
    const Eigen::Vector3d r = x - center;
    inertia += m * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose() +
                    scene.spacing * scene.spacing / 6 * Eigen::Matrix3d::Identity());
  }
  const Eigen::Matrix3d R = body.orientation.toRotationMatrix();
  body.inertia = R.transpose() * inertia * R;
  body.velocity = random_vector(random, 0.2);
  if (type == BodyKind::rigid) body.angular_velocity = random_vector(random, 0.5);
  const auto index = static_cast<std::uint32_t>(scene.bodies.size());
  for (const Eigen::Vector3d& x : points) {
    scene.position.push_back(x);
    scene.velocity.push_back(type == BodyKind::fluid ? random_vector(random, 0.3)
                                                     : body.velocity + body.angular_velocity.cross(x - center));
    scene.volume.push_back(volume);
    scene.body.push_back(index);
  }
  scene.bodies.push_back(body);
  return index;
}

struct RandomSceneOptions {
  Method method = Method::accurate;
  std::array<bool, 3> periodic{};
  double jitter = 0.15;  // of a spacing
  double spray = 0;      // the share of the fluids' particles that are missing
  bool solids = true;
};

// 10 x 10 x 9 lattice cells of 0.1 m.
inline Scene random_scene(Random& random, const RandomSceneOptions& options) {
  constexpr double dx = 0.1;
  Scene scene = empty_scene(dx, {-0.4, -0.5, -0.1}, {0.6, 0.5, 0.9});
  SceneConfig& config = scene.config;
  config.method = options.method;
  config.periodic = options.periodic;
  config.gravity = {0.4, -0.3, -9.7};
  config.body_force = {0.2, 0, 0};
  config.numerics.support_over_spacing = 2.3;
  config.numerics.sound_speed = 15;
  config.numerics.max_speed = 3;
  config.numerics.artificial_viscosity = 0.1;
  config.numerics.density_diffusion = 0.1;
  config.numerics.sub_steps = 1;
  config.rate_hz = 500;
  const auto water = add_material(scene, 1000, 3), oil = add_material(scene, 700, 8),
             wood = add_material(scene, 600, 2), stone = add_material(scene, 2000, 5);
  std::vector<Eigen::Vector3d> points[5];
  for (int k = 0; k < 9; ++k)
    for (int j = 0; j < 10; ++j)
      for (int i = 0; i < 10; ++i) {
        const bool floor = k < 2, in_box = j >= 3 && j < 6 && k >= 2 && k < 5;
        const int which = floor ? 4 : in_box && i >= 2 && i < 5 ? 2 : in_box && i >= 5 && i < 7 ? 3 : k < 6 ? 0 : 1;
        if (!options.solids && which > 1) continue;
        if (options.spray > 0 && which < 2 && uniform(random, 0, 1) < options.spray) continue;
        points[which].push_back(scene.bounds_min + dx * Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.5) +
                                random_vector(random, options.jitter * dx));
      }
  add_points(scene, "water", BodyKind::fluid, water, points[0], random);
  add_points(scene, "oil", BodyKind::fluid, oil, points[1], random);
  if (!options.solids) return scene;
  add_points(scene, "box", BodyKind::rigid, wood, points[2], random);
  const auto tool = add_points(scene, "tool", BodyKind::rigid, stone, points[3], random);
  const auto floor = add_points(scene, "floor", BodyKind::fixed, stone, points[4], random);
  ProbeConfig probe;
  probe.name = "floor";
  probe.quantity = Quantity::body;
  probe.body = scene.bodies[floor].name;
  config.probes.push_back(probe);
  Proxy proxy;
  proxy.body = tool;
  proxy.handle = random_vector(random, 0.1);
  proxy.limit = {1e6, 1e4, 1e5, 1e3};
  scene.proxies.push_back(proxy);
  return scene;
}

// A device near the proxy's handle, moving, with gains that matter within a step.
inline StepInput random_input(Random& random, const Scene& scene) {
  StepInput input;
  for (std::size_t p = 0; p < scene.proxies.size(); ++p) {
    const Body& body = scene.bodies[scene.proxies[p].body];
    DeviceInput& in = input[p];
    in.engaged = true;
    in.state.position = body.position + body.orientation * scene.proxies[p].handle + random_vector(random, 0.01);
    in.state.orientation =
        Eigen::Quaterniond(Eigen::AngleAxisd(0.2, random_vector(random, 1).normalized())) * body.orientation;
    in.state.linear = random_vector(random, 0.3);
    in.state.angular = random_vector(random, 1);
    in.gains = {3e4, 200, 300, 4};
  }
  return input;
}

}  // namespace palp::test
