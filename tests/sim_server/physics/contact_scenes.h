// Scenes of solids that touch, and what is kept when they do.
#pragma once

#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scene_builder.h"

namespace palp::test {

inline constexpr double kGravity = 9.81;

inline SceneConfig contact_scene(double spacing, double friction, double restitution) {
  SceneConfig config = scene(spacing);
  config.gravity = {0, 0, -kGravity};
  config.materials[0].friction = config.materials[0].kinetic_friction = friction;
  config.materials[0].restitution = restitution;
  return config;
}

// A scene with a material that freezes at 300 K, and nothing that conducts.
inline SceneConfig frozen_scene(double friction) {
  SceneConfig config = contact_scene(0.01, friction, 0.2);
  MaterialConfig& m = config.materials[0];
  m.heat_capacity = 1000;
  MaterialConfig ice = m;
  ice.name = "ice";
  ice.viscosity = 0.1;
  ice.young_modulus = 2e4;
  ice.poisson_ratio = 0.3;
  ice.damping = 5;
  ice.conductivity = 1e-6;
  ice.melting_temperature = 300;
  ice.latent_heat = 2000;
  config.materials.push_back(ice);
  return config;
}

inline BodyConfig at_temperature(BodyConfig config, double temperature) {
  config.temperature = temperature;
  return config;
}

inline BodyConfig of_ice(BodyConfig config, double temperature) {
  config.material = "ice";
  return at_temperature(config, temperature);
}

inline Scene sampled(const SceneConfig& config) { return sample_scene(config, 1000000); }

inline BodyConfig at(BodyConfig config, const Eigen::Vector3d& position,
                     const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero()) {
  config.position = position;
  config.velocity = velocity;
  return config;
}

inline void run(Simulation& simulation, double seconds) {
  const long steps = std::lround(seconds * 1000);
  for (long k = 0; k < steps; ++k) {
    const StepOutput& out = simulation.step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
  }
}

// A block, body 1, on a level plate that is then tilted: how long the block rests first, how long the tilting takes,
// because a jerk would let the block slip, and how long it slides after that [s].
struct Tilt {
  double rest, tilting, sliding;
};

struct Slide {
  double way, speed;  // along x: since the plate was tilted [m]; at the end [m/s]
};

inline Slide slide(const Scene& scene, double slope, const Tilt& tilt) {
  const auto simulation = simulate(scene);
  const RigidState& block = simulation->output().bodies[1].state;
  run(*simulation, tilt.rest);
  const double start = block.position.x();
  const int steps = std::max(1, static_cast<int>(std::lround(tilt.tilting * 100)));
  for (int k = 1; k <= steps; ++k) {
    const double angle = slope * k / steps;
    simulation->set_parameter(
        "gravity", std::to_string(kGravity * std::sin(angle)) + " 0 " + std::to_string(-kGravity * std::cos(angle)));
    run(*simulation, k < steps ? 0.01 : tilt.sliding);
  }
  return {block.position.x() - start, block.linear.x()};
}

// A tool with a flat face, the last body, that a soft hand holds 1 mm above its place of contact.
inline void add_flat_tool(SceneConfig& config, const Eigen::Quaterniond& orientation) {
  BodyConfig tool = at(body("tool", BodyKind::rigid, box({0.05, 0.05, 0.05})), {-0.15, 0, 0.026});
  tool.orientation = orientation;
  config.bodies.push_back(tool);
  ProxyConfig proxy;
  proxy.body = "tool";
  config.proxies.push_back(proxy);
}

// The extremes of a force while the tool is drawn [N].
struct Extent {
  double low = 1e30, high = -1e30;
  void take(double f) {
    low = std::min(low, f);
    high = std::max(high, f);
  }
  double ripple() const { return (high - low) / low; }
};

// Amplitude of a curve's part of so many cycles a sample, seen through Hann's window.
inline double spectral_line(const std::vector<double>& y, double cycles) {
  double mean = 0, weights = 0;
  for (const double value : y) mean += value / static_cast<double>(y.size());
  std::complex<double> sum = 0;
  for (std::size_t k = 0; k < y.size(); ++k) {
    const double t = static_cast<double>(k), w = 1 - std::cos(2 * M_PI * (t + 0.5) / static_cast<double>(y.size()));
    sum += w * (y[k] - mean) * std::polar(1.0, -2 * M_PI * cycles * t);
    weights += w;
  }
  return 2 * std::abs(sum) / weights;
}

struct DrawnTool {
  Extent felt, contact;         // upwards
  double across = 0;            // the most that contact pushes along the way
  std::vector<double> pressed;  // contact upwards, at each millisecond
};

inline constexpr double kDrawSpeed = 0.2;

// The hand, at a height that presses the tool down with about 5 N, draws it along x with 0.2 m/s for up to 1.5 s.
inline DrawnTool draw_flat_tool(Simulation& simulation, const Eigen::Quaterniond& orientation, double height = 0.02,
                                double seconds = 1.5) {
  DrawnTool drawn;
  StepInput input;
  input[0].engaged = true;
  input[0].state.orientation = orientation;
  input[0].gains = {1000, 20, 10, 0.2};
  for (int k = 0; k < 500 + 1000 * seconds; ++k) {
    const double t = std::max(0, k - 500) * 1e-3;
    input[0].state.position = {-0.15 + kDrawSpeed * t, 0, height};
    input[0].state.linear = {k < 500 ? 0 : kDrawSpeed, 0, 0};
    const StepOutput& out = simulation.step(input);
    EXPECT_TRUE(out.health.ok) << out.health.cause;
    if (!out.health.ok) return drawn;
    if (k < 800) continue;
    drawn.felt.take(out.proxies[0].force.z());
    drawn.contact.take(out.proxies[0].contact_force.z());
    drawn.across = std::max(drawn.across, std::abs(out.proxies[0].contact_force.x()));
    drawn.pressed.push_back(out.proxies[0].contact_force.z());
  }
  return drawn;
}

struct Momenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  double linear_size = 0, angular_size = 0;
};

