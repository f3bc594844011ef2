// The panel that steers the simulation, drawn with Dear ImGui. Call while ImGui makes a frame.
#pragma once

#include "viewer/panel_data.h"

namespace palp {

void draw_parameters(PanelData& data);

}  // namespace palp
