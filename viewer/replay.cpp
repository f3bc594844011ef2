#include "viewer/replay.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "config/data_dir.h"
#include "config/error.h"
#include "config/stop_signal.h"
#include "idl/clock.h"
#include "viewer/camera_script.h"
#include "viewer/capture.h"
#include "viewer/draw_times.h"
#include "viewer/panels.h"
#include "viewer/playback.h"
#include "viewer/playback_keys.h"
#include "viewer/replay_overlay.h"
#include "viewer/session.h"
#include "viewer/settings.h"
#include "viewer/summary.h"
#include "viewer/windows.h"

namespace palp {
namespace {

constexpr std::int64_t kFilmStartNs = 1'000'000'000;  // of the clock of films
constexpr int kFollowSamples = 17;
constexpr double kTold = 10;  // [s] between lines of progress

// Everything that a picture of a recording is made with.
class Player {
 public:
  Player(const ViewerOptions& options, Stage& stage)
      : stage_(stage), playback_(options.replay.file), session_(stage, options.color, send()) {
    if (!options.replay.script.empty())
      script_ = read_camera_script(find_data_file(kFilmScripts, options.replay.script));
    playback_.set_speed(options.replay.speed);
    if (options.replay.from) start_at(*options.replay.from);
    stage.hud().set_visible(options.figures);
    stage.scene().set_values_shown(options.figures);
    stage.add_overlay(overlay_.camera());
    session_.set_beads(options.beads);
    session_.set_touch_marked(options.touch);
  }

  Playback& playback() { return playback_; }
  // Returns what a session sends to its server with; the player must outlive it.
  Session::Send send() {
    return [this](CommandKind kind, const std::string& name, const std::string&) { playback_.obey(kind, name); };
  }
  Session& session() { return session_; }
  ReplayOverlay& overlay() { return overlay_; }

  // Takes over and returns what is shown at the playback's time. whole: waits for the surfaces of a new scene.
  FeedView update(std::int64_t now_ns, bool whole) {
    const FeedView view = playback_.view(now_ns);
    session_.update(view, now_ns);
    while (whole && !session_.surfaces_complete() && !stop_asked()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      session_.update(view, now_ns);
    }
    overlay_.set_size(stage_.width(), stage_.height(), stage_.taken_right());
    if (script_) follow_script();
    return view;
  }

 private:
  void start_at(double from) {
    const TimeRange range = playback_.range();
    if (from > range.last)
      throw ConfigError(
          fmt::format("--from {:g}: the recording ends at {:g} s, expected a time before that", from, range.last));
    playback_.seek(from);
  }

  void follow_script() {
    const double time = playback_.time();
    const CameraKey key = camera_at(script_->keys, time);
    const Eigen::Vector3d by = script_->follow ? way_of_tool(*script_->follow, time) : Eigen::Vector3d::Zero();
    const Eigen::Vector3d eye = key.eye + by, center = key.look_at + by;
    stage_.set_camera({{eye.x(), eye.y(), eye.z()}, {center.x(), center.y(), center.z()}}, key.field_of_view);
    const ShownCaption caption = caption_at(script_->captions, time);
    overlay_.set_caption(caption.text, caption.opacity);
  }

  // Returns by how much the camera goes with the tool [m]: a mean over the time around, so that it goes smoothly.
  Eigen::Vector3d way_of_tool(const CameraFollow& follow, double time) {
    const auto start = playback_.handle_at_start(follow.device);
    if (!start) return Eigen::Vector3d::Zero();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int i = 0; i < kFollowSamples; ++i) {
      const double at = time + follow.smooth * (static_cast<double>(i) / (kFollowSamples - 1) - 0.5);
      sum += playback_.handle_at(follow.device, at).value_or(*start) - *start;
    }
    return follow.share / kFollowSamples * sum;
  }

  Stage& stage_;
  Playback playback_;
  Session session_;
  ReplayOverlay overlay_;
  std::optional<CameraScript> script_;
};

// The pictures of a film: when each is shown, and the files that it is written to.
class Film {
 public:
  Film(const ViewerOptions& options, const Stage& stage, const Playback& playback)
      : options_(options), begin_(playback.time()) {
    const double whole = (playback.range().last - begin_) / options.replay.speed;  // [s] of the film
    const double length = options.seconds > 0 ? std::min(options.seconds, whole) : whole;
    // a film of a second has as many pictures as its rate says; one of no length has one
    const bool moving = !options.video.empty() || !options.replay.frames.empty() || options.png.empty();
    const auto count = static_cast<std::size_t>(std::max(1.0, std::round(length * options.rate_hz)));
    if (moving)
      for (std::size_t k = 0; k < count; ++k) times_.push_back(static_cast<double>(k) / options.rate_hz);
    add_stills(length, moving);
    if (!options.video.empty()) capture_.open_video(options.video, stage.width(), stage.height(), options.rate_hz);
  }

  std::size_t count() const { return times_.size(); }
  double film_time(std::size_t k) const { return times_[k]; }  // [s] since the film's begin
  double simulated(std::size_t k) const { return begin_ + options_.replay.speed * times_[k]; }

  void take(std::size_t k, Picture&& picture) {
    capture_.wait_for_room();
    if (capture_.video_open()) capture_.write_video(picture, times_[k]);
    if (!options_.replay.frames.empty())
      capture_.write_png(numbered(options_.replay.frames, static_cast<int>(k) + 1), picture);
    for (const auto& [at, file] : stills_)
      if (at == k) capture_.write_png(file, picture);
  }

