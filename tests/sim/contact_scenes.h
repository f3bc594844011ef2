// Scenes of solids that touch, and what is kept when they do.
#pragma once

#include <cmath>

#include <gtest/gtest.h>

#include "tests/sim/scene_builder.h"
#include "tests/support/backend.h"

namespace palp::testing {

inline constexpr double kGravity = 9.81;

inline SceneConfig contact_scene(double spacing, double friction, double restitution) {
  SceneConfig config = testing_support::scene(spacing);
  config.gravity = {0, 0, -kGravity};
  config.materials[0].friction = config.materials[0].kinetic_friction = friction;
  config.materials[0].restitution = restitution;
  return config;
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

struct Momenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  double linear_size = 0, angular_size = 0;
};

// Of rigid bodies.
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

// Of rigid bodies, with that of their places in gravity [J].
inline double energy(const Scene& scene, const StepOutput& out) {
  double sum = 0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& from = scene.bodies[b];
    if (from.type != BodyType::rigid) continue;
    const RigidState& s = out.bodies[b].state;
    const Eigen::Vector3d arm = s.orientation * from.center, w = s.orientation.conjugate() * s.angular;
    sum += 0.5 * from.mass * (s.linear + s.angular.cross(arm)).squaredNorm() + 0.5 * w.dot(from.inertia * w);
    sum -= from.mass * scene.config.gravity.dot(s.position + arm);
  }
  return sum;
}

}  // namespace palp::testing
