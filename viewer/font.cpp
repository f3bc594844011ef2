#include "viewer/font.h"

#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>
#include <osgDB/FileUtils>

namespace palp {

std::string find_font_file() {
  std::vector<std::string> candidates;
  if (const char* chosen = std::getenv("PALP_FONT")) {
    if (std::string(chosen) == "plain") return {};
    candidates.emplace_back(chosen);
  }
  for (const char* directory : {"/usr/share/fonts/truetype/dejavu/", "/usr/share/fonts/dejavu/",
                                "/usr/share/fonts/TTF/", "/usr/share/fonts/dejavu-sans-fonts/"}) {
    candidates.push_back(std::string(directory) + "DejaVuSans.ttf");
  }
  candidates.push_back(osgDB::findDataFile("fonts/DejaVuSans.ttf"));
  for (const std::string& file : candidates) {
    std::error_code ignored;
    if (!file.empty() && std::filesystem::is_regular_file(file, ignored) && osgText::readRefFontFile(file)) return file;
  }
  static bool warned = false;
  if (!std::exchange(warned, true))
    spdlog::warn("no DejaVuSans.ttf found (package fonts-dejavu-core, or PALP_FONT=FILE): a plain font serves");
  return {};
}

osg::ref_ptr<osgText::Font> find_font() {
  const std::string file = find_font_file();
  return file.empty() ? nullptr : osgText::readRefFontFile(file);
}

}  // namespace palp
