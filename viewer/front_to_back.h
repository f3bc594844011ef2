// The order in which a GPU draws particles with least work: what lies behind others is passed over once they are drawn.
// Pure.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <osg/BoundingBox>
#include <osg/Vec3f>
#include <osg/Vec4f>

namespace palp {

// Places in thin layers by how far they are along the way of looking.
class FrontToBack {
 public:
  // places: x, y and z are finite [m]; w is not looked at. along: of unit length, away from the eye. Returns of each
  // place how many come before it: those of nearer layers, and those before it in its own. Valid until the next call.
  std::span<const std::uint32_t> rank(std::span<const osg::Vec4f> places, const osg::Vec3f& along);
  // Returns the box around the places that were ranked last, invalid where there were none.
  const osg::BoundingBox& box() const { return box_; }

 private:
  osg::BoundingBox box_;
  std::vector<std::uint32_t> ranks_;
};

}  // namespace palp
