// Settings: what the viewer remembers of how its user likes it, in a TOML file of the user's.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <osg/Vec3d>

#include "viewer/reading.h"

namespace palp {

enum class Theme { dark, light };
inline constexpr std::array<std::string_view, 2> kThemeNames{"dark", "light"};

// How much of the panels is shown: nothing, the menu, or the menu and all panels.
enum class PanelDetail { none, menu, all };
inline constexpr std::array<std::string_view, 3> kPanelDetailNames{"none", "menu", "all"};

inline constexpr double kSmallestTextScale = 0.5, kLargestTextScale = 3;
inline constexpr int kMostViews = 9;  // stored for each scene

// A camera: where it stands, the point that it looks at [m], and which way is up.
struct StoredView {
  osg::Vec3d eye{0, -1, 0}, center, up{0, 0, 1};
  bool operator==(const StoredView&) const = default;
};

struct SceneView {
  std::string scene;  // its name
  int number = 1;     // 1 .. kMostViews
  StoredView view;
  bool operator==(const SceneView&) const = default;
};

struct ViewerSettings {
  std::optional<ColorMapKind> map;                                   // none: the one that suits the field
  std::array<std::optional<ValueRange>, kScalarFields.size()> held;  // ranges of colours that stay, by field
  Theme theme = Theme::dark;
  PanelDetail panels = PanelDetail::menu;
  bool control = true, reading = true, plots = true, bill = false;  // which panels are open
  bool touch = false;                                               // marks where media touch tools
  double text_scale = 1;                                            // kSmallestTextScale .. kLargestTextScale
  std::vector<SceneView> views;
  bool operator==(const ViewerSettings&) const = default;

  // Returns the view of that number, or nothing.
  std::optional<StoredView> view_of(const std::string& scene, int number) const;
  void store_view(const std::string& scene, int number, const StoredView& view);
};

// Returns palp/viewer.toml in the user's folder of configuration ($XDG_CONFIG_HOME, else ~/.config); empty where there
// is neither.
std::string settings_path();
// Reads settings. Throws ConfigError with every fault as file:line.
ViewerSettings parse_settings(const std::string& text, const std::string& path);
// Returns the text that parse_settings() reads back as the same.
std::string settings_text(const ViewerSettings& settings);

// A file of settings, or none. A file that is not there gives defaults. One that is broken is told of in one sentence
// and left as it is: it gives defaults and is not written.
class SettingsFile {
 public:
  // path: empty for none. writes: whether changes are kept in it.
  SettingsFile(std::string path, bool writes);
  const ViewerSettings& settings() const { return kept_; }
  // Takes over the settings and writes them, if they have changed and stayed the same for two seconds, or at once. What
  // cannot be written is told of once. now_ns: CLOCK_MONOTONIC.
  void keep(const ViewerSettings& settings, std::int64_t now_ns, bool at_once = false);

 private:
  std::string path_;
  bool writes_;
  ViewerSettings kept_, written_;
  std::int64_t changed_ns_ = 0;
};

}  // namespace palp
