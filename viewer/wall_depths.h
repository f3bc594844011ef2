// How far it is along the view to the walls of hollow solids that one looks through: where a medium's surface, which
// goes on into them, ends in the picture.
#pragma once

#include <osg/Camera>
#include <osg/Geometry>
#include <osg/MatrixTransform>
#include <osg/Texture2D>
#include <osg/ref_ptr>

namespace palp {

// Returns a hollow solid as the pass takes it: the part that faces its hollow, and the rest. Its matrix is its pose.
osg::ref_ptr<osg::MatrixTransform> hollow_wall(const osg::Geometry& inner, const osg::Geometry& outer);

// All calls from the thread that renders, between frames.
class WallDepths {
 public:
  // walls: those that hollow_wall() returned, and no others.
  explicit WallDepths(osg::Node* walls);
  // A pass before all those of media.
  osg::Node* node() { return camera_; }
  // As wall_depths.frag says.
  osg::Texture2D* texture() const { return texture_; }

  void set_spacing(double spacing);      // of the particles [m]
  void set_size(int width, int height);  // [texels]
  void set_drawn(bool drawn) { camera_->setNodeMask(drawn ? ~0u : 0u); }

 private:
  osg::ref_ptr<osg::Texture2D> texture_;
  osg::ref_ptr<osg::Camera> camera_;
};

}  // namespace palp
