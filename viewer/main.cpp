// The viewer: arguments, a feed from the bus, and a loop that draws the newest of what the feed has.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "config/program.h"
#include "config/stop_signal.h"
#include "idl/clock.h"
#include "viewer/bench.h"
#include "viewer/capture.h"
#include "viewer/draw_times.h"
#include "viewer/egl_window.h"
#include "viewer/feed.h"
#include "viewer/options.h"
#include "viewer/panels.h"
#include "viewer/replay.h"
#include "viewer/session.h"
#include "viewer/settings.h"
#include "viewer/shaders.h"
#include "viewer/summary.h"
#include "viewer/windows.h"

namespace palp {
namespace {

// Takes little of the machine; called before any other thread starts, so that all of them are as modest.
void be_modest(const ViewerOptions& options) {
  if (options.nice > 0) setpriority(PRIO_PROCESS, 0, options.nice);
  if (options.stage.headless) setenv("LP_NUM_THREADS", std::to_string(options.raster_threads).c_str(), 0);
}

// Says which pictures are due and hands them to the capture.
class Recorder {
 public:
  Recorder(const ViewerOptions& options, const Stage& stage) : options_(options) {
    if (!options.video.empty()) capture_.open_video(options.video, stage.width(), stage.height(), options.rate_hz);
  }

  // Returns whether the next picture is to be taken. seconds: since the start. last: no other picture follows.
  bool wants(double seconds, bool last, bool screenshot) {
    pngs_.clear();
    if (screenshot) pngs_.push_back(screenshot_name());
    if (options_.png_every) {
      if (seconds >= next_png_) {
        pngs_.push_back(numbered(options_.png, ++png_count_));
        next_png_ = (std::floor(seconds / *options_.png_every) + 1) * *options_.png_every;
      }
    } else if (!options_.png.empty() && png_count_ == 0 && (last || (options_.png_at && seconds >= *options_.png_at))) {
      pngs_.push_back(options_.png);
      ++png_count_;
    }
    return !pngs_.empty() || capture_.video_open();
  }

  void take(Picture&& picture, double seconds) {
    capture_.write_video(picture, seconds);
    for (const std::string& file : pngs_) capture_.write_png(file, picture);
    pngs_.clear();
  }

  // Writes a picture that someone asked for in a further window.
  void save(Picture&& picture) { capture_.write_png(screenshot_name(), std::move(picture)); }

  bool finish() {
    const bool whole = capture_.finish();
    for (const std::string& file : pngs_)
      spdlog::warn("{} was not written: the window was closed first; --png-at says when to write it", file);
    if (capture_.dropped_video_pictures() > 0) {
      spdlog::warn("{} pictures were not put into the video, because ffmpeg was behind or the size had changed",
                   capture_.dropped_video_pictures());
    }
    return whole;
  }

