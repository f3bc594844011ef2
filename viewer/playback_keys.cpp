#include "viewer/playback_keys.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "viewer/controls.h"

namespace palp {
namespace {

constexpr std::array kSpeeds{0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0};

// Returns the next of kSpeeds above or below a speed.
double next_speed(double speed, bool faster) {
  double next = faster ? kSpeeds.back() : kSpeeds.front();
  for (const double s : kSpeeds) {
    if (faster && s > 1.01 * speed && s < next) next = s;
    if (!faster && s < 0.99 * speed && s > next) next = s;
  }
  return next;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> playback_help_lines() {
  std::vector<std::pair<std::string, std::string>> lines = help_lines();
  constexpr std::array<std::string_view, 4> kTaken{",", ".", "space", "n"};  // by press()
  std::erase_if(lines, [&](const auto& line) { return std::ranges::find(kTaken, line.first) != kTaken.end(); });
  const auto before = lines.end() - 2;  // help and Esc stay last
  lines.insert(before, {{"space", "pause, go on"},
                        {". ,", "a frame forth, back"},
                        {"right left", "a second forth, back"},
                        {"] [", "faster, slower"},
                        {"Home End", "to the begin, the end"},
                        {"drag the line", "go to a time"}});
  return lines;
}

bool PlaybackKeys::press(int key) {
  using Key = osgGA::GUIEventAdapter;
  const TimeRange range = playback_.range();
  switch (key) {
    case ' ':
      playback_.set_paused(!playback_.paused());
      return true;
    case '.':
    case 'n':
      playback_.step(1);
      return true;
    case ',':
      playback_.step(-1);
      return true;
    case ']':
    case '[':
      playback_.set_speed(next_speed(playback_.speed(), key == ']'));
      return true;
    case Key::KEY_Right:
    case Key::KEY_Left:
      playback_.seek(playback_.time() + (key == Key::KEY_Right ? 1 : -1));
      return true;
    case Key::KEY_Home:
      playback_.seek(range.first);
      return true;
    case Key::KEY_End:
      playback_.seek(range.last);
      return true;
    default:
      return false;
  }
}

void PlaybackKeys::scrub(const osgGA::GUIEventAdapter& event) {
  const TimeRange range = playback_.range();
  playback_.seek(range.first + overlay_->share_at(event.getX()) * (range.last - range.first));
}

bool PlaybackKeys::handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& /*unused*/,
                          osg::Object* /*unused*/, osg::NodeVisitor* /*unused*/) {
  if (event.getHandled()) return false;
  switch (event.getEventType()) {
    case osgGA::GUIEventAdapter::KEYDOWN:
      return press(event.getKey());
    case osgGA::GUIEventAdapter::PUSH:
      scrubbing_ = overlay_ != nullptr && overlay_->on_timeline(event.getX(), event.getY());
      if (scrubbing_) scrub(event);
      return scrubbing_;
    case osgGA::GUIEventAdapter::DRAG:
      if (scrubbing_) scrub(event);
      return scrubbing_;
    case osgGA::GUIEventAdapter::RELEASE: {
      const bool was = scrubbing_;
      scrubbing_ = false;
      return was;
    }
    default:
      return false;
  }
}

}  // namespace palp
