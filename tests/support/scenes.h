// Small scenes in code, so that physics tests need no file: boxes and spheres of particles on a lattice.
#pragma once

#include <cmath>
#include <functional>
#include <string>

#include "sim_server/geometry/contact_shape.h"
#include "sim_server/geometry/surface.h"
#include "sim_server/scene/scene.h"
#include "tests/support/scene_builder.h"

namespace palp::test {

// While one exists, boxes and trays that are added act on fluids by their geometry, as those of scene files do, and not
// by their particles.
class ByGeometry {
 public:
  explicit ByGeometry(bool on = true) : before_(is_on()) { is_on() = on; }
  ~ByGeometry() { is_on() = before_; }
  ByGeometry(const ByGeometry&) = delete;
  ByGeometry& operator=(const ByGeometry&) = delete;
  static bool& is_on() {
    static bool on = false;
    return on;
  }

 private:
  bool before_;
};

// Makes a body act by its geometry: shapes in world axes.
inline void give_shapes(Scene& scene, std::uint32_t index, std::vector<ShapeConfig> shapes) {
  Body& body = scene.bodies[index];
  for (ShapeConfig& shape : shapes) shape.position -= body.position;
  const Solid solid = make_solid(shapes);
  body.surface = solid_surface(solid, scene.spacing / 2);
  body.contact = make_contact_shape(solid, body.surface, scene.spacing);
}

inline ShapeConfig box_between(const Eigen::Vector3d& min, const Eigen::Vector3d& max) {
  return box(max - min, (min + max) / 2);
}

inline Scene empty_scene(double spacing, const Eigen::Vector3d& min, const Eigen::Vector3d& max) {
  Scene scene;
  scene.spacing = spacing;
  scene.config.path = "test";
  scene.config.name = "test";
  scene.config.domain_min = scene.bounds_min = min;
  scene.config.domain_max = scene.bounds_max = max;
  return scene;
}

inline std::uint32_t add_material(Scene& scene, double density, double viscosity) {
  MaterialConfig m;
  m.name = std::to_string(scene.config.materials.size());
  m.density = density;
  m.viscosity = viscosity;
  scene.config.materials.push_back(m);
  return static_cast<std::uint32_t>(scene.config.materials.size() - 1);
}

// Returns a probe of the pose and the wrench of a body.
inline ProbeConfig probe_of(const std::string& body) {
  ProbeConfig probe;
  probe.quantity = Quantity::body;
  probe.body = body;
  return probe;
}

// Fills the cells of a lattice over [min, max] whose centres are inside. The lattice is adjusted to fit the box.
inline std::uint32_t add_body(Scene& scene, const std::string& name, BodyKind type, std::uint32_t material,
                              const Eigen::Vector3d& min, const Eigen::Vector3d& max,
                              const std::function<bool(const Eigen::Vector3d&)>& inside = nullptr) {
  Body body;
  body.name = name;
  body.type = type;
  body.material = material;
  body.first = static_cast<std::uint32_t>(scene.position.size());
  const auto index = static_cast<std::uint32_t>(scene.bodies.size());
  Eigen::Vector3i n;
  Eigen::Vector3d cell;
  for (int a = 0; a < 3; ++a) {
    n[a] = std::max(1, static_cast<int>(std::lround((max[a] - min[a]) / scene.spacing)));
    cell[a] = (max[a] - min[a]) / n[a];
  }
  const double volume = cell.prod(), density = scene.config.materials[material].density;
  for (int k = 0; k < n.z(); ++k)
    for (int j = 0; j < n.y(); ++j)
      for (int i = 0; i < n.x(); ++i) {
        const Eigen::Vector3d x = min + cell.cwiseProduct(Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.5));
        if (inside && !inside(x)) continue;
        scene.position.push_back(x);
        scene.velocity.push_back(Eigen::Vector3d::Zero());
        scene.volume.push_back(volume);
        scene.body.push_back(index);
        body.volume += volume;
        body.center += x * volume;
      }
  body.count = static_cast<std::uint32_t>(scene.position.size()) - body.first;
  body.mass = body.volume * density;
  // the body frame lies in the centre of mass, with world axes
  body.position = body.center / body.volume;
  body.center.setZero();
  body.inertia.setZero();
  for (std::uint32_t p = body.first; p < body.first + body.count; ++p) {
    const Eigen::Vector3d r = scene.position[p] - body.position;
    body.inertia +=
        density * volume *
        (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose() +
         Eigen::Matrix3d(((cell.squaredNorm() * Eigen::Vector3d::Ones() - cell.cwiseAbs2()) / 12).asDiagonal()));
  }
  scene.bodies.push_back(body);
  const bool solid = type == BodyKind::fixed || type == BodyKind::rigid;
  if (solid && !inside && ByGeometry::is_on()) give_shapes(scene, index, {box_between(min, max)});
  return index;
}

// A tray: floor and walls of the given thickness around the box [min, max], open at the top (+z), with the walls
// reaching to max.z. Axes in skip have no walls (periodic).
inline std::uint32_t add_tray(Scene& scene, std::uint32_t material, const Eigen::Vector3d& min,
                              const Eigen::Vector3d& max, double thickness, std::array<bool, 3> skip = {}) {
  Eigen::Vector3d low = min, high = max;
  for (int a = 0; a < 3; ++a) {
    if (skip[a]) continue;
    low[a] -= thickness;
    if (a < 2) high[a] += thickness;
  }
  const std::uint32_t tray = add_body(
      scene, "tray", BodyKind::fixed, material, low, high,
      [=](const Eigen::Vector3d& x) { return !((x.array() > min.array()).all() && (x.array() < max.array()).all()); });
  ShapeConfig room = box_between(min, max);
  room.subtract = true;
  if (ByGeometry::is_on()) give_shapes(scene, tray, {box_between(low, high), room});
  return tray;
}

// A heap of water in an open domain, without walls: 384 particles of 5 cm.
inline Scene pool_of_water() {
  Scene scene = empty_scene(0.05, {-0.5, -0.5, -0.2}, {0.5, 0.5, 0.8});
  add_body(scene, "water", BodyKind::fluid, add_material(scene, 1000, 1e-3), {-0.2, -0.2, 0}, {0.2, 0.2, 0.3});
  return scene;
}

}  // namespace palp::test
