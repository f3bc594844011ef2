#include "viewer/panel_windows.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <imgui.h>

#include "viewer/parameter_panel.h"
#include "viewer/plot_panel.h"

namespace palp {
namespace {

constexpr std::array<const char*, 5> kMenuNames{"View", "Camera", "Colours", "Simulation", "Help"};

bool is_on(Action action, const PanelData& d) {
  switch (action) {
    case Action::figures:
      return d.figures_shown;
    case Action::panels:
      return d.settings.panels == PanelDetail::all;
    case Action::beads:
      return d.beads;
    case Action::touch:
      return d.settings.touch;
    case Action::follow:
      return d.following;
    case Action::hold_range:
      return d.reading.held_of(d.shown_field).has_value();
    case Action::clip:
      return d.reading.clip.on;
    default:
      return false;
  }
}

void draw_numbered(PanelData& d, const ActionRow& row) {
  if (!ImGui::BeginMenu(row.meaning)) return;
  for (int number = 1; number <= kMostViews; ++number) {
    const bool stored = d.settings.view_of(d.scene, number).has_value();
    const std::string key = fmt::format("{}{}", row.action == Action::store_view ? "shift " : "", number);
    const std::string words = fmt::format("{}{}", number, stored ? "" : " (empty)");
    const bool possible = !d.scene.empty() && (stored || row.action == Action::store_view);
    if (ImGui::MenuItem(words.c_str(), key.c_str(), false, possible)) d.requests.push_back({row.action, number});
  }
  ImGui::EndMenu();
}

// The choices that have no keys of their own.
void draw_choices(PanelData& d, Menu menu) {
  if (menu == Menu::view) {
    ImGui::Separator();
    if (ImGui::MenuItem("light theme", nullptr, d.settings.theme == Theme::light))
      d.settings.theme = d.settings.theme == Theme::light ? Theme::dark : Theme::light;
    const auto size = [&](const char* words, double factor) {
      if (ImGui::MenuItem(words))
        d.settings.text_scale = std::clamp(d.settings.text_scale * factor, kSmallestTextScale, kLargestTextScale);
    };
    size("larger words", 1.15);
    size("smaller words", 1 / 1.15);
  }
  if (menu == Menu::simulation && ImGui::BeginMenu("another scene", !d.scenes.empty())) {
    for (const std::string& name : d.scenes)
      if (ImGui::MenuItem(name.c_str(), nullptr, name == d.scene)) d.asked_scene = name;
    ImGui::EndMenu();
  }
}

template <std::size_t N>
int choose(const char* label, const std::array<std::string, N>& names, std::size_t chosen) {
  int next = -1;
  if (!ImGui::BeginCombo(label, names[chosen].c_str())) return next;
  for (std::size_t i = 0; i < N; ++i)
    if (ImGui::Selectable(names[i].c_str(), i == chosen)) next = static_cast<int>(i);
  ImGui::EndCombo();
  return next;
}

void draw_colors(PanelData& d) {
  std::array<std::string, kScalarFields.size()> fields;
  for (std::size_t i = 0; i < fields.size(); ++i) fields[i] = legend_name(static_cast<ScalarField>(i));
  if (const int next = choose("colours", fields, static_cast<std::size_t>(d.field)); next >= 0)
    d.asked_field = static_cast<ScalarField>(next);
  std::array<std::string, kColorMapNames.size() + 1> maps{"what suits"};
  std::copy(kColorMapNames.begin(), kColorMapNames.end(), maps.begin() + 1);
  const std::size_t map = d.reading.map ? static_cast<std::size_t>(*d.reading.map) + 1 : 0;
  if (const int next = choose("map", maps, map); next >= 0)
    d.reading.map = next > 0 ? std::optional(static_cast<ColorMapKind>(next - 1)) : std::nullopt;
}

void draw_range(PanelData& d) {
  if (d.shown_field == ScalarField::none) {
    ImGui::TextDisabled("the range is that of a field");
    return;
  }
  std::optional<ValueRange>& held = d.reading.held_of(d.shown_field);
  bool holds = held.has_value();
  if (ImGui::Checkbox("hold the range", &holds)) held = holds ? std::optional(d.range) : std::nullopt;
  ImGui::SameLine();
  ImGui::TextDisabled("[%s]", std::string(row_of(d.shown_field).unit).c_str());
  ValueRange& edited = d.edited_range;
  if (!ImGui::IsAnyItemActive()) edited = held.value_or(d.range);
  ImGui::BeginDisabled(!holds);
  double ends[2] = {edited.low, edited.high};
  ImGui::InputScalarN("from, to", ImGuiDataType_Double, ends, 2, nullptr, nullptr, "%.6g");
  edited = {ends[0], ends[1]};
  if (holds && ImGui::IsItemDeactivatedAfterEdit() && edited.low < edited.high) held = edited;
  ImGui::EndDisabled();
}

void draw_clip(PanelData& d) {
  ClipPlane& clip = d.reading.clip;
  ImGui::Checkbox("cut open", &clip.on);
  for (int axis = 0; axis < 3; ++axis) {
    ImGui::SameLine();
    ImGui::RadioButton(axis == 0 ? "x" : axis == 1 ? "y" : "z", &clip.axis, axis);
  }
  ImGui::SameLine();
  ImGui::Checkbox("flip", &clip.flipped);
  if (!d.content.valid()) return;
  auto at = static_cast<float>(position_of(clip, d.content));
  const auto low = static_cast<float>(d.content._min[clip.axis]), high = static_cast<float>(d.content._max[clip.axis]);
  if (ImGui::SliderFloat("at", &at, low, high, "%.4f m")) clip.share = share_at(at, clip.axis, d.content);
}

void draw_picked(PanelData& d) {
  ImGui::TextUnformatted(d.picked->title.c_str());
  const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize("x").x;
  ImGui::SameLine(room);
  if (ImGui::SmallButton("x")) d.requests.push_back({Action::let_go});
  if (ImGui::BeginTable("picked", 2, ImGuiTableFlags_SizingFixedFit)) {
    ImGui::TableSetupColumn("what", ImGuiTableColumnFlags_WidthFixed);
    ImGui::TableSetupColumn("how much", ImGuiTableColumnFlags_WidthStretch);
    for (const auto& [what, how_much] : d.picked->lines) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextDisabled("%s", what.c_str());
      ImGui::TableNextColumn();
      ImGui::TextWrapped("%s", how_much.c_str());
    }
    ImGui::EndTable();
  }
  ImGui::Separator();
}

// Returns a line with a dot in place of each run of blanks, by which the bill sets its columns.
std::string with_dots(std::string_view line) {
  std::string out;
  while (!line.empty()) {
    const std::size_t gap = line.find("  ");
    out += line.substr(0, gap);
    line.remove_prefix(std::min(line.find_first_not_of(' ', std::min(gap, line.size())), line.size()));
    if (!line.empty()) out += " · ";
  }
  return out;
}

// Lines that are indented tell of the one before them; long ones go on below.
void draw_bill(const std::string& bill) {
  std::istringstream lines(bill);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find_first_not_of(' ');
    if (first == std::string::npos) {
      ImGui::Spacing();
      continue;
    }
    const std::string words = with_dots(std::string_view(line).substr(first));
    const float indent = first > 0 ? ImGui::GetFontSize() : 0;
    if (indent > 0) ImGui::Indent(indent);
    ImGui::PushTextWrapPos(0);
    ImGui::TextUnformatted(words.c_str());
    ImGui::PopTextWrapPos();
    if (indent > 0) ImGui::Unindent(indent);
  }
}

