// Menu, panels and what goes with them: clicks, stored views and settings. Used by the thread that renders.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "viewer/imgui_layer.h"
#include "viewer/inspection.h"
#include "viewer/options.h"
#include "viewer/panel_data.h"
#include "viewer/session.h"
#include "viewer/settings.h"

namespace palp {

struct PanelOptions {
  std::optional<PanelDetail> shown;  // whatever the settings say
  bool in_pictures = false;          // panels are also in the pictures that are read
};

// Off-screen none are shown but where the command line asks for them.
PanelOptions panels_of(const ViewerOptions& options);

class Panels {
 public:
  // Takes over what settings say. stage and session must outlive the panels. send: as the session's.
  Panels(Stage& stage, Session& session, Session::Send send, const ViewerSettings& settings,
         const PanelOptions& options);

  // Takes over what is new, before a picture. now_ns: CLOCK_MONOTONIC.
  void update(const FeedView& view, std::int64_t now_ns);
  // Does what was asked for with the mouse since the last call, after a picture. Returns what else was asked for, for
  // session and panels alike.
  std::vector<Request> take_requests();
  // Does what concerns panels, stored views and a window, which is the stage or one beside it; the rest is passed over.
  void act(const Request& request, Stage& in);
  void act(const Request& request) { act(request, stage_); }

  const ViewerSettings& settings() const { return data_.settings; }
  const std::optional<PickedLines>& picked() const { return data_.picked; }
  // Selects what is at a place of the picture, in pixels from its lower left corner, or lets go.
  void pick_at(const osg::Vec2d& place);

 private:
  void build();
  void draw_marks();
  void read_answers(const FeedView& view);
  void ask_server(const FeedView& view, std::int64_t now_ns);
  void apply_settings();

  Stage& stage_;
  Session& session_;
  Session::Send send_;
  PanelData data_;
  Reading told_reading_;  // that windows were given to change
  Plots plots_;
  PanelDetail shown_;
  std::optional<Picked> picked_;
  std::shared_ptr<const SceneDescription> picked_in_;  // the scene that picked_ is of
  std::shared_ptr<const std::string> listed_;          // what data_.parameters was read from
  std::shared_ptr<const std::string> scenes_told_;     // what data_.scenes was read from
  std::uint64_t answers_ = 0;
  std::map<std::string, std::int64_t> asked_ns_;  // when the server was last asked, by what
  float column_width_ = 0;                        // [pixels]
  ImguiLayer layer_;                              // last: it draws from the others
};

}  // namespace palp
