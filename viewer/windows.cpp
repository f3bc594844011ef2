#include "viewer/windows.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace palp {
namespace {

constexpr int kLeastWidth = 320, kLeastHeight = 240;  // of a further window [pixels]
constexpr int kStepOfWindows = 48;                    // from one window to the next, across and down [pixels]

}  // namespace

Windows::Windows(Stage& first, const ViewerOptions& options, Session& session, Panels& panels,
                 osgGA::GUIEventHandler* more_keys)
    : first_(first),
      options_(options),
      session_(session),
      panels_(panels),
      more_keys_(more_keys),
      first_keys_(new KeyHandler) {
  first_.viewer().addEventHandler(first_keys_);
  for (int i = 1; i < options.windows; ++i) open();
}

Windows::~Windows() { session_.set_further({}); }

void Windows::open() {
  if (further_.size() + 1 >= kMostWindows)
    throw std::runtime_error(fmt::format("a viewer has {} windows at most", kMostWindows));
  StageOptions options = options_.stage;
  options.width = std::max(options.width / 2, kLeastWidth);
  options.height = std::max(options.height / 2, kLeastHeight);
  const int number = ++opened_;
  options.title = fmt::format("{} {}", options.title, number + 1);
  options.x += kStepOfWindows * number;
  options.y += kStepOfWindows * number;
  Window window{std::make_unique<Stage>(options, first_), new KeyHandler};
  Hud& hud = window.stage->hud();
  hud.set_detail(HudDetail::banner);
  auto help = first_.hud().help_lines();
  std::erase_if(help, [](const auto& line) { return line.first == "click"; });  // panels tell what was clicked
  hud.set_help_lines(std::move(help));
  hud.set_visible(options_.figures);
  hud.set_data(session_.figures());
  if (more_keys_) window.stage->viewer().addEventHandler(more_keys_);
  window.stage->viewer().addEventHandler(window.keys);
  further_.push_back(std::move(window));
  tell_session();
}

void Windows::open_or_say_why_not() {
  try {
    open();
  } catch (const std::runtime_error& error) {
    spdlog::warn("{}", error.what());
  }
}

// A window's user closes it, and that of the first one the newest.
void Windows::close_in(Stage& in) {
  if (&in != &first_)
    in.viewer().setDone(true);
  else if (!further_.empty())
    further_.back().stage->viewer().setDone(true);
}

void Windows::tell_session() {
  std::vector<Stage*> stages;
  for (const Window& window : further_) stages.push_back(window.stage.get());
  session_.set_further(std::move(stages));
}

void Windows::draw(const std::function<void(Picture&&)>& save) {
  for (Window& window : further_) {
    Stage& stage = *window.stage;
    stage.hud().set_theme(panels_.settings().theme);
    stage.hud().set_text_scale(static_cast<float>(panels_.settings().text_scale));
    if (stage.viewer().done()) continue;
    if (stage.take_picture_wish())
      stage.draw(save);
    else
      stage.draw();
  }
}

void Windows::obey_in(Stage& in, const std::vector<Request>& requests) {
  for (const Request& request : requests) {
    if (request.action == Action::open_window)
      open_or_say_why_not();
    else if (request.action == Action::close_window)
      close_in(in);
    session_.act(request, in);
    panels_.act(request, in);
  }
}

void Windows::obey() {
  obey_in(first_, first_keys_->take());
  obey_in(first_, panels_.take_requests());
  // a request may open a window and move them
  for (std::size_t i = 0; i < further_.size(); ++i) obey_in(*further_[i].stage, further_[i].keys->take());
  const auto closed = [](const Window& window) { return window.stage->viewer().done(); };
  if (std::ranges::none_of(further_, closed)) return;
  std::erase_if(further_, closed);
  tell_session();
}

}  // namespace palp
