// A recording shown in a window, or made into a film.
#pragma once

#include "viewer/options.h"
#include "viewer/stage.h"

namespace palp {

// Shows options.replay until it is told to stop, or makes the film that the options ask for (makes_film). Returns the
// exit status. Throws McapError when nothing can be shown of the file and ConfigError for a faulty script of the
// camera.
int show_recording(const ViewerOptions& options, Stage& stage);

}  // namespace palp