// A panel under a bar that opens and closes it; returns whether it is open.
bool section(const char* name, bool& open) {
  ImGui::SetNextItemOpen(open);
  open = ImGui::CollapsingHeader(name);
  return open;
}

}  // namespace

float draw_menu(PanelData& data) {
  if (!ImGui::BeginMainMenuBar()) return 0;
  const float height = ImGui::GetWindowSize().y;
  for (std::size_t i = 0; i < kMenuNames.size(); ++i) {
    if (!ImGui::BeginMenu(kMenuNames[i])) continue;
    for (const ActionRow& row : action_rows()) {
      if (row.menu != static_cast<Menu>(i)) continue;
      if (takes_number(row.action)) {
        draw_numbered(data, row);
      } else if (ImGui::MenuItem(row.meaning, row.key_name, is_on(row.action, data))) {
        data.requests.push_back({row.action});
      }
    }
    draw_choices(data, static_cast<Menu>(i));
    ImGui::EndMenu();
  }
  ImGui::EndMainMenuBar();
  return height;
}

void draw_column(PanelData& data, float top, float width, bool all) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({display.x - width, top});
  const float most = std::max(display.y - top, 1.0f);
  if (all) {
    ImGui::SetNextWindowSize({width, most});
  } else {
    ImGui::SetNextWindowSizeConstraints({width, 0}, {width, most});
  }
  constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                      ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                      ImGuiWindowFlags_NoSavedSettings;
  ImGui::Begin(all ? "panels" : "picked", nullptr, all ? kPlain : kPlain | ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::PushItemWidth(-5.5f * ImGui::GetFontSize());  // leaves room for labels
  if (data.picked) draw_picked(data);
  if (all) {
    if (section("Simulation", data.settings.control)) draw_parameters(data);
    if (section("Reading", data.settings.reading)) {
      draw_colors(data);
      draw_range(data);
      draw_clip(data);
    }
    if (section("Plots", data.settings.plots) && data.plots != nullptr) draw_plots(*data.plots, data.now);
    if (section("Bill", data.settings.bill)) draw_bill(data.bill ? *data.bill : "the server has told none yet");
  }
  ImGui::PopItemWidth();
  ImGui::End();
}

}  // namespace palp
