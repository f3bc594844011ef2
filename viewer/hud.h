// The head-up display: figures, a banner, the legend of the colours and the help.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <osg/Camera>
#include <osg/Geometry>
#include <osg/ref_ptr>
#include <osgText/Text>

#include "viewer/color_map.h"
#include "viewer/hud_text.h"
#include "viewer/settings.h"

namespace palp {

// The meaning of the colours: a field with its range, or (field none) the bodies that are seen, each with its colour.
struct Legend {
  ScalarField field = ScalarField::none;
  ValueRange range;
  ColorMapKind map = ColorMapKind::sequential;
  std::vector<std::pair<std::string, std::array<float, 3>>> bodies;
  std::string also;  // what stands behind the field's name
  bool operator==(const Legend&) const = default;
};

// How many of the figures are shown: those that say how the simulation goes and what the hand feels, with whatever is
// out of order; all of them; or none and no legend either, but the banner and the help all the same.
enum class HudDetail { brief, full, banner };

struct HudColors {
  osg::Vec4f panel, label, value, amber;
};

// All calls from the thread that renders, between frames.
class Hud {
 public:
  Hud();
  osg::Camera* camera() { return camera_; }

  void set_size(int width, int height);  // of the picture [pixels]
  // Keeps clear of panels along the upper edge and the right one [pixels].
  void set_panels(float top, float right);
  void set_text_scale(float scale);
  void set_theme(Theme theme);
  // The width that the figures take, with their margins [pixels].
  float figures_width() const { return rows_width_ + 2 * font_size_; }
  float font_size() const { return font_size_; }  // [pixels]
  void set_data(const HudData& data);
  void set_legend(const Legend& legend);
  // Shows the help in place of everything else.
  void set_help(bool shown);
  // Takes the lines of the help, in place of help_lines() (controls.h).
  void set_help_lines(std::vector<std::pair<std::string, std::string>> lines);
  const std::vector<std::pair<std::string, std::string>>& help_lines() const { return help_lines_; }
  void set_detail(HudDetail detail);
  // Goes from brief figures to all of them, to none, and back.
  void show_next_detail();
  void set_visible(bool visible) { camera_->setNodeMask(visible ? ~0u : 0u); }
  bool visible() const { return camera_->getNodeMask() != 0; }
  bool help_shown() const { return help_shown_; }

 private:
  osg::ref_ptr<osgText::Text> text(const osg::Vec2f& at, const std::string& words, const osg::Vec4f& color,
                                   osgText::Text::AlignmentType alignment, float scale = 1);
  std::vector<HudRow> rows_to_show() const;
  float line() const { return 1.55f * font_size_; }
  float width_of(const std::string& words, float scale = 1);  // [pixels]
  float free_width() const { return width_ - taken_right_; }
  float free_height() const { return height_ - taken_top_; }
  void choose_font_size();
  void lay_out();
  void lay_out_rows();
  void lay_out_banner();
  void lay_out_legend();
  void lay_out_body_legend();
  void lay_out_field_legend();
  // Returns the upper left corner of a legend of that size, beside the figures or below them.
  osg::Vec2f place_legend(float w, float h);
  void lay_out_help();

  osg::ref_ptr<osg::Camera> camera_;
  osg::ref_ptr<osg::Group> rows_group_, banner_group_, legend_group_, help_group_;
  osg::ref_ptr<osgText::Font> font_;
  Theme theme_ = Theme::dark;
  HudColors colors_;
  std::vector<osg::ref_ptr<osgText::Text>> values_;
  std::vector<HudRow> known_;  // all rows
  std::vector<HudRow> rows_;   // those that are shown
  HudDetail detail_ = HudDetail::brief;
  std::string banner_;
  Legend legend_;
  float width_ = 1, height_ = 1, font_size_ = 14;  // [pixels]
  float text_scale_ = 1;
  float taken_top_ = 0, taken_right_ = 0;   // by panels [pixels]
  float rows_width_ = 0, rows_height_ = 0;  // of the panel with the figures
  float value_width_ = 0;                   // of the widest value that it has room for
  float legend_top_ = 0;                    // of a legend below the figures; 0 for one beside them
  bool help_shown_ = false;
  std::vector<std::pair<std::string, std::string>> help_lines_;  // key or button, meaning
};

}  // namespace palp
