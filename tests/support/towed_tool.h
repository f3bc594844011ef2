// A tool of wood, 30 by 60 by 60 mm, that a hand tows along x through fluid in a periodic box, past a wall at its end.
#pragma once

#include "sim_server/solver/simulation.h"
#include "tests/support/scenes.h"

namespace palp::test {

// The tool is body 2, behind the fluid and the wall. length: of the box along x [m]. viscosity: of the fluid [Pa s].
inline Scene towed_tool(double length, double viscosity) {
  Scene scene = empty_scene(0.01, {0, 0, 0}, {length, 0.12, 0.12});
  scene.config.periodic = {true, true, true};
  scene.config.gravity.setZero();
  scene.config.numerics.support_over_spacing = 2;
  const auto fluid = add_material(scene, 1000, viscosity), wood = add_material(scene, 400, 0);
  const Eigen::Vector3d low(0.06, 0.03, 0.03), high(0.09, 0.09, 0.09);
  const auto inside = [&](const Eigen::Vector3d& x) {
    return (x.array() > low.array()).all() && (x.array() < high.array()).all();
  };
  add_body(scene, "fluid", BodyKind::fluid, fluid, {0, 0, 0}, {length, 0.12, 0.12},
           [&](const Eigen::Vector3d& x) { return !inside(x) && x.x() > 0.02; });
  add_body(scene, "wall", BodyKind::fixed, fluid, {0, 0, 0}, {0.02, 0.12, 0.12});
  Proxy proxy;
  proxy.body = add_body(scene, "tool", BodyKind::rigid, wood, low, high);
  proxy.limit = {1e6, 1e4, 1e5, 1e3};
  scene.proxies.push_back(proxy);
  return scene;
}

// The hand at the start, as fast as it will go [m/s].
inline StepInput towing_hand(const Scene& scene, double speed) {
  StepInput input;
  input[0].engaged = true;
  input[0].gains = {5000, 50, 50, 1};
  input[0].state.position = scene.bodies[2].position;
  input[0].state.linear = {speed, 0, 0};
  return input;
}

}  // namespace palp::test
