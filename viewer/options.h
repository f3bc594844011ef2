// The viewer's command line.
#pragma once

#include <optional>
#include <string>

#include "config/program.h"
#include "idl/bus.h"
#include "viewer/stage.h"

namespace palp {

struct ViewerOptions {
  BusOptions bus;
  StageOptions stage;
  double rate_hz = 0;                     // pictures per second at most
  double seconds = 0;                     // run this long; 0: until told to stop
  ScalarField color = ScalarField::none;  // what the particles' colours show; none: how bodies look
  bool beads = false;                     // liquids and soft bodies as spheres
  bool figures = true;
  int nice = 0;                     // niceness of the process
  int raster_threads = 1;           // of a software rasteriser, off-screen
  std::string png;                  // picture file, or empty
  std::optional<double> png_at;     // [s] after the start; unset: when the viewer ends
  std::optional<double> png_every;  // [s]
  std::string video;                // video file, or empty
  std::string summary;              // JSON file, or empty
  std::string shader_directory;
  bool gl_errors = false;  // tell every error of OpenGL, and fail if there was one
};

// Reads the command line.
Parsed<ViewerOptions> parse_viewer_options(int argc, const char* const* argv);

// Reads "1280x720". Throws std::invalid_argument saying what is accepted: 16x16 .. 8192x8192.
std::pair<int, int> parse_size(const std::string& text);

}  // namespace palp
