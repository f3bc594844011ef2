// A box whose lid moves along itself over the fluid that fills it.
#pragma once

#include "tests/support/scenes.h"

namespace palp::test {

struct BoxWithLid {
  double length = 1;  // of an edge [m]
  double spacing = 1.0 / 40;
  double viscosity = 10;  // [Pa s], with a density of 1000 kg/m^3
  bool by_geometry = true;
};

// Returns the box, [0, length] along x and z and periodic along y, with a lid between its walls that moves along x at
// 1 m/s. Its first body is the fluid.
inline Scene box_with_lid(const BoxWithLid& box) {
  const double L = box.length, deep = 9 * box.spacing, wall = 4 * box.spacing;
  Scene scene = empty_scene(box.spacing, {-wall, 0, -wall}, {L + wall, deep, L + wall});
  SceneConfig& config = scene.config;
  config.periodic = {false, true, false};
  config.gravity.setZero();
  config.rate_hz = 100;
  config.numerics.support_over_spacing = 3;
  config.numerics.artificial_viscosity = 0;
  config.numerics.max_speed = 1;
  const auto oil = add_material(scene, 1000, box.viscosity);
  add_body(scene, "oil", BodyKind::fluid, oil, {0, 0, 0}, {L, deep, L});
  const auto walls = add_body(scene, "walls", BodyKind::fixed, oil, {-wall, 0, -wall}, {L + wall, deep, L + wall},
                              [=](const Eigen::Vector3d& x) { return x.z() < 0 || x.x() < 0 || x.x() > L; });
  const auto lid = add_body(scene, "lid", BodyKind::fixed, oil, {0, 0, L}, {L, deep, L + wall});
  scene.bodies[lid].velocity = {1, 0, 0};
  for (std::uint32_t i = 0; i < scene.bodies[lid].count; ++i) scene.velocity[scene.bodies[lid].first + i].x() = 1;
  if (!box.by_geometry) return scene;
  ShapeConfig room = box_between({0, 0, 0}, {L, deep, L + wall});
  room.subtract = true;
  give_shapes(scene, walls, {box_between({-wall, 0, -wall}, {L + wall, deep, L + wall}), room});
  give_shapes(scene, lid, {box_between({0, 0, L}, {L, deep, L + wall})});
  return scene;
}

}  // namespace palp::test
