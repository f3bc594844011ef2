// Keeps a stage up to date with the feed and does what the keys ask. Used by the thread that renders.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "viewer/controls.h"
#include "viewer/feed_state.h"
#include "viewer/reading.h"
#include "viewer/stage.h"
#include "viewer/surface_loader.h"

namespace palp {

class Session {
 public:
  using Send = std::function<void(CommandKind, const std::string& name, const std::string& value)>;

  // stage must outlive the session. color: the field that colours show, which the server is asked to send; none: how
  // bodies look.
  Session(Stage& stage, ScalarField color, Send send);

  // Takes over what is new. now_ns: CLOCK_MONOTONIC.
  void update(const FeedView& view, std::int64_t now_ns);
  // Counts a picture that was shown.
  void shown(std::int64_t now_ns);

  // Does what concerns the scene, its server and the view of a window, which is the stage or one beside it; the rest is
  // passed over.
  void act(const Request& request, Stage& in);
  void act(const Request& request) { act(request, stage_); }
  // Takes the windows beside the stage on its scene: they go home with it, and have the same banner.
  void set_further(std::vector<Stage*> stages);
  // Shows this field by colours, and asks the server for it; none: how bodies look.
  void show_field(ScalarField field);
  void set_reading(const Reading& reading);
  // Draws liquids and soft bodies as beads, or as surfaces.
  void set_beads(bool beads);
  // Marks where media touch tools.
  void set_touch_marked(bool marked);

  std::uint64_t frames_drawn() const { return frames_drawn_; }  // particle frames handed to the stage
  const HudData& figures() const { return figures_; }
  bool surfaces_complete() const { return !surfaces_.busy(); }
  const Reading& reading() const { return reading_; }
  ScalarField field() const { return color_; }  // that was asked for
  bool beads() const { return beads_; }
  bool touch_marked() const { return touch_marked_; }
  bool draws_all() const { return draw_all_; }
  bool paused() const { return paused_; }
  // The scene with a colour for every body, and its newest particles; null: there are none.
  const std::shared_ptr<const SceneDescription>& scene() const { return scene_; }
  const std::shared_ptr<const ParticleFrame>& frame() const { return frame_; }

 private:
  void take_scene(const FeedView& view, std::int64_t now_ns);
  void take_surfaces(std::int64_t now_ns);
  void refresh_figures(const FeedView& view, std::int64_t now_ns);
  void watch_server(const FeedView& view, std::int64_t now_ns);
  std::string field_note(std::int64_t now_ns);
  void set_color(ScalarField field);
  void ask_for_field();
  void show_again();
  void act_on_reading(Action action);

  Stage& stage_;
  std::vector<Stage*> stages_;  // with those beside it
  Send send_;
  ScalarField color_ = ScalarField::none;
  bool field_came_ = false;  // the server has sent color_ since it was asked for
  bool just_asked_ = false;  // for it, and the time is not noted yet
  std::int64_t asked_at_ns_ = 0;
  bool draw_all_ = false;
  bool beads_ = false;
  bool touch_marked_ = false;
  std::int64_t followed_at_ns_ = 0;
  Reading reading_;
  bool paused_ = false;
  std::shared_ptr<const SceneDescription> sent_scene_;  // by the server
  std::shared_ptr<const SceneDescription> scene_;       // with a colour for every body
  SurfaceLoader surfaces_;
  std::int64_t surfaces_asked_ns_ = 0;
  bool surfaces_told_ = false;  // the log has said that it takes long
  std::shared_ptr<const ParticleFrame> frame_;
  std::shared_ptr<const ParticleFrame> earlier_;  // than frame_, a little; null: none is known
  std::shared_ptr<const BodyPoses> poses_;
  std::uint64_t frames_drawn_ = 0;
  std::tuple<std::uint64_t, std::uint64_t, const BodyPoses*> server_heard_;  // what it said last, to see that it speaks
  std::int64_t server_heard_ns_ = 0;
  bool server_ended_ = false;  // by its own word
  std::int64_t figures_at_ns_ = 0;
  HudData figures_;
  std::deque<std::int64_t> shown_at_ns_;                             // pictures of the last second
  std::deque<std::pair<std::int64_t, std::uint64_t>> frames_at_ns_;  // time, count of frames received
};

}  // namespace palp
