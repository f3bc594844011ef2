// Where an arm's handle can be moved: a box in the scene. A side that the hand comes near is drawn as a grid around the
// hand, and all of them while the clutch is held.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include <osg/Geometry>
#include <osg/Group>
#include <osg/Vec3d>
#include <osg/ref_ptr>

#include "idl/messages.h"

namespace palp {

struct HandReach {
  osg::Vec3d center, half;  // of the box, along the world's axes [m]
  bool clutched = false;    // the hand moves the arm and not the tool
  bool operator==(const HandReach&) const = default;
};

// Returns what the bridges say of their arms' reach in their newest Status, by device; nothing of those that do not
// know it.
std::map<std::uint32_t, HandReach> reaches_of(const std::map<std::string, Status>& newest);

// Returns how much is to be seen of each side, 0 .. 1: -x, +x, -y, +y, -z, +z.
std::array<float, 6> reach_shown(const HandReach& reach, const osg::Vec3d& handle);

// All calls from the thread that renders, between frames.
class ReachBox {
 public:
  explicit ReachBox(const osg::Vec4f& color);
  osg::Node* node() { return root_; }
  // Shows what there is to be seen of the box of a handle at that place; nothing without one.
  void set(const std::optional<HandReach>& reach, const osg::Vec3d& handle);

 private:
  osg::Vec4f color_;
  osg::ref_ptr<osg::Group> root_;
  osg::ref_ptr<osg::Geometry> grid_, edges_;
};

}  // namespace palp
