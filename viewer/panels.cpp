#include "viewer/panels.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include <imgui.h>

#include "viewer/panel_windows.h"

namespace palp {
namespace {

constexpr std::int64_t kAskAgainNs = 1'000'000'000;   // while no answer has come
constexpr std::int64_t kLookAgainNs = 5'000'000'000;  // others may change parameters, too
constexpr float kColumnLetters = 24;                  // the width of the column, in heights of letters
constexpr float kNarrowestLetters = 14;
constexpr ImU32 kMark = IM_COL32(255, 190, 66, 255);

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace

PanelOptions panels_of(const ViewerOptions& options) {
  PanelOptions panels;
  if (options.stage.headless) panels.shown = PanelDetail::none;
  if (options.panels) panels.shown = PanelDetail::all;
  panels.in_pictures = options.panels;
  return panels;
}

Panels::Panels(Stage& stage, Session& session, Session::Send send, const ViewerSettings& settings,
               const PanelOptions& options)
    : stage_(stage),
      session_(session),
      send_(std::move(send)),
      shown_(options.shown.value_or(settings.panels)),
      layer_(
          stage, [this] { build(); }, options.in_pictures) {
  data_.settings = settings;
  data_.settings.panels = shown_;
  data_.plots = &plots_;
  Reading reading = session.reading();
  reading.map = settings.map;
  reading.held = settings.held;
  session.set_reading(reading);
  session.set_touch_marked(session.touch_marked() || settings.touch);
  apply_settings();
}

// Puts theme and size of words into effect.
void Panels::apply_settings() {
  layer_.set_theme(data_.settings.theme);
  stage_.hud().set_theme(data_.settings.theme);
  stage_.hud().set_text_scale(static_cast<float>(data_.settings.text_scale));
}

void Panels::read_answers(const FeedView& view) {
  data_.refusal = view.refusal;
  data_.bill = view.told_of(kBillName);
  if (const auto scenes = view.told_of(kScenesName); scenes != scenes_told_) {
    scenes_told_ = scenes;
    data_.scenes = scenes ? lines_of(*scenes) : std::vector<std::string>();
  }
  if (const auto parameters = view.told_of(""); parameters != listed_ && !ImGui::IsAnyItemActive()) {
    listed_ = parameters;
    data_.parameters = listed_ ? read_parameter_list(*listed_) : std::vector<ListedParameter>();
  }
}

// Asks for what open panels show: at once where a command may have changed it, else now and then.
void Panels::ask_server(const FeedView& view, std::int64_t now_ns) {
  const bool answered = std::exchange(answers_, view.answers) != view.answers;
  const auto ask = [&](const char* name, bool wanted) {
    const std::int64_t wait_ns = view.told_of(name) ? kLookAgainNs : kAskAgainNs;
    if (!view.scene || !wanted || (!answered && now_ns - asked_ns_[name] <= wait_ns)) return;
    asked_ns_[name] = now_ns;
    send_(CommandKind::get_parameter, name, "");
  };
  const bool open = data_.settings.panels == PanelDetail::all;
  ask("", open && data_.settings.control);
  ask(kBillName, open && data_.settings.bill);
  ask(kScenesName, data_.settings.panels != PanelDetail::none);
}

void Panels::update(const FeedView& view, std::int64_t now_ns) {
  plots_.add(view, session_.figures(), now_ns);
  data_.now = 1e-9 * static_cast<double>(now_ns);
  data_.figures = session_.figures();
  data_.scene = session_.scene() ? session_.scene()->name : "";
  data_.field = session_.field();
  const ParticleCloud& cloud = stage_.scene().cloud();
  data_.shown_field = session_.frame() ? cloud.shown_field() : ScalarField::none;
  data_.range = cloud.range();
  data_.content = stage_.scene().content();
  data_.beads = session_.beads();
  data_.draws_all = session_.draws_all();
  data_.following = stage_.following();
  data_.figures_shown = stage_.hud().visible();
  data_.reading = told_reading_ = session_.reading();
  data_.settings.map = data_.reading.map;
  data_.settings.touch = session_.touch_marked();
  data_.settings.held = data_.reading.held;
  read_answers(view);
  ask_server(view, now_ns);
  if (picked_ && picked_in_ != session_.scene()) picked_.reset();
  data_.picked = picked_ ? describe(stage_, session_, *picked_) : std::nullopt;
  // the help stands alone
  shown_ = std::min(data_.settings.panels, stage_.hud().help_shown() ? PanelDetail::menu : PanelDetail::all);
  stage_.hud().set_size(stage_.width(), stage_.height());
  const float letter = stage_.hud().font_size();
  layer_.set_font_size(letter);
  const bool column = shown_ == PanelDetail::all || data_.picked.has_value();
  const float room = static_cast<float>(stage_.width()) - stage_.hud().figures_width();
  column_width_ = column ? std::max(std::min(kColumnLetters * letter, room), kNarrowestLetters * letter) : 0;
  // the menu's height follows from the style
  stage_.hud().set_panels(shown_ == PanelDetail::none ? 0 : std::ceil(1.4f * letter), column_width_);
  stage_.set_taken_right(shown_ == PanelDetail::all ? column_width_ : 0);
}

void Panels::draw_marks() {
  if (!picked_ || !data_.picked) return;
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  const auto height = static_cast<float>(stage_.height());
  for (const std::vector<osg::Vec2d>& line : marks_of(stage_, session_, *picked_)) {
    std::vector<ImVec2> points;
    for (const osg::Vec2d& p : line) points.emplace_back(static_cast<float>(p.x()), height - static_cast<float>(p.y()));
    draw.AddPolyline(points.data(), static_cast<int>(points.size()), kMark, ImDrawFlags_None, 2);
  }
}

void Panels::build() {
  draw_marks();
  const float menu = shown_ == PanelDetail::none ? 0 : draw_menu(data_);
  if (shown_ == PanelDetail::all || data_.picked) draw_column(data_, menu, column_width_, shown_ == PanelDetail::all);
}

std::vector<Request> Panels::take_requests() {
  // a key may have changed the session's since
  if (data_.reading != told_reading_) session_.set_reading(told_reading_ = data_.reading);
  if (data_.asked_field) session_.show_field(*data_.asked_field);
  data_.asked_field.reset();
  if (data_.asked_scene) send_(CommandKind::load_scene, *data_.asked_scene, "");
  data_.asked_scene.reset();
  for (const auto& [name, value] : std::exchange(data_.asked_values, {}))
    send_(CommandKind::set_parameter, name, value);
  apply_settings();
  for (const osg::Vec2d& place : layer_.take_clicks()) pick_at(place);
  return std::exchange(data_.requests, {});
}

void Panels::pick_at(const osg::Vec2d& place) {
  picked_ = pick(stage_, session_, place);
  picked_in_ = session_.scene();
  data_.picked = picked_ ? describe(stage_, session_, *picked_) : std::nullopt;
}

void Panels::act(const Request& request, Stage& in) {
  ViewerSettings& s = data_.settings;
  switch (request.action) {
    case Action::panels:
      s.panels = static_cast<PanelDetail>((static_cast<std::size_t>(s.panels) + 1) % kPanelDetailNames.size());
      break;
    case Action::full_screen:
      in.toggle_full_screen();
      break;
    case Action::store_view:
      if (!data_.scene.empty()) s.store_view(data_.scene, request.number, in.view());
      break;
    case Action::recall_view:
      if (const auto view = s.view_of(data_.scene, request.number)) in.set_view(*view);
      break;
    case Action::next_scene:
      if (!data_.scenes.empty()) {
        const auto shown = std::ranges::find(data_.scenes, data_.scene);
        const bool last = shown == data_.scenes.end() || shown + 1 == data_.scenes.end();
        send_(CommandKind::load_scene, last ? data_.scenes.front() : shown[1], "");
      }
      break;
    case Action::let_go:
      if (picked_ && &in == &stage_) {
        picked_.reset();
      } else if (in.hud().help_shown()) {
        in.hud().set_help(false);
      } else {
        in.viewer().setDone(true);
      }
      break;
    default:
      break;  // of the session
  }
}

}  // namespace palp
