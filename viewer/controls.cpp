#include "viewer/controls.h"

#include <utility>

namespace palp {

std::optional<Action> action_of(int key) {
  switch (key) {
    case 'c':
      return Action::next_color;
    case 'r':
      return Action::home;
    case 'm':
      return Action::surfaces;
    case 'b':
      return Action::beads;
    case ' ':
      return Action::pause_or_resume;
    case 'n':
      return Action::single_step;
    case 'R':
      return Action::reset;
    case 's':
      return Action::screenshot;
    case 'u':
      return Action::figures;
    case 'h':
    case osgGA::GUIEventAdapter::KEY_F1:
      return Action::help;
    default:
      return std::nullopt;
  }
}

bool KeyHandler::handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& /*unused*/,
                        osg::Object* /*unused*/, osg::NodeVisitor* /*unused*/) {
  if (event.getHandled() || event.getEventType() != osgGA::GUIEventAdapter::KEYDOWN) return false;
  const std::optional<Action> action = action_of(event.getKey());
  if (action) actions_.push_back(*action);
  return action.has_value();
}

std::vector<Action> KeyHandler::take() { return std::exchange(actions_, {}); }

}  // namespace palp
