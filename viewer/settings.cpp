#include "viewer/settings.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "config/error.h"
#include "config/text_file.h"
#include "config/toml_reader.h"

namespace palp {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;
constexpr double kFarthestView = 1e5;  // [m] of a camera
constexpr std::int64_t kSettleNs = 2'000'000'000;
const char* const kSuiting = "suiting";  // the map that suits the field

template <std::size_t N>
std::vector<std::string> words(const std::array<std::string_view, N>& names) {
  return {names.begin(), names.end()};
}

osg::Vec3d read_vector(const std::vector<double>& x) { return {x.at(0), x.at(1), x.at(2)}; }

void read_ranges(TomlTable table, ViewerSettings& s) {
  for (std::size_t i = 1; i < kScalarFields.size(); ++i) {
    const std::string key(kScalarFields[i].name);
    const auto ends = table.numbers(key, 2, {"", -1e30, 1e30});
    if (!ends) continue;
    if (ends->at(0) < ends->at(1)) {
      s.held[i] = ValueRange{ends->at(0), ends->at(1)};
    } else {
      table.fault(key, fmt::format("the range of {} ends at {}, expected more than {}", key, ends->at(1), ends->at(0)));
    }
  }
}

void read_view(TomlTable table, ViewerSettings& s) {
  const Range places{"m", -kFarthestView, kFarthestView};
  const auto scene = table.text("scene", Need::required);
  const auto number = table.integer("number", 1, kMostViews, Need::required);
  const auto eye = table.numbers("eye", 3, places, Need::required);
  const auto center = table.numbers("center", 3, places, Need::required);
  const auto up = table.numbers("up", 3, {"", -1, 1}, Need::required);
  if (!scene || !number || !eye || !center || !up) return;
  const StoredView view{read_vector(*eye), read_vector(*center), read_vector(*up)};
  const osg::Vec3d along = view.center - view.eye;
  if (!((along ^ view.up).length() > 1e-6 * along.length())) {
    table.fault("up", "the view has no direction; expected an eye apart from the center, and an up across both");
    return;
  }
  s.store_view(*scene, static_cast<int>(*number), view);
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : printable(text)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string numbers(const osg::Vec3d& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }

}  // namespace

std::optional<StoredView> ViewerSettings::view_of(const std::string& scene, int number) const {
  for (const SceneView& v : views)
    if (v.scene == printable(scene) && v.number == number) return v.view;
  return std::nullopt;
}

void ViewerSettings::store_view(const std::string& scene, int number, const StoredView& view) {
  const std::string name = printable(scene);
  std::erase_if(views, [&](const SceneView& v) { return v.scene == name && v.number == number; });
  views.push_back({name, number, view});
}

std::string settings_path() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  // the specification of these folders wants relative ones passed over
  if (config != nullptr && *config == '/') return std::string(config) + "/palp/viewer.toml";
  const char* home = std::getenv("HOME");
  return home != nullptr && *home != '\0' ? std::string(home) + "/.config/palp/viewer.toml" : "";
}

ViewerSettings parse_settings(const std::string& text, const std::string& path) {
  ViewerSettings s;
  TomlFile file = TomlFile::parse(text, path);
  TomlTable root = file.root();
  std::vector<std::string> maps = words(kColorMapNames);
  maps.insert(maps.begin(), kSuiting);
  if (const auto map = root.choice("color_map", maps); map && *map > 0) s.map = static_cast<ColorMapKind>(*map - 1);
  if (const auto theme = root.choice("theme", words(kThemeNames))) s.theme = static_cast<Theme>(*theme);
  if (const auto shown = root.choice("panels", words(kPanelDetailNames))) s.panels = static_cast<PanelDetail>(*shown);
  s.control = root.boolean("control").value_or(s.control);
  s.reading = root.boolean("reading").value_or(s.reading);
  s.plots = root.boolean("plots").value_or(s.plots);
  s.bill = root.boolean("bill").value_or(s.bill);
  s.touch = root.boolean("touch").value_or(s.touch);
  s.text_scale = root.number("text_scale", {"", kSmallestTextScale, kLargestTextScale}).value_or(s.text_scale);
  read_ranges(root.table("range"), s);
  for (const TomlTable& view : root.tables("view")) read_view(view, s);
  file.finish();
  return s;
}

std::string settings_text(const ViewerSettings& s) {
  std::string text = "# What palp-viewer remembers; it writes this file anew.\n";
  text += fmt::format("color_map = \"{}\"\n", s.map ? kColorMapNames[static_cast<std::size_t>(*s.map)] : kSuiting);
  text += fmt::format("theme = \"{}\"\n", kThemeNames[static_cast<std::size_t>(s.theme)]);
  text += fmt::format("panels = \"{}\"\n", kPanelDetailNames[static_cast<std::size_t>(s.panels)]);
  text += fmt::format("control = {}\nreading = {}\nplots = {}\nbill = {}\n", s.control, s.reading, s.plots, s.bill);
  text += fmt::format("touch = {}\ntext_scale = {}\n", s.touch, s.text_scale);
  if (std::ranges::any_of(s.held, [](const auto& range) { return range.has_value(); })) text += "\n[range]\n";
  for (std::size_t i = 1; i < s.held.size(); ++i)
    if (s.held[i]) text += fmt::format("{} = [{}, {}]\n", kScalarFields[i].name, s.held[i]->low, s.held[i]->high);
  for (const SceneView& v : s.views) {
    text += fmt::format("\n[[view]]\nscene = {}\nnumber = {}\neye = {}\ncenter = {}\nup = {}\n", quoted(v.scene),
                        v.number, numbers(v.view.eye), numbers(v.view.center), numbers(v.view.up));
  }
  return text;
}

SettingsFile::SettingsFile(std::string path, bool writes) : path_(std::move(path)), writes_(writes && !path_.empty()) {
  std::error_code ignored;
  if (path_.empty() || !std::filesystem::exists(path_, ignored)) return;
  try {
    kept_ = parse_settings(read_text_file(path_, kMostBytes), path_);
  } catch (const ConfigError& error) {
    const std::size_t more = error.faults().size() - 1;
    spdlog::warn("{}{}; these settings are passed over: mend or remove the file", error.faults()[0],
                 more > 0 ? fmt::format(" (and {} faults more)", more) : "");
    writes_ = false;
  }
  written_ = kept_;
}

void SettingsFile::keep(const ViewerSettings& settings, std::int64_t now_ns, bool at_once) {
  if (settings != kept_) changed_ns_ = now_ns;
  kept_ = settings;
  if (!writes_ || kept_ == written_ || (!at_once && now_ns - changed_ns_ < kSettleNs)) return;
  written_ = kept_;
  const std::filesystem::path path(path_), unfinished(path_ + ".tmp~");
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  std::ofstream out(unfinished);
  out << settings_text(kept_);
  out.close();
  bool whole = static_cast<bool>(out);
  if (whole) {
    std::filesystem::rename(unfinished, path, error);
    whole = !error;
  }
  if (whole) return;
  writes_ = false;
  spdlog::warn("{}: the settings cannot be written; check the folder and the space on the disk", path_);
}

}  // namespace palp
