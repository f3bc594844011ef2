// Where media touch the tools of a scene: marks on all of them, and how much is touched in all.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "idl/messages.h"
#include "viewer/touch_marks.h"

namespace palp {

// All calls from the thread that renders, between frames.
class TouchView {
 public:
  // Drops the tools of the scene before.
  void set_scene(const SceneDescription& scene);
  // Returns what is to be put into that body's frame, or null where it is no tool.
  osg::Node* node(std::size_t body);
  // Adds a part of a surface, in its body frame, if the body is a tool.
  void add_part(std::size_t body, const osg::Geometry& part);
  void set_marked(bool marked);
  // Marks what this frame touches, if that is wanted. pose_of: of a body that is shown. pressures: null while the
  // frame's scalars are no pressures.
  void mark(const ParticleFrame& frame, const std::function<std::optional<osg::Matrixd>(std::size_t)>& pose_of,
            const PressureColors* pressures);
  // Returns how much of all tools is touched; nothing while that is not marked, or no tool is shown.
  const std::optional<Touch>& touch() const { return touch_; }

 private:
  std::map<std::size_t, TouchMarks> tools_;  // by body
  std::vector<ParticleRange> media_;         // the particles of what is no solid
  bool marked_ = false;
  std::optional<Touch> touch_;
};

}  // namespace palp
