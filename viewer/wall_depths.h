// How far it is along the view to the walls of hollow solids that one looks through: where a medium's surface, which
// goes on into them, ends in the picture.
#pragma once

#include <osg/Camera>
#include <osg/Geometry>
#include <osg/MatrixTransform>
#include <osg/Texture2D>
#include <osg/ref_ptr>

namespace palp {

// All calls from the thread that renders, between frames.
class WallDepths {
 public:
  WallDepths();
  // A pass before all those of media.
  osg::Node* node() { return camera_; }
  // The depths are as wall_depths.frag says; 1e30 where there is no such face.
  osg::Texture2D* texture() const { return texture_; }

  void clear();
  void set_spacing(double spacing);  // of the particles [m]
  // Adds a hollow solid: the part that faces its hollow, and the rest. Its pose is that of the node that is returned.
  osg::ref_ptr<osg::MatrixTransform> add(osg::Geometry* inner, osg::Geometry* outer);
  // Returns whether there is any.
  bool any() const { return camera_->getNumChildren() > 0; }
  void set_size(int width, int height);  // [texels]

 private:
  osg::ref_ptr<osg::Texture2D> texture_;
  osg::ref_ptr<osg::Camera> camera_;
};

}  // namespace palp
