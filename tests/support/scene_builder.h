// Scenes made in tests, without files.
#pragma once

#include <string>

#include "sim_server/scene/scene.h"

namespace palp::test {

inline ShapeConfig box(const Eigen::Vector3d& size, const Eigen::Vector3d& position = Eigen::Vector3d::Zero()) {
  ShapeConfig shape;
  shape.size = size;
  shape.position = position;
  shape.where = "s.toml:2";
  return shape;
}

inline ShapeConfig sphere(double radius, const Eigen::Vector3d& position = Eigen::Vector3d::Zero()) {
  ShapeConfig shape = box(Eigen::Vector3d::Zero(), position);
  shape.type = ShapeType::sphere;
  shape.radius = radius;
  return shape;
}

// Returns the shape as one that is cut away.
inline ShapeConfig cut(ShapeConfig shape) {
  shape.subtract = true;
  return shape;
}

// Returns a cylinder along z.
inline ShapeConfig cylinder(double radius, double height, const Eigen::Vector3d& position = Eigen::Vector3d::Zero()) {
  ShapeConfig shape = box(Eigen::Vector3d::Zero(), position);
  shape.type = ShapeType::cylinder;
  shape.radius = radius;
  shape.height = height;
  return shape;
}

// Returns a cylinder about the axis z, from one height to another.
inline ShapeConfig cylinder_between(double radius, double low, double high) {
  return cylinder(radius, high - low, {0, 0, (low + high) / 2});
}

inline BodyConfig body(const std::string& name, BodyKind type, const ShapeConfig& shape) {
  BodyConfig body;
  body.name = name;
  body.type = type;
  body.material = std::string("m");
  body.shapes = {shape};
  body.where = "s.toml:1";
  return body;
}

// A cube from -1 to 1 with one material of density 500 and no bodies.
inline SceneConfig scene(double spacing) {
  SceneConfig scene;
  scene.path = std::string("s.toml");
  scene.name = std::string("s");
  scene.domain_min.setConstant(-1);
  scene.domain_max.setConstant(1);
  scene.numerics.spacing = spacing;
  scene.materials.emplace_back();
  scene.materials[0].name = std::string("m");
  scene.materials[0].density = 500;
  return scene;
}

}  // namespace palp::test
