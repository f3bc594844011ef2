#include "viewer/controls.h"

#include <algorithm>
#include <array>
#include <utility>

namespace palp {
namespace {

using Key = osgGA::GUIEventAdapter;

constexpr std::array<ActionRow, 27> kRows{{
    {Action::figures, Menu::view, "u", "fewer, more, no figures", 'u'},
    {Action::panels, Menu::view, "p", "panels", 'p'},
    {Action::surfaces, Menu::view, "m", "surfaces or particles", 'm'},
    {Action::beads, Menu::view, "b", "liquids or beads", 'b'},
    {Action::touch, Menu::view, "k", "mark where media touch tools", 'k'},
    {Action::full_screen, Menu::view, "f", "full screen", 'f'},
    {Action::open_window, Menu::view, "w", "another window", 'w'},
    {Action::close_window, Menu::view, "W", "close a further window", 'W'},
    {Action::screenshot, Menu::view, "s", "save a picture", 's'},
    {Action::home, Menu::camera, "r", "home view", 'r'},
    {Action::follow, Menu::camera, "t", "follow the tool", 't'},
    {Action::recall_view, Menu::camera, "1 .. 9", "go to a stored view", '1'},
    {Action::store_view, Menu::camera, "shift 1 .. 9", "store the view", '1'},
    {Action::next_color, Menu::colors, "c", "colours", 'c'},
    {Action::next_map, Menu::colors, "v", "map of colours", 'v'},
    {Action::hold_range, Menu::colors, "g", "hold the range or let it go", 'g'},
    {Action::clip, Menu::colors, "x", "cut open", 'x'},
    {Action::clip_axis, Menu::colors, "X", "cut along the next axis", 'X'},
    {Action::clip_back, Menu::colors, ",", "move the cut back", ','},
    {Action::clip_forth, Menu::colors, ".", "move the cut forth", '.'},
    {Action::pause_or_resume, Menu::simulation, "space", "pause, go on", ' '},
    {Action::single_step, Menu::simulation, "n", "one step", 'n'},
    {Action::reset, Menu::simulation, "R", "start again", 'R'},
    {Action::reload, Menu::simulation, "L", "read the scene's file anew", 'L'},
    {Action::next_scene, Menu::simulation, "N", "the next scene", 'N'},
    {Action::help, Menu::help, "h", "help", 'h', Key::KEY_F1},
    {Action::let_go, Menu::help, "Esc", "let go, or close", Key::KEY_Escape},
}};

constexpr std::pair<const char*, const char*> kMouse[] = {
    {"click", "say what it is"}, {"left drag", "turn"}, {"middle drag", "move"}, {"right drag, wheel", "zoom"}};

int digit_of(int key) { return key >= '1' && key <= '9' ? key - '0' : 0; }

}  // namespace

std::span<const ActionRow> action_rows() { return kRows; }

const ActionRow& row_of(Action action) { return *std::ranges::find(kRows, action, &ActionRow::action); }

bool takes_number(Action action) { return action == Action::store_view || action == Action::recall_view; }

std::optional<Request> request_of(int key, int unmodified, bool shift) {
  const int number = digit_of(key) != 0 ? digit_of(key) : shift ? digit_of(unmodified) : 0;
  if (number != 0) return Request{shift ? Action::store_view : Action::recall_view, number};
  for (const ActionRow& row : kRows) {
    if (!takes_number(row.action) && (key == row.key || (row.other_key != 0 && key == row.other_key)))
      return Request{row.action};
  }
  return std::nullopt;
}

std::vector<std::pair<std::string, std::string>> help_lines() {
  std::vector<std::pair<std::string, std::string>> lines(std::begin(kMouse), std::end(kMouse));
  for (const ActionRow& row : kRows) lines.emplace_back(row.key_name, row.meaning);
  return lines;
}

bool KeyHandler::handle(const osgGA::GUIEventAdapter& event, osgGA::GUIActionAdapter& /*unused*/,
                        osg::Object* /*unused*/, osg::NodeVisitor* /*unused*/) {
  if (event.getHandled() || event.getEventType() != osgGA::GUIEventAdapter::KEYDOWN) return false;
  const bool shift = (event.getModKeyMask() & osgGA::GUIEventAdapter::MODKEY_SHIFT) != 0;
  const std::optional<Request> request = request_of(event.getKey(), event.getUnmodifiedKey(), shift);
  if (request) requests_.push_back(*request);
  return request.has_value();
}

std::vector<Request> KeyHandler::take() { return std::exchange(requests_, {}); }

}  // namespace palp
