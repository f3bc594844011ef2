#include "viewer/session.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "viewer/body_colors.h"

namespace palp {
namespace {

constexpr std::int64_t kFiguresEveryNs = 250'000'000;  // faster cannot be read
constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kAnswerNs = kSecondNs;        // a server sends the field that it is asked for within this
constexpr std::int64_t kSilenceNs = 3 * kSecondNs;   // of a server, after which it is worth a word
constexpr std::int64_t kLongLoadNs = kSecondNs / 2;  // surfaces that take longer are worth a word

bool is_paused(const FeedView& view) {
  for (const auto& proxy : view.proxies) {
    if (proxy && (proxy->flags & kPaused) != 0) return true;
  }
  const auto server = view.status.find("sim_server");
  return server != view.status.end() && server->second.state == "paused";
}

// Fills in what the hand feels that feels most.
void read_hands(const FeedView& view, HudData& d) {
  const auto larger = [](std::optional<double>& kept, double value) { kept = std::max(kept.value_or(0), value); };
  for (const auto& proxy : view.proxies) {
    if (!proxy) continue;
    const auto& f = proxy->wrench.force;
    const auto& t = proxy->wrench.torque;
    larger(d.force, std::hypot(f[0], f[1], f[2]));
    larger(d.torque, std::hypot(t[0], t[1], t[2]));
    larger(d.contact, proxy->blend[0]);
  }
}

// Says what marks on tools stand for: the same pressures, or that they are touched.
void tell_marks(Legend& legend) {
  if (legend.field == ScalarField::none)
    legend.bodies.emplace(legend.bodies.begin(), "touched on tools", kTouchedColor);
  else
    legend.also = legend.field == ScalarField::pressure ? "also on tools" : "tools where touched";
}

bool is_zero(float value) { return value == 0; }

// Returns how fast a count grows, per second, over the last second or more.
double rate_of(std::deque<std::pair<std::int64_t, std::uint64_t>>& history, std::int64_t now_ns, std::uint64_t count) {
  history.emplace_back(now_ns, count);
  while (history.size() > 2 && now_ns - history[1].first >= kSecondNs) history.pop_front();
  const auto [since, before] = history.front();
  return now_ns > since && count >= before
             ? static_cast<double>(count - before) * kSecondNs / static_cast<double>(now_ns - since)
             : 0;
}

}  // namespace

Session::Session(Stage& stage, ScalarField color, Send send) : stage_(stage), stages_{&stage}, send_(std::move(send)) {
  set_color(color);
}

void Session::set_further(std::vector<Stage*> stages) {
  stages_ = std::move(stages);
  stages_.insert(stages_.begin(), &stage_);
}

void Session::set_color(ScalarField field) {
  color_ = field;
  stage_.scene().set_color(field);
}

void Session::ask_for_field() {
  if (color_ == ScalarField::none) return;
  send_(CommandKind::set_parameter, "stream.scalar", std::string(row_of(color_).name));
  field_came_ = false;
  just_asked_ = true;
}

// Returns why the particles do not have the colours that the user asked for, or nothing.
std::string Session::field_note(std::int64_t now_ns) {
  if (std::exchange(just_asked_, false)) asked_at_ns_ = now_ns;
  if (!frame_ || color_ == ScalarField::none) return {};
  if (frame_->field == color_) {
    const bool nothing = color_ == ScalarField::temperature && std::ranges::all_of(frame_->scalars, is_zero);
    return nothing ? "this scene has no temperatures" : "";
  }
  if (now_ns - asked_at_ns_ < kAnswerNs && !field_came_) return {};
  const std::string sent = frame_->field == ScalarField::none ? "no field" : std::string(legend_name(frame_->field));
  return fmt::format("asked: {}, the server sends {}{}", legend_name(color_), sent,
                     field_came_ ? " (asked by another)" : "");
}

// Notes whether the server has ended or fallen silent.
void Session::watch_server(const FeedView& view, std::int64_t now_ns) {
  const auto server = view.status.find("sim_server");
  const bool told = server != view.status.end();
  if (told) server_ended_ = server->second.state == "ended";
  const auto heard = std::tuple(told ? server->second.header.sequence : 0, view.frames, view.poses.get());
  if (heard != server_heard_) server_heard_ns_ = now_ns;
  server_heard_ = heard;
}

void Session::take_scene(const FeedView& view, std::int64_t now_ns) {
  sent_scene_ = view.scene;
  scene_ = with_distinct_colors(sent_scene_);
  frame_ = nullptr;
  earlier_ = nullptr;
  poses_ = nullptr;
  frames_at_ns_.clear();
  stage_.scene().set_scene(*scene_);
  for (Stage* stage : stages_) stage->go_home();
  surfaces_.start(scene_);
  surfaces_asked_ns_ = now_ns;
  surfaces_told_ = false;
  server_ended_ = false;
  server_heard_ns_ = now_ns;
  spdlog::info("scene '{}': {} particles, {} bodies, {} triangles", scene_->name, scene_->particle_count,
               scene_->bodies.size(), surfaces_.triangles());
  ask_for_field();
}

void Session::take_surfaces(std::int64_t now_ns) {
  if (!surfaces_.busy()) return;
  std::vector<LoadedSurface> taken = surfaces_.take();
  for (LoadedSurface& surface : taken) {
    if (surface.skin)
      stage_.scene().set_soft_surface(surface.body, surface.mesh, std::move(*surface.skin));
    else
      stage_.scene().set_surface(surface.body, surface.mesh);
  }
  // its particles carry some of them along, and are mirrored in others
  if (!taken.empty() && frame_) stage_.scene().set_frame(*frame_, earlier_.get());
  const std::int64_t since = now_ns - surfaces_asked_ns_;
  if (!surfaces_.busy()) {
    for (Stage* stage : stages_) stage->go_home_unless_moved();
    if (surfaces_told_) spdlog::info("the surfaces are built, after {:.1f} s", 1e-9 * static_cast<double>(since));
  } else if (!surfaces_told_ && since > kLongLoadNs) {
    spdlog::info("building surfaces of {} triangles beside the pictures", surfaces_.triangles());
    surfaces_told_ = true;
  }
}

void Session::update(const FeedView& view, std::int64_t now_ns) {
  const bool new_scene = view.scene && view.scene != sent_scene_;
  if (new_scene) take_scene(view, now_ns);
  if (scene_) {
    take_surfaces(now_ns);
    if (view.poses && view.poses != poses_) {
      poses_ = view.poses;
      stage_.scene().set_poses(*poses_);
    }
    if (view.frame && view.frame != frame_) {
      const bool first = !frame_;
      frame_ = view.frame;
      earlier_ = view.earlier;
      ++frames_drawn_;
      field_came_ = field_came_ || frame_->field == color_;
      stage_.scene().set_frame(*frame_, earlier_.get());
      if (first)
        for (Stage* stage : stages_) stage->go_home();
    }
    for (std::uint32_t device = 0; device < kMaxDevices; ++device) {
      const auto& proxy = view.proxies[device];
      proxy ? stage_.scene().set_proxy(*proxy) : stage_.scene().hide_proxy(device);
    }
  }
  for (Stage* stage : stages_) stage->follow_tools(1e-9 * static_cast<double>(now_ns - followed_at_ns_));
  followed_at_ns_ = now_ns;
  watch_server(view, now_ns);
  const bool paused = is_paused(view);
  if (new_scene || paused != paused_ || now_ns - figures_at_ns_ >= kFiguresEveryNs) {
    paused_ = paused;
    refresh_figures(view, now_ns);
  }
}

void Session::refresh_figures(const FeedView& view, std::int64_t now_ns) {
  figures_at_ns_ = now_ns;
  HudData d;
  d.connected = scene_ != nullptr;
  d.paused = paused_;
  read_status(view.status, d);
  stage_.scene().set_reaches(reaches_of(view.status));
  d.shown_rate_hz = static_cast<double>(shown_at_ns_.size());
  d.frame_rate_hz = rate_of(frames_at_ns_, now_ns, view.frames);
  d.lost_frames = view.lost_frames;
  d.way = view.way;
  d.particles = stage_.scene().cloud().drawn();
  d.server_ended = server_ended_;
  if (scene_ && now_ns - server_heard_ns_ > kSilenceNs)
    d.server_silent = 1e-9 * static_cast<double>(now_ns - server_heard_ns_);
  if (frame_) {
    d.frame_age = std::max(0.0, 1e-9 * static_cast<double>(now_ns - view.frame_time_ns));
    d.sim_time = frame_->sim_time;
    d.note = field_note(now_ns);
  }
  if (!view.two_servers.empty()) d.note = view.two_servers;
  if (surfaces_told_ && surfaces_.busy()) d.surfaces_built = surfaces_.share_done();
  if (!view.notice.empty()) d.note = view.notice;
  // one sample for the figures and for what stands beside the arrows, so that they say the same
  read_hands(view, d);
  for (std::uint32_t device = 0; device < kMaxDevices; ++device)
    if (const auto& proxy = view.proxies[device]) stage_.scene().set_values(device, proxy->wrench);
  d.touched = stage_.scene().touch();
  d.arrow_force = stage_.scene().arrow_force();
  d.arrow_length = stage_.scene().arrow_length();
  figures_ = d;
  for (Stage* stage : stages_) stage->hud().set_data(d);
  if (!scene_) return;
  Legend legend;
  legend.field = stage_.scene().cloud().shown_field();
  legend.range = stage_.scene().cloud().range();
  legend.map = stage_.scene().cloud().color_map_kind();
  if (legend.field == ScalarField::none) {
    legend.range = {};
    legend.map = {};
    for (const BodyDescription& body : scene_->bodies) legend.bodies.emplace_back(body.name, body.color);
  }
  if (d.touched) tell_marks(legend);
  stage_.hud().set_legend(legend);
}

void Session::shown(std::int64_t now_ns) {
  shown_at_ns_.push_back(now_ns);
  while (now_ns - shown_at_ns_.front() >= kSecondNs) shown_at_ns_.pop_front();
}

// Draws the newest frame once more, as what is drawn of it has changed.
void Session::show_again() {
  if (frame_) stage_.scene().set_frame(*frame_, earlier_.get());
  figures_at_ns_ = 0;
}

void Session::set_beads(bool beads) {
  beads_ = beads;
  stage_.scene().set_beads(beads);
  show_again();
}

void Session::set_touch_marked(bool marked) {
  touch_marked_ = marked;
  stage_.scene().set_touch_marked(marked);
  show_again();
}

void Session::show_field(ScalarField field) {
  set_color(field);
  ask_for_field();
  show_again();
}

void Session::set_reading(const Reading& reading) {
  reading_ = reading;
  stage_.scene().set_reading(reading);
  show_again();
}

void Session::act_on_reading(Action action) {
  Reading reading = reading_;
  const ParticleCloud& cloud = stage_.scene().cloud();
  if (action == Action::next_map) {
    const std::size_t next = reading.map ? static_cast<std::size_t>(*reading.map) + 1 : 0;
    reading.map = next < kColorMapNames.size() ? std::optional(static_cast<ColorMapKind>(next)) : std::nullopt;
  } else if (action == Action::hold_range) {
    std::optional<ValueRange>& held = reading.held_of(cloud.shown_field());
    held = held || cloud.shown_field() == ScalarField::none ? std::nullopt : std::optional(cloud.range());
  } else if (action == Action::clip) {
    reading.clip.on = !reading.clip.on;
  } else if (action == Action::clip_axis) {
    reading.clip.axis = (reading.clip.axis + 1) % 3;
  } else {
    constexpr double kStep = 0.02;
    const double share = reading.clip.share + (action == Action::clip_forth ? kStep : -kStep);
    reading.clip.share = std::clamp(share, 0.0, 1.0);
  }
  set_reading(reading);
}

void Session::act(const Request& request, Stage& in) {
  switch (request.action) {
    case Action::next_color:
      show_field(static_cast<ScalarField>((static_cast<std::size_t>(color_) + 1) % kScalarFields.size()));
      break;
    case Action::home:
      in.go_home();
      break;
    case Action::follow:
      in.set_following(!in.following());
      break;
    case Action::surfaces:
      draw_all_ = !draw_all_;
      stage_.scene().set_draw_all(draw_all_);
      show_again();
      break;
    case Action::beads:
      set_beads(!beads_);
      break;
    case Action::touch:
      set_touch_marked(!touch_marked_);
      break;
    case Action::next_map:
    case Action::hold_range:
    case Action::clip:
    case Action::clip_axis:
    case Action::clip_back:
    case Action::clip_forth:
      act_on_reading(request.action);
      break;
    case Action::pause_or_resume:
      send_(paused_ ? CommandKind::resume : CommandKind::pause, "", "");
      break;
    case Action::single_step:
      send_(CommandKind::step, "", "");
      break;
    case Action::reset:
      send_(CommandKind::reset, "", "");
      break;
    case Action::reload:
      send_(CommandKind::load_scene, "", "");
      break;
    case Action::screenshot:
      in.ask_for_picture();
      break;
    case Action::help:
      in.hud().set_help(!in.hud().help_shown());
      break;
    case Action::figures:
      stage_.hud().show_next_detail();
      stage_.scene().set_values_shown(stage_.hud().visible());
      break;
    default:
      break;  // of the window and its panels
  }
}

}  // namespace palp
