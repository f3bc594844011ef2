// The layer that is drawn over a recording while it is played: the caption of a film, and the timeline with its marks.
#pragma once

#include <string>

#include <osg/Camera>
#include <osg/Geometry>
#include <osg/ref_ptr>
#include <osgText/Text>

namespace palp {

// Calls from the thread that renders, between frames.
class ReplayOverlay {
 public:
  ReplayOverlay();
  osg::Camera* camera() { return camera_; }

  // The size of the picture, and of what panels take along its right edge, beside which the timeline stays [pixels].
  void set_size(int width, int height, double taken_right = 0);
  // opacity: 0 .. 1; 0 hides it.
  void set_caption(const std::string& text, double opacity);
  // Shows where in first .. last [s] the time is. Words beside it tell time and speed, and that it is paused.
  void set_timeline(double first, double last, double time, double speed, bool paused);
  void set_timeline_shown(bool shown) { timeline_->setNodeMask(shown ? ~0u : 0u); }
  bool timeline_shown() const { return timeline_->getNodeMask() != 0; }

  // Returns whether a place of the picture, in pixels from its lower left corner, is on the timeline, and which share
  // of it, 0 .. 1, lies to the left.
  bool on_timeline(float x, float y) const;
  double share_at(float x) const;
  // Returns the words beside the timeline.
  const std::string& words() const { return words_; }

 private:
  struct Bar {
    float x = 0, y = 0, width = 1, height = 1;  // [pixels]
  };
  Bar bar() const;
  void lay_out();

  osg::ref_ptr<osg::Camera> camera_;
  osg::ref_ptr<osg::Group> timeline_;
  osg::ref_ptr<osg::Geometry> track_, done_, knob_, behind_caption_;
  osg::ref_ptr<osgText::Text> text_, caption_;
  std::string words_;
  float width_ = 1, height_ = 1;
  float free_ = 1;  // of the width
  double share_ = 0;
};

}  // namespace palp
