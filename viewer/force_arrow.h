// An arrow for a force, and how long a newton is drawn.
#pragma once

#include <array>

#include <osg/Group>
#include <osg/MatrixTransform>
#include <osg/Vec4f>
#include <osg/ref_ptr>

namespace palp {

// Drawn solid where it is seen and as a faint ghost where something hides it. Calls from the thread that renders.
class ForceArrow {
 public:
  explicit ForceArrow(const osg::Vec4f& color);
  osg::Node* node() { return root_; }

  // From origin along force, length [m] long; thickness [m] is the radius of the shaft. Hidden when length is no longer
  // than the shaft is thick, or anything is not finite.
  void set(const osg::Vec3d& origin, const osg::Vec3d& force, double length, double thickness);
  void hide();
  bool visible() const { return root_->getNodeMask() != 0; }

 private:
  osg::ref_ptr<osg::Group> root_;
  osg::ref_ptr<osg::MatrixTransform> pose_;
  osg::ref_ptr<osg::MatrixTransform> shaft_;
  osg::ref_ptr<osg::MatrixTransform> head_;
};

// The force [N], or torque [N m], that the longest arrow stands for: 1, 2 or 5 times a power of ten, at least what is
// felt now; it falls again when forces have been small for some seconds of simulated time, but never below smallest.
class ForceScale {
 public:
  explicit ForceScale(double smallest = 0.5) : smallest_(smallest), full_scale_(2 * smallest) {}
  double update(double force, double sim_time);
  double full_scale() const { return full_scale_; }

 private:
  double peak_ = 0;
  double smallest_;
  double full_scale_;
  double time_ = 0;
};

}  // namespace palp