// Returns the momenta of the rigid bodies.
inline Momenta momenta(const Scene& scene, const StepOutput& out) {
  Momenta m;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& from = scene.bodies[b];
    const RigidState& s = out.bodies[b].state;
    const Eigen::Vector3d center = s.position + s.orientation * from.center;
    const Eigen::Vector3d p = from.mass * (s.linear + s.angular.cross(s.orientation * from.center));
    const Eigen::Vector3d L =
        center.cross(p) + s.orientation * (from.inertia * (s.orientation.conjugate() * s.angular));
    m.linear += p;
    m.angular += L;
    m.linear_size += p.norm();
    m.angular_size += L.norm();
  }
  return m;
}

// Returns the momenta of the particles of elastic bodies, which are of the first material; angular_size is not set.
inline Momenta elastic_momenta(const Scene& scene, const Snapshot& s) {
  Momenta m;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    if (scene.bodies[scene.body[i]].type != BodyKind::elastic) continue;
    const Eigen::Vector3d x(s.position[3 * i], s.position[3 * i + 1], s.position[3 * i + 2]);
    const Eigen::Vector3d p = scene.volume[i] * scene.config.materials[0].density *
                              Eigen::Vector3d(s.velocity[3 * i], s.velocity[3 * i + 1], s.velocity[3 * i + 2]);
    m.linear += p;
    m.angular += x.cross(p);
    m.linear_size += p.norm();
  }
  return m;
}

// Returns the energy of the rigid bodies, that of their places in gravity included [J].
inline double energy(const Scene& scene, const StepOutput& out) {
  double sum = 0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& from = scene.bodies[b];
    if (from.type != BodyKind::rigid) continue;
    const RigidState& s = out.bodies[b].state;
    const Eigen::Vector3d arm = s.orientation * from.center, w = s.orientation.conjugate() * s.angular;
    sum += 0.5 * from.mass * (s.linear + s.angular.cross(arm)).squaredNorm() + 0.5 * w.dot(from.inertia * w);
    sum -= from.mass * scene.config.gravity.dot(s.position + arm);
  }
  return sum;
}

// Adds the material "soft", 1e5 Pa, otherwise as the first one; damping [Pa s].
inline void add_soft(SceneConfig& config, double damping) {
  MaterialConfig soft = config.materials[0];
  soft.name = "soft";
  soft.young_modulus = 1e5;
  soft.poisson_ratio = 0.3;
  soft.damping = damping;
  config.materials.push_back(soft);
}

}  // namespace palp::test
