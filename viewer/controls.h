// The actions that people can ask for by key or from the menu: one table, from which keys, menu and help are made.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <osgGA/GUIEventHandler>

namespace palp {

enum class Action {
  home,
  follow,
  store_view,
  recall_view,
  surfaces,
  beads,
  touch,
  figures,
  panels,
  full_screen,
  open_window,
  close_window,
  next_color,
  next_map,
  hold_range,
  clip,
  clip_axis,
  clip_back,
  clip_forth,
  pause_or_resume,
  single_step,
  reset,
  reload,
  next_scene,
  screenshot,
  help,
  let_go
};

// The menus in which actions stand, in order.
enum class Menu { view, camera, colors, simulation, help };

struct ActionRow {
  Action action;
  Menu menu;
  const char* key_name;  // for people
  const char* meaning;   // a few words, not capitalised
  int key;               // an ASCII letter or osgGA's symbol; for actions with a number the digit 1
  int other_key = 0;     // does the same
};

// Returns every action once, menu by menu.
std::span<const ActionRow> action_rows();
const ActionRow& row_of(Action action);
// Returns whether the action takes a number from 1 to 9, by the digits' keys.
bool takes_number(Action action);

struct Request {
  Action action;
  int number = 0;  // 1 .. 9 for actions that take one
  bool operator==(const Request&) const = default;
};

// Returns what a key (an ASCII letter or osgGA's symbol) asks for, if anything. unmodified: the key without shift, or 0
// where it is not known.
std::optional<Request> request_of(int key, int unmodified = 0, bool shift = false);

// Lines of the help: keys and what they do, with the mouse.
std::vector<std::pair<std::string, std::string>> help_lines();

// Collects the keys pressed; used by the thread that renders.
class KeyHandler : public osgGA::GUIEventHandler {
 public:
  bool handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter&, osg::Object*, osg::NodeVisitor*) override;
  // Returns the requests since the last call, in order.
  std::vector<Request> take();

 private:
  std::vector<Request> requests_;
};

}  // namespace palp
