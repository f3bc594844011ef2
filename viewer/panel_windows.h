// The menu and the panels, as windows of Dear ImGui. Call while ImGui makes a frame.
#pragma once

#include "viewer/panel_data.h"

namespace palp {

// Draws the menu along the upper edge and returns its height [pixels].
float draw_menu(PanelData& data);

// Draws the panels in one column along the right edge, below `top` [pixels], which can be scrolled where it is too
// long. all: with the panels of control, reading and plots; else only what was clicked.
void draw_column(PanelData& data, float top, float width, bool all);

}  // namespace palp
