// An arrow that bends around the axis of a torque.
#pragma once

#include <osg/Group>
#include <osg/MatrixTransform>
#include <osg/PrimitiveSet>
#include <osg/ref_ptr>

namespace palp {

// Drawn as force arrows are. Calls from the thread that renders.
class TorqueArrow {
 public:
  explicit TorqueArrow(const osg::Vec4f& color);
  osg::Node* node() { return root_; }

  // Around origin and the torque's direction, right-handed, over share (0 .. 1) of most of a turn; radius of the bend
  // [m]. Hidden when the share is small, or anything is not finite.
  void set(const osg::Vec3d& origin, const osg::Vec3d& torque, double share, double radius);
  void hide() { root_->setNodeMask(0); }
  bool visible() const { return root_->getNodeMask() != 0; }

 private:
  osg::ref_ptr<osg::Group> root_;
  osg::ref_ptr<osg::MatrixTransform> pose_;
  osg::ref_ptr<osg::MatrixTransform> head_;
  osg::ref_ptr<osg::DrawArrays> bend_;  // as much of the whole bend as is shown
};

}  // namespace palp
