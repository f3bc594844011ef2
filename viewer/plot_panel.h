// The plots over the last seconds, drawn with Dear ImGui. Call while ImGui makes a frame.
#pragma once

#include "viewer/plots.h"

namespace palp {

// now: [s], on the plots' clock.
void draw_plots(const Plots& plots, double now);

}  // namespace palp
