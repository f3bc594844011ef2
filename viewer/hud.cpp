#include "viewer/hud.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <osg/Depth>

#include "viewer/arrays.h"
#include "viewer/controls.h"
#include "viewer/font.h"
#include "viewer/overlay_camera.h"

namespace palp {
namespace {

constexpr float kHelpOpacity = 0.9f;  // of the panel under the help

HudColors colors_of(Theme theme) {
  if (theme == Theme::light)
    return {{0.95f, 0.96f, 0.97f, 0.80f}, {0.30f, 0.34f, 0.40f, 1}, {0.06f, 0.07f, 0.09f, 1}, {0.62f, 0.30f, 0.00f, 1}};
  return {{0.05f, 0.06f, 0.08f, 0.55f}, {0.62f, 0.68f, 0.75f, 1}, {0.95f, 0.97f, 0.99f, 1}, {1.00f, 0.74f, 0.26f, 1}};
}

// A panel has room for this from the start, so that it does not grow with every force that is felt.
const char* const kUsualValue = "1234.56 s  ·  ×0.99 real time";

osg::ref_ptr<osg::Geometry> shape(GLenum mode, osg::Vec3Array* vertices, osg::Vec4Array* colors) {
  osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
  geometry->setUseVertexBufferObjects(true);
  geometry->setVertexArray(vertices);
  geometry->setColorArray(colors, colors->size() == 1 ? osg::Array::BIND_OVERALL : osg::Array::BIND_PER_VERTEX);
  geometry->addPrimitiveSet(new osg::DrawArrays(mode, 0, static_cast<GLsizei>(vertices->size())));
  return geometry;
}

// A filled rectangle with round corners.
osg::ref_ptr<osg::Geometry> panel(float x, float y, float w, float h, float r, const osg::Vec4f& color) {
  constexpr int kCorner = 6;
  osg::ref_ptr<osg::Vec3Array> outline = new osg::Vec3Array;
  r = std::min({r, w / 2, h / 2});
  for (int corner = 0; corner < 4; ++corner) {
    const float cx = corner == 0 || corner == 3 ? x + w - r : x + r;
    const float cy = corner < 2 ? y + h - r : y + r;
    for (int i = 0; i <= kCorner; ++i) {
      const double angle = M_PI / 2 * (corner + static_cast<double>(i) / kCorner);
      outline->push_back(
          {cx + r * static_cast<float>(std::cos(angle)), cy + r * static_cast<float>(std::sin(angle)), 0});
    }
  }
  return shape(GL_TRIANGLE_FAN, outline, array_of<osg::Vec4Array>({color}));
}

osg::ref_ptr<osg::Geometry> color_bar(float x, float y, float w, float h, ColorMapKind kind) {
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
  osg::ref_ptr<osg::Vec4Array> colors = new osg::Vec4Array;
  const auto map = color_map(kind);
  for (int i = 0; i < kColorMapSize; i += 5) {
    const Rgb8 c = map[static_cast<std::size_t>(i)];
    const float at = x + w * static_cast<float>(i) / (kColorMapSize - 1);
    for (const float edge : {y, y + h}) {
      vertices->push_back({at, edge, 0});
      colors->push_back(osg::Vec4f(c.r, c.g, c.b, 255) / 255.0f);
    }
  }
  return shape(GL_TRIANGLE_STRIP, vertices, colors);
}

}  // namespace

Hud::Hud()
    : camera_(overlay_camera(0)),
      rows_group_(new osg::Group),
      banner_group_(new osg::Group),
      legend_group_(new osg::Group),
      help_group_(new osg::Group),
      font_(find_font()),
      colors_(colors_of(Theme::dark)),
      help_lines_(palp::help_lines()) {
  for (osg::Group* group : {rows_group_.get(), legend_group_.get(), banner_group_.get(), help_group_.get()}) {
    camera_->addChild(group);
  }
  known_ = hud_rows({});
  rows_ = rows_to_show();
}

osg::ref_ptr<osgText::Text> Hud::text(const osg::Vec2f& at, const std::string& words, const osg::Vec4f& color,
                                      osgText::Text::AlignmentType alignment, float scale) {
  osg::ref_ptr<osgText::Text> t = new osgText::Text;
  if (font_) t->setFont(font_);
  const float size = std::round(font_size_ * scale);
  t->setShaderTechnique(osgText::NO_TEXT_SHADER);
  t->setFontResolution(static_cast<unsigned>(size), static_cast<unsigned>(size));
  t->setCharacterSize(size);
  t->setAlignment(alignment);
  // at is on the middle of the line; words stand on a common base line
  const float drop = alignment == osgText::Text::CENTER_CENTER ? 0 : 0.36f * size;
  t->setPosition(osg::Vec3f(std::round(at.x()), std::round(at.y() - drop), 0));
  t->setColor(color);
  t->setText(words, osgText::String::ENCODING_UTF8);
  t->setDataVariance(osg::Object::DYNAMIC);
  return t;
}

void Hud::set_size(int width, int height) {
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  if (w == width_ && h == height_) return;
  width_ = w;
  height_ = h;
  choose_font_size();
  camera_->setProjectionMatrixAsOrtho2D(0, w, 0, h);
  lay_out();
}

// Large words must leave the figures room to fit.
void Hud::choose_font_size() {
  const float usual = std::clamp(std::min(height_ / 46, width_ / 70), 9.0f, 26.0f);
  const float largest = std::max(std::min(height_ / 26, width_ / 32), 9.0f);
  font_size_ = std::round(std::clamp(usual * text_scale_, std::min(7.0f, largest), largest));
}

void Hud::set_text_scale(float scale) {
  if (scale == text_scale_) return;
  text_scale_ = scale;
  choose_font_size();
  lay_out();
}

void Hud::set_theme(Theme theme) {
  if (theme == theme_) return;
  theme_ = theme;
  colors_ = colors_of(theme);
  lay_out();
}

void Hud::set_panels(float top, float right) {
  if (top == taken_top_ && right == taken_right_) return;
  taken_top_ = top;
  taken_right_ = right;
  lay_out();
}

void Hud::lay_out() {
  lay_out_rows();
  lay_out_legend();
  lay_out_banner();
  lay_out_help();
}

float Hud::width_of(const std::string& words, float scale) {
  const osg::BoundingBox box =
      text({0, 0}, words, colors_.value, osgText::Text::LEFT_BASE_LINE, scale)->getBoundingBox();
  return box.valid() ? std::ceil(box.xMax()) : 0;
}

void Hud::lay_out_rows() {
  rows_group_->removeChildren(0, rows_group_->getNumChildren());
  values_.clear();
  rows_width_ = rows_height_ = 0;
  if (detail_ == HudDetail::banner) return;
  const float margin = font_size_, pad = 0.8f * font_size_;
  float labels = 0;
  value_width_ = width_of(kUsualValue);
  for (const HudRow& row : rows_) {
    labels = std::max(labels, width_of(row.label));
    value_width_ = std::max(value_width_, width_of(row.value));
  }
  labels += font_size_;
  rows_width_ = labels + value_width_ + 2 * pad;
  rows_height_ = static_cast<float>(rows_.size()) * line() + 1.2f * pad;
  const float top = free_height() - margin;
  rows_group_->addChild(panel(margin, top - rows_height_, rows_width_, rows_height_, 0.5f * font_size_, colors_.panel));
  float y = top - 0.6f * pad - 0.5f * line();
  for (const HudRow& row : rows_) {
    rows_group_->addChild(text({margin + pad, y}, row.label, colors_.label, osgText::Text::LEFT_BASE_LINE));
    values_.push_back(text({margin + pad + labels, y}, row.value, row.warn ? colors_.amber : colors_.value,
                           osgText::Text::LEFT_BASE_LINE));
    rows_group_->addChild(values_.back());
    y -= line();
  }
}

std::vector<HudRow> Hud::rows_to_show() const {
  std::vector<HudRow> rows;
  if (detail_ == HudDetail::banner) return rows;
  for (const HudRow& row : known_) {
    if (detail_ == HudDetail::full || row.main || row.warn) rows.push_back(row);
  }
  return rows;
}

void Hud::set_detail(HudDetail detail) {
  detail_ = detail;
  rows_ = rows_to_show();
  lay_out();
}

void Hud::show_next_detail() {
  const bool shown = visible();
  const bool was_brief = detail_ == HudDetail::brief;
  set_visible(!shown || was_brief);
  set_detail(shown && was_brief ? HudDetail::full : HudDetail::brief);
}

void Hud::set_data(const HudData& data) {
  known_ = hud_rows(data);
  const std::vector<HudRow> rows = rows_to_show();
  bool wider = !std::ranges::equal(rows, rows_, {}, &HudRow::label, &HudRow::label);
  for (std::size_t i = 0; !wider && i < rows.size() && i < values_.size(); ++i) {
    if (rows[i].value != rows_[i].value) {
      values_[i]->setText(rows[i].value, osgText::String::ENCODING_UTF8);
      const osg::BoundingBox box = values_[i]->getBoundingBox();
      wider = wider || (box.valid() && box.xMax() > values_[i]->getPosition().x() + value_width_);
    }
    if (rows[i].warn != rows_[i].warn) values_[i]->setColor(rows[i].warn ? colors_.amber : colors_.value);
  }
  rows_ = rows;
  if (wider) lay_out();
  if (const std::string banner = hud_banner(data); banner != banner_) {
    banner_ = banner;
    lay_out_banner();
  }
}

void Hud::lay_out_banner() {
  banner_group_->removeChildren(0, banner_group_->getNumChildren());
  if (banner_.empty()) return;
  const float y = std::round(std::max(0.12f * free_height(), legend_top_ + 2 * line()));
  auto words = text({free_width() / 2, y}, banner_, colors_.amber, osgText::Text::CENTER_CENTER, 1.25f);
  words->setMaximumWidth(0.9f * free_width());
  const osg::BoundingBox box = words->getBoundingBox();
  const float pad = 0.9f * font_size_;
  banner_group_->addChild(panel(box.xMin() - pad, box.yMin() - 0.7f * pad, box.xMax() - box.xMin() + 2 * pad,
                                box.yMax() - box.yMin() + 1.4f * pad, pad, colors_.panel));
  banner_group_->addChild(words);
}

void Hud::set_legend(const Legend& legend) {
  if (legend == legend_) return;
  legend_ = legend;
  lay_out_legend();
  lay_out_banner();  // it keeps clear of the legend
}

osg::Vec2f Hud::place_legend(float w, float h) {
  const float margin = font_size_;
  // a narrow picture has no room for it beside the figures
  const bool below = free_width() < rows_width_ + w + 3 * margin;
  legend_top_ = below ? margin + h : 0;
  return {free_width() - margin - w, below ? legend_top_ : free_height() - margin};
}

void Hud::lay_out_legend() {
  legend_group_->removeChildren(0, legend_group_->getNumChildren());
  legend_top_ = 0;
  if (detail_ == HudDetail::banner) return;
  if (legend_.field != ScalarField::none) {
    lay_out_field_legend();
  } else if (!legend_.bodies.empty()) {
    lay_out_body_legend();
  }
}

void Hud::lay_out_body_legend() {
  const float pad = 0.8f * font_size_, dot = 0.85f * font_size_, name_at = pad + 1.6f * dot;
  // below the figures there may not be room for all bodies
  const float room = free_height() - rows_height_ - 3 * font_size_ - 1.2f * pad;
  const std::size_t most = std::max<std::size_t>(2, static_cast<std::size_t>(std::max(0.0f, room / line())));
  auto bodies = legend_.bodies;
  std::string others;
  if (bodies.size() > most) {
    others = fmt::format("and {} more", bodies.size() - (most - 1));
    bodies.resize(most - 1);
  }
  float names = width_of(others);
  for (const auto& [name, c] : bodies) names = std::max(names, width_of(name));
  const float w = std::max(10 * font_size_, name_at + names + pad);
  const float h = static_cast<float>(bodies.size() + (others.empty() ? 0 : 1)) * line() + 1.2f * pad;
  const osg::Vec2f corner = place_legend(w, h);
  const float x = corner.x(), top = corner.y();
  legend_group_->addChild(panel(x, top - h, w, h, 0.5f * font_size_, colors_.panel));
  float y = top - 0.6f * pad - 0.5f * line();
  for (const auto& [name, c] : bodies) {
    legend_group_->addChild(panel(x + pad, y - dot / 2, dot, dot, dot / 2, osg::Vec4f(c[0], c[1], c[2], 1)));
    legend_group_->addChild(text({x + name_at, y}, name, colors_.value, osgText::Text::LEFT_BASE_LINE));
    y -= line();
  }
  if (!others.empty())
    legend_group_->addChild(text({x + name_at, y}, others, colors_.label, osgText::Text::LEFT_BASE_LINE));
}

void Hud::lay_out_field_legend() {
  constexpr float kSmall = 0.92f;
  const float pad = 0.8f * font_size_, bar = 0.75f * font_size_;
  const std::string title = fmt::format("{} [{}]{}{}", legend_name(legend_.field), row_of(legend_.field).unit,
                                        legend_.also.empty() ? "" : ", ", legend_.also);
  const auto number = [](double value) { return fmt::format("{:.6g}", value); };
  const double middle = 0.5 * (legend_.range.low + legend_.range.high);
  // the three numbers stand left, in the middle and right, and must not meet
  const float numbers = 3 * std::max({width_of(number(legend_.range.low), kSmall), width_of(number(middle), kSmall),
                                      width_of(number(legend_.range.high), kSmall)}) +
                        2 * pad;
  const float w = std::max({15 * font_size_, width_of(title) + 2 * pad, numbers + 2 * pad});
  const float h = 2 * line() + bar + 1.5f * pad;
  const osg::Vec2f corner = place_legend(w, h);
  const float x = corner.x(), top = corner.y();
  legend_group_->addChild(panel(x, top - h, w, h, 0.5f * font_size_, colors_.panel));
  legend_group_->addChild(
      text({x + pad, top - 0.6f * pad - 0.5f * line()}, title, colors_.label, osgText::Text::LEFT_BASE_LINE));
  const float bar_y = top - 0.75f * pad - line() - bar, bar_w = w - 2 * pad;
  legend_group_->addChild(color_bar(x + pad, bar_y, bar_w, bar, legend_.map));
  const float y = bar_y - 0.25f * pad - 0.5f * line();
  const auto label = [&](float at, double value, osgText::Text::AlignmentType alignment) {
    legend_group_->addChild(text({at, y}, number(value), colors_.value, alignment, kSmall));
  };
  label(x + pad, legend_.range.low, osgText::Text::LEFT_BASE_LINE);
  label(x + pad + bar_w / 2, middle, osgText::Text::CENTER_BASE_LINE);
  label(x + pad + bar_w, legend_.range.high, osgText::Text::RIGHT_BASE_LINE);
}

void Hud::set_help(bool shown) {
  help_shown_ = shown;
  for (osg::Group* group : {rows_group_.get(), legend_group_.get(), banner_group_.get()})
    group->setNodeMask(shown ? 0u : ~0u);
  lay_out_help();
}

void Hud::set_help_lines(std::vector<std::pair<std::string, std::string>> lines) {
  help_lines_ = std::move(lines);
  lay_out_help();
}

void Hud::lay_out_help() {
  help_group_->removeChildren(0, help_group_->getNumChildren());
  if (!help_shown_) return;
  const std::vector<std::pair<std::string, std::string>>& lines = help_lines_;
  const float pad = 1.4f * font_size_;
  float keys = 0, meanings = 0;
  for (const auto& [key, meaning] : lines) {
    keys = std::max(keys, width_of(key));
    meanings = std::max(meanings, width_of(meaning));
  }
  keys += font_size_;
  const float column = keys + meanings + pad;
  // a small picture gets small words, not fewer; in as many columns as let them be large
  float w = 0, h = 0, scale = 0;
  std::size_t rows = 1;
  for (const std::size_t columns : {1u, 2u, 3u}) {
    const std::size_t n = (lines.size() + columns - 1) / columns;
    const float wide = static_cast<float>(columns) * column + pad, high = static_cast<float>(n) * line() + 2 * pad;
    const float fits = std::min({1.0f, 0.96f * width_ / wide, 0.96f * free_height() / high});
    if (fits <= scale) continue;
    scale = fits;
    rows = n;
    w = fits * wide;
    h = fits * high;
  }
  const float x = (width_ - w) / 2, top = (free_height() + h) / 2;
  osg::Vec4f below = colors_.panel;
  below.a() = kHelpOpacity;
  help_group_->addChild(panel(x, top - h, w, h, scale * font_size_, below));
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::size_t in_column = i / rows, in_row = i % rows;
    const float left = x + scale * (pad + static_cast<float>(in_column) * column);
    const float y = top - scale * (pad + (static_cast<float>(in_row) + 0.5f) * line());
    help_group_->addChild(text({left, y}, lines[i].first, colors_.amber, osgText::Text::LEFT_BASE_LINE, scale));
    help_group_->addChild(
        text({left + scale * keys, y}, lines[i].second, colors_.value, osgText::Text::LEFT_BASE_LINE, scale));
  }
}

}  // namespace palp
