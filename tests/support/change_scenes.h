// Scenes of matter that melts, freezes and sets.
#pragma once

#include "tests/support/backend.h"
#include "tests/support/scene_files.h"
#include "tests/support/scenes.h"

namespace palp::test {

inline constexpr double kSpacing = 0.01;
inline constexpr double kMelting = 300;  // [K]
inline constexpr double kCapacity = 1000, kLatent = 2000;

// Stuff that melts; weightless unless a test says otherwise. Conducts so little that every particle keeps what it gets.
inline Scene melting_scene(double young = 2e4) {
  Scene scene = empty_scene(kSpacing, {-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3});
  scene.config.gravity.setZero();
  scene.config.numerics.max_speed = 1;
  scene.config.numerics.tension = false;
  add_material(scene, 1000, 0.1);
  MaterialConfig& m = scene.config.materials[0];
  m.young_modulus = young;
  m.damping = 1;
  m.conductivity = 1e-6;
  m.heat_capacity = kCapacity;
  m.melting_temperature = kMelting;
  m.latent_heat = kLatent;
  return scene;
}

// Over the whole scene, between two times [s]: as much as melts (freezes, when negative) so many kg.
inline void add_heat(Scene& scene, double kg, double start, double end) {
  HeatZoneConfig zone;
  zone.name = std::to_string(scene.config.heat_zones.size());
  zone.position.setZero();
  zone.size.setConstant(2);
  zone.power = kg * kLatent / (end - start);
  zone.start = start;
  zone.end = end;
  scene.config.heat_zones.push_back(zone);
}

inline double mass_of(const Scene& scene) {
  return 1000 * scene.volume[0] * static_cast<double>(scene.position.size());
}

struct Motion {
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero(), spin = momentum;
  double kinetic = 0;
};

inline Motion motion_of(const Scene& scene, const Snapshot& s) {
  Motion sum;
  for (std::size_t i = 0; i < scene.position.size(); ++i) {
    const double m = 1000 * scene.volume[i];
    const Eigen::Vector3d x = Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>();
    const Eigen::Vector3d v = Eigen::Map<const Eigen::Vector3f>(&s.velocity[3 * i]).cast<double>();
    sum.momentum += m * v;
    sum.spin += m * x.cross(v);
    sum.kinetic += 0.5 * m * v.squaredNorm();
  }
  return sum;
}

inline Snapshot snapshot_of(Simulation& simulation) {
  Snapshot s;
  simulation.snapshot(s);
  return s;
}

inline Scene on_a_floor(BodyKind type, double temperature) {
  Scene scene = melting_scene();
  scene.config.gravity = {0, 0, -9.81};
  scene.config.numerics.max_speed.reset();
  add_material(scene, 1000, 0.1);
  scene.config.materials[1].heat_capacity = kCapacity;
  add_body(scene, "floor", BodyKind::fixed, 1, {-0.15, -0.15, -0.03}, {0.15, 0.15, 0});
  add_body(scene, "stuff", type, 0, {-0.03, -0.03, 0}, {0.03, 0.03, 0.06});
  for (const std::uint32_t b : scene.body) scene.temperature.push_back(b == 0 ? kMelting : temperature);
  return scene;
}

}  // namespace palp::test
