// The keys of the window and the actions that they ask for.
#pragma once

#include <optional>
#include <vector>

#include <osgGA/GUIEventHandler>

namespace palp {

enum class Action { next_color, home, surfaces, beads, pause_or_resume, single_step, reset, screenshot, help, figures };

// Returns the action of a key (an ASCII letter or osgGA's symbol), if it has one.
std::optional<Action> action_of(int key);

// Collects the keys pressed; used by the thread that renders.
class KeyHandler : public osgGA::GUIEventHandler {
 public:
  bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter&, osg::Object*, osg::NodeVisitor*) override;
  // Returns the actions asked for since the last call, in order.
  std::vector<Action> take();

 private:
  std::vector<Action> actions_;
};

}  // namespace palp
