#include "viewer/parameter_panel.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>

namespace palp {
namespace {

const ImVec4 kRefused(0.93f, 0.45f, 0.20f, 1);
constexpr double kWidestSlider = 1000;  // a pixel of a wider one would be too much

void draw_buttons(PanelData& d) {
  const auto button = [&](const char* words, Action action) {
    if (ImGui::Button(words)) d.requests.push_back({action});
  };
  button(d.figures.paused ? "Go on" : "Pause", Action::pause_or_resume);
  ImGui::SameLine();
  ImGui::BeginDisabled(!d.figures.paused);
  button("One step", Action::single_step);
  ImGui::EndDisabled();
  ImGui::SameLine();
  button("Start again", Action::reset);
}

// Returns a name that people read: "oil viscosity [Pa s]".
std::string label_of(const ListedParameter& p) {
  std::string name = p.name;
  for (const char* prefix : {"material.", "numerics.", "stream."})
    if (name.starts_with(prefix)) name.erase(0, std::string_view(prefix).size());
  for (char& c : name)
    if (c == '.' || c == '_') c = ' ';
  return p.unit.empty() ? name : name + " [" + p.unit + "]";
}

// Returns whether its value was changed.
bool draw_value(const ListedParameter& p, std::vector<double>& value, const char* format) {
  double largest = 0;
  for (const double v : value) largest = std::max(largest, std::abs(v));
  const auto speed = static_cast<float>(std::max(0.01 * largest, 1e-4));
  constexpr ImGuiDataType kType = ImGuiDataType_Double;
  // a value that is typed is sent as it is: the server says what is wrong with it
  if (value.size() > 1) {
    return ImGui::DragScalarN("##value", kType, value.data(), static_cast<int>(value.size()), speed, &p.low, &p.high,
                              format);
  }
  return p.high - p.low <= kWidestSlider
             ? ImGui::SliderScalar("##value", kType, value.data(), &p.low, &p.high, format)
             : ImGui::DragScalar("##value", kType, value.data(), speed, &p.low, &p.high, format);
}

void draw_parameter(ListedParameter& p, PanelData& d) {
  ImGui::PushID(p.name.c_str());
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(label_of(p).c_str());
  ImGui::TableNextColumn();
  ImGui::SetNextItemWidth(-1);
  const bool derived = p.value.empty();
  std::vector<double> value = derived ? std::vector<double>{p.low} : p.value;
  if (draw_value(p, value, derived ? "by accuracy level" : "%.5g")) p.value = value;
  if (ImGui::IsItemDeactivatedAfterEdit()) d.asked_values.emplace_back(p.name, parameter_text(p.value));
  if (ImGui::IsItemHovered()) {
    const std::string range =
        fmt::format("{}: {:g} .. {:g}{}{}", p.name, p.low, p.high, p.unit.empty() ? "" : " ", p.unit);
    ImGui::SetTooltip("%s\ndrag, or click with ctrl to type", range.c_str());
  }
  ImGui::PopID();
}

}  // namespace

void draw_parameters(PanelData& data) {
  draw_buttons(data);
  if (!data.refusal.empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, kRefused);
    ImGui::TextWrapped("%s", data.refusal.c_str());
    ImGui::PopStyleColor();
  }
  if (data.parameters.empty()) ImGui::TextDisabled("no parameters have been told");
  if (!ImGui::BeginTable("parameters", 2)) return;
  ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthStretch, 0.48f);
  ImGui::TableSetupColumn("value", ImGuiTableColumnFlags_WidthStretch, 0.52f);
  for (ListedParameter& parameter : data.parameters) draw_parameter(parameter, data);
  ImGui::EndTable();
}

}  // namespace palp