 private:
  const ViewerOptions& options_;
  Capture capture_;
  std::vector<std::string> pngs_;  // due with the next picture
  int png_count_ = 0;
  double next_png_ = 0;
};

void report(Feed& feed, const Session& session, const FeedView& view) {
  const HudData& d = session.figures();
  feed.report(d.frame_age ? "running" : "waiting", {{"shown_rate_hz", d.shown_rate_hz},
                                                    {"frame_rate_hz", d.frame_rate_hz},
                                                    {"frame_age_ms", 1e3 * d.frame_age.value_or(0)},
                                                    {"frames", static_cast<double>(view.frames)},
                                                    {"shared_frames", static_cast<double>(view.shared_frames)},
                                                    {"lost_frames", static_cast<double>(view.lost_frames)},
                                                    {"refused_samples", static_cast<double>(view.refused)}});
}

// Times the drawing of a made-up scene. Returns false if its picture or the summary cannot be written.
bool bench(const ViewerOptions& options, Stage& stage) {
  const Medium medium = options.beads ? Medium::beads : options.clear ? Medium::clear : Medium::opaque;
  const DrawingTimes times = time_drawing(stage, options.bench, medium, options.seconds > 0 ? options.seconds : 6);
  fmt::print("{}", table_of(times));
  if (!options.png.empty()) {
    Capture capture;
    stage.draw([&](Picture&& picture) { capture.write_png(options.png, std::move(picture)); });
    if (!capture.finish()) return false;
  }
  if (options.summary.empty()) return true;
  Json passes = Json::object();
  for (const auto& [name, ms] : times.passes) passes[name] = ms;
  return write_summary(options.summary, {{"renderer", stage.renderer()},
                                         {"size", fmt::format("{}x{}", stage.width(), stage.height())},
                                         {"particles", times.particles},
                                         {"seen", times.seen},
                                         {"pictures", times.pictures},
                                         {"take_p50_ms", times.take},
                                         {"draw_p50_ms", times.picture},
                                         {"draw_p99_ms", times.slowest},
                                         {"passes_p50_ms", passes}});
}

// How pictures waited for steps of a simulation on the same GPU.
struct GpuWaits {
  DrawTimes times;
  std::uint64_t late_pieces = 0;  // drawn without a gap between two steps
  int late_pictures = 0;          // with such pieces
  void add(const GpuPacing& pacing) {
    times.add(1e-9 * static_cast<double>(pacing.waited_ns()));
    constexpr int kMany = 60;
    if (pacing.late_pieces() > std::exchange(late_pieces, pacing.late_pieces()) && ++late_pictures == kMany)
      spdlog::warn("the simulation leaves this GPU hardly any time to draw: pictures come slowly and delay its steps");
  }
};

// Says how it ended and returns the exit status.
int conclude(const ViewerOptions& options, const Session& session, Recorder& recorder, const FeedView& view,
             const DrawTimes& draw_times, const GpuWaits& waits) {
  if (!session.surfaces_complete()) spdlog::warn("ended before all surfaces of the scene were built");
  const bool whole = recorder.finish();
  const bool captured = !options.png.empty() || !options.video.empty();
  if (session.frames_drawn() == 0) {
    spdlog::log(captured ? spdlog::level::err : spdlog::level::warn,
                "no particles arrived: check that palp-sim-server runs in DDS domain {} and, on another host, "
                "--network or --peer",
                options.bus.domain);
  }
  const bool healthy = whole && (!captured || session.frames_drawn() > 0);
  const bool told = write_summary(options.summary, {{"frames", view.frames + view.lost_frames},
                                                    {"complete_frames", view.frames},
                                                    {"shared_frames", view.shared_frames},
                                                    {"lost_frames", view.lost_frames},
                                                    {"refused_samples", view.refused},
                                                    {"drawn_frames", session.frames_drawn()},
                                                    {"pictures", draw_times.count()},
                                                    {"draw_p50_ms", draw_times.share_ms(0.5)},
                                                    {"draw_p99_ms", draw_times.share_ms(0.99)},
                                                    {"gpu_wait_p50_ms", waits.times.share_ms(0.5)},
                                                    {"gpu_wait_p99_ms", waits.times.share_ms(0.99)},
                                                    {"late_pieces", waits.late_pieces},
                                                    {"healthy", healthy}});
  return healthy && told ? 0 : 1;
}

int show(const ViewerOptions& options) {
  set_shader_directory(options.shader_directory);
  Stage stage(options.stage);
  spdlog::info("drawing {}x{} {} on {}{}", stage.width(), stage.height(),
               options.stage.headless ? "off-screen" : "in a window", stage.renderer(),
               stage.software_rendered() ? " (software)" : "");
  if (options.bench > 0) return bench(options, stage) ? 0 : kExitFailed;
  if (!options.replay.file.empty()) return show_recording(options, stage);
  stage.hud().set_visible(options.figures);
  stage.scene().set_values_shown(options.figures);

  Recorder recorder(options, stage);
  Feed feed(options.bus);
  const Session::Send send = [&feed](CommandKind kind, const std::string& name, const std::string& value) {
    feed.send(kind, name, value);
  };
  Session session(stage, options.color, send);
  session.set_beads(options.beads);
  session.set_touch_marked(options.touch);
  SettingsFile settings(options.settings, options.writes_settings);
  Panels panels(stage, session, send, settings.settings(), panels_of(options));
  Windows windows(stage, options, session, panels);

  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / options.rate_hz));
  auto next = start;
  double reported = -1;
  DrawTimes draw_times;
  GpuWaits waits;
  for (bool last = false; !last;) {
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    last = stop_asked() || stage.viewer().done() || (options.seconds > 0 && seconds >= options.seconds);
    const FeedView view = feed.view();
    session.update(view, now_ns());
    panels.update(view, now_ns());
    const bool wanted = recorder.wants(seconds, last, stage.take_picture_wish());
    if (last && !wanted) break;  // a picture of a large scene may take seconds
    const std::int64_t begun_ns = now_ns();
    if (wanted) {
      stage.draw([&](Picture&& picture) { recorder.take(std::move(picture), seconds); });
    } else {
      stage.draw();
    }
    session.shown(now_ns());
    draw_times.add(1e-9 * static_cast<double>(now_ns() - begun_ns));
    if (stage.pacing()) waits.add(*stage.pacing());
    windows.draw([&](Picture&& picture) { recorder.save(std::move(picture)); });
    windows.obey();
    settings.keep(panels.settings(), now_ns());
    if (seconds - reported >= 0.5) {
      report(feed, session, view);
      reported = seconds;
    }
    // a late picture is not made up for by haste
    next = std::max(next + period, Clock::now());
    if (!last) std::this_thread::sleep_until(next);
  }
  settings.keep(panels.settings(), now_ns(), true);
  return conclude(options, session, recorder, feed.view(), draw_times, waits);
}

int run(ViewerOptions options) {
  if (options.stage.gpu == "list") {
    fmt::print("{}", list_gpus());
    return 0;
  }
  constexpr int kMostTold = 20;
  int gl_errors = 0;  // to the end of the context, which closes with the stage
  if (options.gl_errors) {
    options.stage.on_gl_error = [&gl_errors](const std::string& error) {
      if (++gl_errors <= kMostTold) spdlog::error("OpenGL: {}", error);
    };
  }
  const int status = show(options);
  if (gl_errors > 0) spdlog::error("OpenGL told of {} errors", gl_errors);
  return gl_errors > 0 ? kExitFailed : status;
}

}  // namespace
}  // namespace palp

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("viewer"));
  return palp::run_program("palp-viewer", [&] {
    const palp::Parsed<palp::ViewerOptions> parsed = palp::parse_viewer_options(argc, argv);
    if (!parsed.options) return parsed.exit_status;
    palp::catch_stop_signals();
    palp::be_modest(*parsed.options);
    return palp::run(*parsed.options);
  });
}
