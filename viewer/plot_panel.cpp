#include "viewer/plot_panel.h"

#include <algorithm>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>

namespace palp {
namespace {

// Along x, y and z; told apart by eyes that see less of red and green, too.
constexpr ImU32 kAxisColors[] = {IM_COL32(226, 100, 60, 255), IM_COL32(70, 170, 110, 255), IM_COL32(90, 140, 240, 255)};

struct Line {
  const History* history;
  ImU32 color;
};

struct Span {
  double low = 0, high = 0;
};

// Returns the values that a plot shows, zero among them.
Span span_of(std::span<const Line> lines, double since) {
  Span span;
  for (const Line& line : lines) {
    for (std::size_t i = 0; i < line.history->size(); ++i) {
      const TimedValue& v = (*line.history)[i];
      if (v.time < since) continue;
      span.low = std::min(span.low, v.value);
      span.high = std::max(span.high, v.value);
    }
  }
  if (span.high - span.low < 1e-12) span.high = span.low + 1;
  return span;
}

void draw_line(const Line& line, const Span& span, double since, const ImVec2& corner, const ImVec2& size) {
  std::vector<ImVec2> points;
  points.reserve(line.history->size());
  for (std::size_t i = 0; i < line.history->size(); ++i) {
    const TimedValue& v = (*line.history)[i];
    if (v.time < since) continue;
    const double x = (v.time - since) / History::kSpan, y = (v.value - span.low) / (span.high - span.low);
    points.emplace_back(corner.x + static_cast<float>(x) * size.x, corner.y + static_cast<float>(1 - y) * size.y);
  }
  ImGui::GetWindowDrawList()->AddPolyline(points.data(), static_cast<int>(points.size()), line.color, ImDrawFlags_None,
                                          1.5f);
}

// words: the newest value with its unit.
void draw_plot(const std::string& title, const std::string& words, std::initializer_list<Line> lines, double now) {
  const double since = now - History::kSpan;
  const Span span = span_of(lines, since);
  ImGui::TextUnformatted(title.c_str());
  const float room = ImGui::GetContentRegionAvail().x, w = ImGui::CalcTextSize(words.c_str()).x;
  ImGui::SameLine(std::max(room - w, 0.0f) + ImGui::GetCursorPosX());
  ImGui::TextUnformatted(words.c_str());
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 size(room, 2.6f * ImGui::GetFontSize());
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImVec2 end(corner.x + size.x, corner.y + size.y);
  draw.AddRectFilled(corner, end, ImGui::GetColorU32(ImGuiCol_FrameBg), 3);
  const float zero = corner.y + static_cast<float>(span.high / (span.high - span.low)) * size.y;
  draw.AddLine({corner.x, zero}, {end.x, zero}, ImGui::GetColorU32(ImGuiCol_TextDisabled, 0.5f));
  draw.PushClipRect(corner, end, true);
  for (const Line& line : lines) draw_line(line, span, since, corner, size);
  const float small = 0.75f * ImGui::GetFontSize();
  const ImU32 faint = ImGui::GetColorU32(ImGuiCol_TextDisabled);
  const auto label = [&](double value, float y) {
    draw.AddText(ImGui::GetFont(), small, {corner.x + 3, y}, faint, fmt::format("{:.3g}", value).c_str());
  };
  label(span.high, corner.y);
  label(span.low, end.y - small - 1);
  draw.PopClipRect();
  ImGui::Dummy(size);
}

double length_of(const std::array<History, 3>& v) {
  return std::hypot(v[0].newest().value, v[1].newest().value, v[2].newest().value);
}

void draw_vector(const std::string& title, const std::array<History, 3>& v, const char* unit, double now) {
  draw_plot(title, fmt::format("{:.3g} {}", length_of(v), unit),
            {{v.data(), kAxisColors[0]}, {&v[1], kAxisColors[1]}, {&v[2], kAxisColors[2]}}, now);
}

bool is_live(const History& history, double now) {
  return !history.empty() && now - history.newest().time < History::kSpan;
}

}  // namespace

void draw_plots(const Plots& plots, double now) {
  std::size_t hands = 0;
  for (const HandPlots& hand : plots.hands) hands += is_live(hand.force[0], now) ? 1 : 0;
  for (std::size_t device = 0; device < plots.hands.size(); ++device) {
    const HandPlots& hand = plots.hands[device];
    if (!is_live(hand.force[0], now)) continue;
    const std::string of = hands > 1 ? fmt::format(" {}", device) : "";
    draw_vector("force" + of + " x y z", hand.force, "N", now);
    draw_vector("torque" + of + " x y z", hand.torque, "N m", now);
  }
  const ImU32 color = ImGui::GetColorU32(ImGuiCol_PlotLines);
  const auto draw = [&](const char* title, const History& history, auto words) {
    if (is_live(history, now)) draw_plot(title, words(history.newest().value), {{&history, color}}, now);
  };
  draw("age of particles", plots.frame_age, format_time);
  draw("age of the hand's data", plots.bridge_age, format_time);
  draw("step", plots.step_time, format_time);
  draw("real-time factor", plots.real_time_factor, [](double value) { return fmt::format("×{:.2f}", value); });
  draw("kinetic energy", plots.kinetic_energy, [](double value) { return fmt::format("{:.3g} J", value); });
}

}  // namespace palp
