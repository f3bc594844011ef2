// The viewer's command line.
#pragma once

#include <optional>
#include <string>

#include "config/program.h"
#include "idl/bus.h"
#include "viewer/stage.h"

namespace palp {

// A recording that is shown in place of a bus, and the film that is made of it.
struct PlayOptions {
  std::string file;            // MCAP; empty: none
  std::optional<double> from;  // [s] simulated, at which it begins; unset: at its first frame
  double speed = 1;            // simulated seconds in one that is shown
  std::string script;          // of the camera; empty: none
  std::string frames;          // picture file whose name is numbered, one a picture of the film; or empty
};

inline constexpr int kMostWindows = 9;
inline constexpr int kMostMean = 64;

struct ViewerOptions {
  BusOptions bus;
  StageOptions stage;
  double rate_hz = 0;                     // pictures per second at most
  double seconds = 0;                     // run this long; 0: until told to stop
  ScalarField color = ScalarField::none;  // what the particles' colours show; none: how bodies look
  int windows = 1;                        // of them, 1 .. kMostWindows
  bool beads = false;                     // liquids and soft bodies as spheres
  bool touch = false;                     // marks where media touch tools
  bool figures = true;
  bool panels = false;              // all panels from the start, and in pictures and videos
  std::string settings;             // file, or empty for none
  bool writes_settings = false;     // keeps what its user changes
  int nice = 0;                     // niceness of the process
  int raster_threads = 1;           // of a software rasteriser, off-screen
  std::string png;                  // picture file, or empty
  std::optional<double> png_at;     // [s] after the start; unset: when the viewer ends
  std::optional<double> png_every;  // [s]
  std::string video;                // video file, or empty
  std::string summary;              // JSON file, or empty
  std::string shader_directory;
  PlayOptions replay;
  std::size_t bench = 0;   // particles of a made-up scene whose drawing is timed, in place of a server's; 0: none
  bool clear = false;      // these are looked through
  bool gl_errors = false;  // tell every error of OpenGL, and fail if there was one
};

// Returns whether a recording is made into a film, and not played in a window.
inline bool makes_film(const ViewerOptions& o) {
  return !o.replay.file.empty() && (o.stage.headless || !o.video.empty() || !o.replay.frames.empty() || !o.png.empty());
}

// Reads the command line.
Parsed<ViewerOptions> parse_viewer_options(int argc, const char* const* argv);

// Reads "1280x720". Throws std::invalid_argument saying what is accepted: 16x16 .. 8192x8192.
std::pair<int, int> parse_size(const std::string& text);

}  // namespace palp
