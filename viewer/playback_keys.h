// Keys and mouse of a window in which a recording is played.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <osgGA/GUIEventHandler>

#include "viewer/playback.h"
#include "viewer/replay_overlay.h"

namespace palp {

// space: pause, go on; . and , a recorded frame on and back; right and left a second on and back; ] and [ faster and
// slower; Home and End; dragging along the timeline scrubs. Used by the thread that renders; both must outlive it.
class PlaybackKeys : public osgGA::GUIEventHandler {
 public:
  PlaybackKeys(Playback& playback, const ReplayOverlay& overlay) : playback_(playback), overlay_(&overlay) {}
  // For a window without a timeline.
  explicit PlaybackKeys(Playback& playback) : playback_(playback) {}
  bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter&, osg::Object*, osg::NodeVisitor*) override;

 private:
  bool press(int key);
  void scrub(const osgGA::GUIEventAdapter& event);

  Playback& playback_;
  const ReplayOverlay* overlay_ = nullptr;
  bool scrubbing_ = false;
};

// Returns the lines of the help where a recording is played: those of help_lines() whose keys mean the same there, and
// the keys above.
std::vector<std::pair<std::string, std::string>> playback_help_lines();

}  // namespace palp
