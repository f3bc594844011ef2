#include "tools/haptic_bench/bench_scenes.h"

#include <cmath>

namespace palp::bench {

namespace {

using Vec3 = Eigen::Vector3d;

constexpr double kToolEdge = 0.05;    // [m]
constexpr double kBallRadius = 0.03;  // [m]
constexpr double kNoLimit = 1e5;      // of a coupling's gains

MaterialConfig material(const std::string& name, double density) {
  MaterialConfig m;
  m.name = name;
  m.density = density;
  m.where = "palp-haptic-bench";
  return m;
}

ShapeConfig shape(ShapeType type, const Vec3& position) {
  ShapeConfig s;
  s.type = type;
  s.position = position;
  s.where = "palp-haptic-bench";
  return s;
}

ShapeConfig box(const Vec3& low, const Vec3& high) {
  ShapeConfig s = shape(ShapeType::box, (low + high) / 2);
  s.size = high - low;
  return s;
}

ShapeConfig ball(double radius) {
  ShapeConfig s = shape(ShapeType::sphere, Vec3::Zero());
  s.radius = radius;
  return s;
}

BodyConfig body(const std::string& name, BodyKind type, const std::string& of, const ShapeConfig& solid) {
  BodyConfig b;
  b.name = name;
  b.type = type;
  b.material = of;
  b.shapes = {solid};
  b.where = "palp-haptic-bench";
  return b;
}

SceneConfig empty(const std::string& name, double spacing, const Vec3& low, const Vec3& high) {
  SceneConfig c;
  c.path = c.name = name;
  c.accuracy = Accuracy::fast;
  c.gravity.setZero();
  c.domain_min = low;
  c.domain_max = high;
  c.numerics.spacing = spacing;
  return c;
}

void add_tool(SceneConfig& c, const ShapeConfig& solid, double volume, const Vec3& position) {
  c.materials.push_back(material("tool", kToolMass / volume));
  BodyConfig tool = body("tool", BodyKind::rigid, "tool", solid);
  tool.position = position;
  c.bodies.push_back(tool);
  ProxyConfig proxy;
  proxy.body = "tool";
  proxy.coupling_limit = {kNoLimit, kNoLimit, kNoLimit, kNoLimit};
  proxy.where = "palp-haptic-bench";
  c.proxies.push_back(proxy);
}

void add_cube(SceneConfig& c, double floor) {
  const Vec3 half = Vec3::Constant(kToolEdge / 2);
  add_tool(c, box(-half, half), std::pow(kToolEdge, 3), {0, 0, floor + kGap + kToolEdge / 2});
}

void add_ball(SceneConfig& c, const Vec3& position) {
  add_tool(c, ball(kBallRadius), 4 * M_PI / 3 * std::pow(kBallRadius, 3), position);
}

}  // namespace

Scene wall_scene() {
  SceneConfig c = empty("wall", 0.025, {-0.2, -0.2, -0.1}, {0.2, 0.2, 0.2});
  c.materials.push_back(material("plate", 2000));
  c.bodies.push_back(body("plate", BodyKind::fixed, "plate", box({-0.1, -0.1, -0.025}, {0.1, 0.1, 0})));
  add_cube(c, 0);
  return sample_scene(c, kMostParticles);
}

Scene vise_scene() {
  constexpr double half = 0.025, length = 0.2, thick = 0.025, inner = half + kSlack;
  SceneConfig c = empty("vise", 0.025, {-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2});
  c.materials.push_back(material("jaw", 2000));
  for (const double side : {-1.0, 1.0}) {
    const Vec3 middle(side * (inner + thick / 2), 0, 0), size(thick, length + 0.05, 0.1);
    c.bodies.push_back(
        body(side < 0 ? "left" : "right", BodyKind::fixed, "jaw", box(middle - size / 2, middle + size / 2)));
  }
  const Vec3 bar(half, length / 2, half);
  add_tool(c, box(-bar, bar), 4 * half * half * length, Vec3::Zero());
  return sample_scene(c, kMostParticles);
}

Scene elastic_scene() {
  constexpr double spacing = 0.02, top = 0.06;
  SceneConfig c = empty("elastic", spacing, {-0.15, -0.15, -0.1}, {0.3, 0.15, 0.3});
  c.materials.push_back(material("plate", 2000));
  MaterialConfig jelly = material("jelly", 1000);
  jelly.young_modulus = 2e4;
  jelly.damping = 20;
  c.materials.push_back(jelly);
  c.bodies.push_back(body("plate", BodyKind::fixed, "plate", box({-0.06, -0.06, -0.02}, {0.06, 0.06, 0})));
  c.bodies.push_back(body("post", BodyKind::fixed, "plate", box({0.1, -0.06, 0.04}, {0.22, 0.06, top})));
  BodyConfig block = body("block", BodyKind::elastic, "jelly", box({-0.05, -0.05, 0}, {0.05, 0.05, top}));
  block.bonded_to = {"plate"};
  c.bodies.push_back(block);
  add_cube(c, top);
  return sample_scene(c, kMostParticles);
}

Scene current_scene() {
  constexpr double half = 0.08;
  SceneConfig c = empty("current", 0.02, Vec3::Constant(-half), Vec3::Constant(half));
  c.periodic = {true, true, true};
  c.numerics.max_speed = 0.5;
  MaterialConfig syrup = material("syrup", 1000);
  syrup.viscosity = 10;
  c.materials.push_back(syrup);
  c.bodies.push_back(body("syrup", BodyKind::fluid, "syrup", box(Vec3::Constant(-half), Vec3::Constant(half))));
  ShapeConfig hole = ball(kBallRadius);
  hole.subtract = true;
  c.bodies[0].shapes.push_back(hole);
  add_ball(c, Vec3::Zero());
  return sample_scene(c, kMostParticles);
}

Scene tank_scene() {
  constexpr double half = 0.08, deep = 0.08, wall = 0.04;
  SceneConfig c = empty("tank", 0.02, {-half - wall, -half - wall, -wall}, {half + wall, half + wall, 0.3});
  c.gravity = {0, 0, -9.81};
  c.gravity_ramp = 0.5;
  c.materials.push_back(material("water", 1000));
  c.materials.push_back(material("steel", 7800));
  BodyConfig tray = body("tray", BodyKind::fixed, "steel",
                         box({-half - wall, -half - wall, -wall}, {half + wall, half + wall, deep + 0.04}));
  ShapeConfig inside = box({-half, -half, 0}, {half, half, 0.2});
  inside.subtract = true;
  tray.shapes.push_back(inside);
  c.bodies.push_back(tray);
  BodyConfig water = body("water", BodyKind::fluid, "water", box({-half, -half, 0}, {half, half, deep}));
  ShapeConfig hole = ball(kBallRadius);
  hole.position = {0, 0, deep};
  hole.subtract = true;
  water.shapes.push_back(hole);
  c.bodies.push_back(water);
  add_ball(c, {0, 0, deep});
  return sample_scene(c, kMostParticles);
}

}  // namespace palp::bench
