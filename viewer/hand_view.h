// A hand in the picture: the force and torque that it feels, with their values, and where it holds the tool while
// contact or coupling keep the tool from going there.
#pragma once

#include <optional>
#include <string>

#include <osg/Group>
#include <osg/MatrixTransform>
#include <osg/ref_ptr>
#include <osgText/Text>

#include "idl/messages.h"
#include "viewer/force_arrow.h"
#include "viewer/hand_reach.h"
#include "viewer/torque_arrow.h"

namespace palp {

// How large things are drawn.
struct HandScale {
  double full_force = 1;    // [N] that the longest arrow stands for
  double arrow_length = 1;  // [m] of that arrow
  double full_torque = 1;   // [N m] that the longest bend stands for
  double scene_radius = 1;  // [m]
};

// Calls from the thread that renders, between frames.
class HandView {
 public:
  // device: gives it its colour.
  explicit HandView(std::uint32_t device);
  osg::Node* node() { return root_; }

  // Forgets the tool and hides everything.
  void clear();
  // Adds a part of the tool's surface, in its body frame, to what is shown where the hand wants it.
  void add_tool_part(const osg::Geometry& part);
  // Takes where the tool is.
  void set_tool_pose(const osg::Matrixd& pose, double sim_time);
  void set(const ProxySample& sample, const HandScale& scale);
  // Writes this beside the arrows until it is told anew: what is felt changes faster than one can read.
  void set_values(const WrenchD& wrench);
  // Takes where the arm's handle can be moved; nothing: not known.
  void set_reach(const std::optional<HandReach>& reach);
  // No force is known.
  void hide();
  void set_values_shown(bool shown) { values_->setNodeMask(shown ? ~0u : 0u); }
  void set_value_size(float pixels);
  // Keeps the two values from being written over each other and over the arrow of a torque. to_pixels: from the world.
  void arrange_values(const osg::Matrixd& to_pixels);
  // Returns what stands beside the arrows, as the figures write it: "1.23 N  ·  0.456 N m".
  std::string values() const;
  bool wish_shown() const { return wish_->getNodeMask() != 0; }

 private:
  void set_wish(const ProxySample& sample, const HandScale& scale);

  osg::ref_ptr<osg::Group> root_;
  ForceArrow force_;
  TorqueArrow torque_;
  osg::ref_ptr<osg::Group> values_;
  osg::ref_ptr<osgText::Text> force_value_, torque_value_;
  std::string force_words_, torque_words_;
  ReachBox reach_box_;
  std::optional<HandReach> reach_;
  std::optional<osg::Vec3d> device_;  // where the device is [m]
  osg::Vec3d handle_, force_end_;     // [m]
  double torque_radius_ = 0;          // [m]
  osg::ref_ptr<osg::Group> wish_;     // the tool where the hand wants it, and a line from there to the tool
  osg::ref_ptr<osg::MatrixTransform> wished_tool_, line_;
  std::optional<osg::Matrixd> tool_;         // its pose
  std::optional<osg::Matrixd> from_handle_;  // of the tool's body in the handle's frame
  double tool_time_ = 0;                     // [s] simulated
  double from_handle_error_ = 0;             // [s] between the two poses that it comes from
};

}  // namespace palp
