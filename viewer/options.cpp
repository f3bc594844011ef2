#include "viewer/options.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <map>
#include <stdexcept>

#include "config/command_line.h"
#include "config/number_between.h"
#include "idl/bus_options.h"
#include "viewer/settings.h"

namespace palp {
namespace {

constexpr int kMinSize = 16, kMaxSize = 8192;

bool has_display() {
  const char* display = std::getenv("DISPLAY");
  return display != nullptr && *display != '\0';
}

// A small fluid at 30 pictures a second takes a software rasteriser most of a core, which the simulation may want:
// without anyone to see it, only as many are drawn as a picture or a video needs.
double default_rate(const ViewerOptions& o) {
  if (makes_film(o)) return 30;
  if (!o.stage.headless) return 60;
  return o.video.empty() ? 5 : 30;
}

// The options that need a second look once all have been read.
struct CommandLine {
  std::string size = "1280x720";
  int samples = -1, nice = -1;
  double png_at = 0, png_every = 0;  // [s]
  CLI::Option *png_at_given = nullptr, *png_every_given = nullptr, *settings_given = nullptr;
  bool no_settings = false;
};

void add_replay_options(CLI::App& app, PlayOptions& o) {
  constexpr const char* kGroup = "Recordings and films";
  auto* replay =
      app.add_option("--replay", o.file,
                     "show a recording (MCAP, of palp-record or palp-run) in place of a running simulation. "
                     "In a window: space pauses, . and , go by single frames, the arrows by seconds, [ and ] "
                     "change the speed, the timeline can be dragged. Off-screen, or with --video, --frames or "
                     "--png, it is made into a film: each picture is of an exact simulated time, however slow "
                     "the machine, --fps of them a second (30), and --seconds, --png-at and --png-every count "
                     "in the film's time")
          ->type_name("FILE")
          ->group(kGroup);
  app.add_option("--from", o.from, "simulated time at which it begins [s] (its first frame)")
      ->check(number_between(0.0, 1e7))
      ->needs(replay)
      ->group(kGroup);
  app.add_option("--speed", o.speed, "simulated seconds in one that is shown, 0.1 to 10")
      ->check(number_between(0.1, 10.0))
      ->capture_default_str()
      ->needs(replay)
      ->group(kGroup);
  app.add_option("--script", o.script,
                 "lead the camera of the film by this script: a TOML file, or the name of one in "
                 "config/films")
      ->type_name("NAME")
      ->needs(replay)
      ->group(kGroup);
  app.add_option("--frames", o.frames, "write every picture of the film, DIR/NAME-0001.png and so on")
      ->type_name("DIR/NAME.png")
      ->needs(replay)
      ->group(kGroup);
}

// Returns what is wrong with a size as --size takes it, or nothing.
std::string fault_of_size(std::string& text) {
  try {
    parse_size(text);
    return {};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

void add_picture_options(CLI::App& app, ViewerOptions& o, CommandLine& line) {
  app.add_flag("--headless", o.stage.headless, "draw off-screen through EGL; the default where there is no DISPLAY");
  app.add_option("--gpu", o.stage.gpu,
                 "off-screen: auto, cpu (software), egl:N (N-th EGL device), pci:DDDD:BB:DD.F or pci:BB:DD.F (the GPU "
                 "at this address of the PCI bus, as lspci and nvidia-smi print it) or cuda:N (CUDA's number). auto "
                 "takes a GPU that no palp-sim-server computes on already, if there is one. list prints what there is")
      ->capture_default_str();
  app.add_option("--size", line.size, "of the picture, WIDTHxHEIGHT in pixels")
      ->check(CLI::Validator(fault_of_size, ""))
      ->capture_default_str();
  app.add_option("--windows", o.windows,
                 "open so many windows on the scene, each with a camera of its own (keys w and W open and close one). "
                 "The first one has menu, panels and figures, and closing it ends the viewer")
      ->check(CLI::Range(1, kMostWindows))
      ->capture_default_str();
  app.add_option("--fps", o.rate_hz, "pictures per second at most (60; off-screen 30 with --video, else 5)")
      ->check(number_between(0.1, 1000.0));
  app.add_option("--samples", line.samples, "samples per pixel against jagged edges (4; off-screen 0)")
      ->check(CLI::Range(0, 16));
  app.add_option("--mean-of", o.stage.mean_of,
                 "make each picture that is written of so many that are displaced within a pixel, and draw liquids "
                 "as finely as the picture is: all edges are smooth, at so many times the work")
      ->check(CLI::Range(1, kMostMean))
      ->capture_default_str();
  app.add_option("--seconds", o.seconds, "end after this long")->check(number_between(0.0, 1e7));
  std::map<std::string, ScalarField> colors;
  for (std::size_t i = 0; i < kScalarFields.size(); ++i)
    colors.emplace(legend_name(static_cast<ScalarField>(i)), static_cast<ScalarField>(i));
  app.add_option("--color", o.color,
                 "what the colours of particles show: body, which is how things look, speed, density, pressure, "
                 "temperature, density_error (over that at rest) or state (the share that is solid). The server sends "
                 "one field to all viewers: the one that was asked for last, here or "
                 "by key c of any viewer. A viewer that asked for another one says so and shows how things look")
      ->capture_default_str()
      ->transform(CLI::CheckedTransformer(colors).description(""))
      ->type_name("FIELD");
  const std::map<std::string, Surfaces> surfaces{
      {"auto", Surfaces::automatic}, {"fine", Surfaces::fine}, {"quick", Surfaces::quick}};
  app.add_option("--surfaces", o.stage.surfaces,
                 "how well liquids are drawn: fine, quick or auto, which is quick on a software rasteriser")
      ->transform(CLI::CheckedTransformer(surfaces).description(""))
      ->type_name("auto|fine|quick");
  app.add_flag("--beads", o.beads, "draw liquids and soft bodies as one sphere a particle");
  app.add_flag("--touch", o.touch, "mark where media touch tools: by their pressure with --color pressure");
}

void add_capture_options(CLI::App& app, ViewerOptions& o, CommandLine& line) {
  auto* png =
      app.add_option("--png", o.png, "write a picture, when the viewer ends unless --png-at or --png-every say when");
  line.png_at_given = app.add_option("--png-at", line.png_at, "write it this many seconds after the start")
                          ->check(number_between(0.0, 1e7))
                          ->needs(png);
  line.png_every_given =
      app.add_option("--png-every", line.png_every, "write one every so many seconds, FILE-0001.png and so on")
          ->check(number_between(0.01, 1e7))
          ->needs(png)
          ->excludes(line.png_at_given);
  app.add_option("--video", o.video, "write a video (H.264, through ffmpeg)");
  app.add_flag("!--no-figures", o.figures, "leave out the figures and the legend");
  app.add_flag("--panels", o.panels,
               "show menu and panels from the start, and have them in pictures and videos, too, which leave them out "
               "otherwise");
}

// Returns why there can be no more windows than one, or nothing.
const char* fault_of_windows(const ViewerOptions& o) {
  if (o.windows == 1) return nullptr;
  if (o.stage.headless || !has_display())
    return "off-screen there are no windows; leave out --headless, or set DISPLAY";
  if (o.bench > 0) return "--bench draws in one window";
  return makes_film(o) ? "a film is made in one window" : nullptr;
}

void add_options(CLI::App& app, ViewerOptions& o, CommandLine& line) {
  add_picture_options(app, o, line);
  add_capture_options(app, o, line);
  line.settings_given =
      app.add_option("--settings", o.settings,
                     "keep the colours, views and panels that its user likes in this file, in place of "
                     "$XDG_CONFIG_HOME/palp/viewer.toml or ~/.config/palp/viewer.toml; off-screen it is only read, and "
                     "no other one is");
  app.add_flag("--no-settings", line.no_settings, "neither read nor keep such a file")->excludes(line.settings_given);
  app.add_option("--nice", line.nice, "niceness, 0 to 19 (0; off-screen 10)")->check(CLI::Range(0, 19));
  app.add_option("--raster-threads", o.raster_threads, "threads of a software rasteriser, off-screen")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--summary", o.summary, "write a summary (JSON) at the end");
  app.add_option("--shaders", o.shader_directory, "take shaders from this directory first")
      ->check(CLI::ExistingDirectory);
  auto* bench =
      app.add_option(
             "--bench", o.bench,
             "draw a made-up pool of so many particles instead, say how long pictures and their passes take, and end "
             "(with --png after a picture of it)")
          ->check(CLI::Range(std::size_t{1}, std::size_t{10'000'000}))
          ->type_name("PARTICLES");
  app.add_flag("--clear", o.clear, "the pool of --bench is looked through")->needs(bench);
  app.add_flag("--gl-errors", o.gl_errors, "tell every error of OpenGL, and end with status 1 if there was one");
  add_replay_options(app, o.replay);
  add_bus_options(app, o.bus);
  app.callback([&o] {
    if (const char* fault = fault_of_windows(o)) throw CLI::ValidationError("--windows", fault);
  });
}

}  // namespace

std::pair<int, int> parse_size(const std::string& text) {
  int width = 0, height = 0;
  const char* end = text.data() + text.size();
  const auto [x, error] = std::from_chars(text.data(), end, width);
  bool good = error == std::errc() && x != end && *x == 'x';
  if (good) {
    const auto [rest, second] = std::from_chars(x + 1, end, height);
    good = second == std::errc() && rest == end;
  }
  if (!good || std::min(width, height) < kMinSize || std::max(width, height) > kMaxSize) {
    throw std::invalid_argument("'" + text + "' is no picture size; expected WIDTHxHEIGHT, each 16 to 8192 pixels");
  }
  return {width, height};
}

Parsed<ViewerOptions> parse_viewer_options(int argc, const char* const* argv) {
  ViewerOptions o;
  CLI::App app("Shows a palp simulation: particles, surfaces, forces. It may start before or after palp-sim-server.");
  CommandLine line;
  add_options(app, o, line);
  if (const auto status = read_command_line(app, "palp-viewer", argc, argv)) return {std::nullopt, *status};
  std::tie(o.stage.width, o.stage.height) = parse_size(line.size);
  o.stage.headless = o.stage.headless || !has_display();
  o.stage.samples = line.samples >= 0 ? line.samples : o.stage.headless ? 0 : 4;
  o.nice = line.nice >= 0 ? line.nice : o.stage.headless ? 10 : 0;
  if (line.settings_given->count() == 0 && !line.no_settings && !o.stage.headless) o.settings = settings_path();
  o.writes_settings = !o.stage.headless;
  if (line.png_at_given->count() > 0) o.png_at = line.png_at;
  if (line.png_every_given->count() > 0) o.png_every = line.png_every;
  if (o.rate_hz == 0) o.rate_hz = default_rate(o);
  return {o, 0};
}

}  // namespace palp