  bool finish() { return capture_.finish(); }

 private:
  // Chooses the pictures of which PNGs are wanted; where there is no other, these are all.
  void add_stills(double length, bool moving) {
    if (options_.png.empty()) return;
    std::vector<double> at;
    if (options_.png_every) {
      for (int i = 0; i * *options_.png_every <= length; ++i) at.push_back(i * *options_.png_every);
    } else {
      at.push_back(std::min(options_.png_at.value_or(length), length));
    }
    for (std::size_t i = 0; i < at.size(); ++i) {
      const std::string file = options_.png_every ? numbered(options_.png, static_cast<int>(i) + 1) : options_.png;
      const auto due = static_cast<std::size_t>(std::ceil(at[i] * options_.rate_hz - 1e-6));
      stills_.emplace_back(moving ? std::min(due, times_.size() - 1) : i, file);
    }
    if (!moving) times_ = at;
  }

  const ViewerOptions& options_;
  double begin_;               // [s] simulated
  std::vector<double> times_;  // [s] of the film
  std::vector<std::pair<std::size_t, std::string>> stills_;
  Capture capture_;
};

// Returns false if the summary cannot be written.
bool sum_up(const ViewerOptions& options, Player& player, const DrawTimes& draw_times, bool healthy) {
  if (options.summary.empty()) return true;
  const FeedView view = player.playback().view(now_ns());
  return write_summary(options.summary, {{"lost_frames", view.lost_frames},
                                         {"refused_samples", view.refused},
                                         {"drawn_frames", player.session().frames_drawn()},
                                         {"pictures", draw_times.count()},
                                         {"draw_p50_ms", draw_times.share_ms(0.5)},
                                         {"draw_p99_ms", draw_times.share_ms(0.99)},
                                         {"healthy", healthy}});
}

int make_film(const ViewerOptions& options, Stage& stage) {
  Player player(options, stage);
  Film film(options, stage, player.playback());
  DrawTimes draw_times;
  double told = 0;
  const std::int64_t start_ns = now_ns();
  std::size_t k = 0;
  for (; k < film.count() && !stop_asked() && !stage.viewer().done(); ++k) {
    player.playback().seek(film.simulated(k));
    // the clock of the film, so that nothing in a picture depends on how long it took
    const std::int64_t film_ns = kFilmStartNs + std::llround(1e9 * film.film_time(k));
    player.update(film_ns, true);
    const std::int64_t begun_ns = now_ns();
    stage.draw([&](Picture&& picture) { film.take(k, std::move(picture)); });
    player.session().shown(film_ns);
    draw_times.add(1e-9 * static_cast<double>(now_ns() - begun_ns));
    const double since = 1e-9 * static_cast<double>(now_ns() - start_ns);
    if (since - told >= kTold) {
      spdlog::info("picture {} of {}", k + 1, film.count());
      told = since;
    }
  }
  if (k < film.count()) spdlog::warn("the film was cut short: {} of {} pictures", k, film.count());
  const bool whole = film.finish() && k == film.count();
  return sum_up(options, player, draw_times, whole) && whole ? 0 : 1;
}

// Shows time and speed.
void show_time(Player& player, Stage& stage) {
  const Playback& playback = player.playback();
  player.overlay().set_timeline_shown(stage.hud().visible());
  player.overlay().set_timeline(playback.range().first, playback.range().last, playback.time(), playback.speed(),
                                playback.paused());
}

int play(const ViewerOptions& options, Stage& stage) {
  Player player(options, stage);
  const osg::ref_ptr<PlaybackKeys> playback_keys = new PlaybackKeys(player.playback(), player.overlay());
  stage.viewer().addEventHandler(playback_keys);
  stage.hud().set_help_lines(playback_help_lines());
  SettingsFile settings(options.settings, options.writes_settings);
  Panels panels(stage, player.session(), player.send(), settings.settings(), panels_of(options));
  Windows windows(stage, options, player.session(), panels, new PlaybackKeys(player.playback()));

  using Clock = std::chrono::steady_clock;
  Capture capture;
  DrawTimes draw_times;
  const auto start = Clock::now();
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / options.rate_hz));
  auto shown = start, next = start;
  while (!stop_asked() && !stage.viewer().done()) {
    const auto now = Clock::now();
    if (options.seconds > 0 && std::chrono::duration<double>(now - start).count() >= options.seconds) break;
    player.playback().advance(std::chrono::duration<double>(now - shown).count());
    shown = now;
    panels.update(player.update(now_ns(), false), now_ns());
    show_time(player, stage);
    const std::int64_t begun_ns = now_ns();
    const auto save = [&](Picture&& picture) { capture.write_png(screenshot_name(), std::move(picture)); };
    if (stage.take_picture_wish())
      stage.draw(save);
    else
      stage.draw();
    player.session().shown(now_ns());
    draw_times.add(1e-9 * static_cast<double>(now_ns() - begun_ns));
    windows.draw(save);
    windows.obey();
    settings.keep(panels.settings(), now_ns());
    next = std::max(next + period, Clock::now());
    std::this_thread::sleep_until(next);
  }
  settings.keep(panels.settings(), now_ns(), true);
  const bool whole = capture.finish();
  // the handlers go before what they refer to
  stage.viewer().getEventHandlers().clear();
  return sum_up(options, player, draw_times, whole) && whole ? 0 : 1;
}

}  // namespace

int show_recording(const ViewerOptions& options, Stage& stage) {
  return makes_film(options) ? make_film(options, stage) : play(options, stage);
}

}  // namespace palp
