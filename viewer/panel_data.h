// The data that the panels show and what was asked for in them. The windows (panel_windows.h) read and change it; what
// becomes of it is decided elsewhere (panels.h).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <osg/BoundingBox>

#include "viewer/controls.h"
#include "viewer/hud_text.h"
#include "viewer/parameter_list.h"
#include "viewer/plots.h"
#include "viewer/reading.h"
#include "viewer/settings.h"

namespace palp {

// Everything that is known of something that was clicked.
struct PickedLines {
  std::string title;
  std::vector<std::pair<std::string, std::string>> lines;  // what, how much
  bool operator==(const PickedLines&) const = default;
};

struct PanelData {
  // what is shown
  HudData figures;
  std::string scene;                            // its name; empty: there is none
  ScalarField field = ScalarField::none;        // that was asked for
  ScalarField shown_field = ScalarField::none;  // that came
  ValueRange range;                             // of the colours now
  osg::BoundingBoxd content;                    // of the scene [m]
  bool beads = false, draws_all = false, following = false, figures_shown = true;
  std::string refusal;  // of the newest command, in the server's words
  std::optional<PickedLines> picked;
  std::shared_ptr<const std::string> bill;  // of the server's plan, for people; null: none has come
  std::vector<std::string> scenes;          // that the server goes over to
  const Plots* plots = nullptr;
  double now = 0;  // [s], on the clock of the plots
  // what is changed in place
  std::vector<ListedParameter> parameters;
  Reading reading;
  ValueRange edited_range;  // while someone types it
  ViewerSettings settings;
  // what was asked for
  std::vector<Request> requests;
  std::optional<ScalarField> asked_field;
  std::optional<std::string> asked_scene;
  std::vector<std::pair<std::string, std::string>> asked_values;  // parameter, value
};

}  // namespace palp
