// The surface of a soft body as OSG geometry that follows its particles.
#pragma once

#include <span>

#include <osg/Geometry>
#include <osg/ref_ptr>

#include "viewer/mesh.h"
#include "viewer/skin.h"

namespace palp {

// All calls from the thread that renders, between frames.
class SoftSurface {
 public:
  // mesh.solid: the surface at rest, whose vertices are those of the skin.
  SoftSurface(const BodyMesh& mesh, Skin skin);
  osg::Geometry* geometry() { return geometry_; }
  const Skin& skin() const { return skin_; }

  // Takes where the body's particles are, x y z each [m]: vertices and normals follow, and triangles beside a tear are
  // left out. places: as many as the skin has particles.
  void follow(std::span<const float> places);

 private:
  void find_normals();

  Skin skin_;
  osg::ref_ptr<osg::Geometry> geometry_;
  osg::ref_ptr<osg::Vec3Array> vertices_, normals_;
  osg::ref_ptr<osg::DrawElementsUInt> drawn_;
  std::vector<GLuint> triangles_;  // all of them, three vertices each
  bool whole_ = true;              // all are drawn
};

}  // namespace palp
