#include "viewer/replay_overlay.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "viewer/arrays.h"
#include "viewer/font.h"
#include "viewer/overlay_camera.h"

namespace palp {
namespace {

const osg::Vec4f kPanel(0.05f, 0.06f, 0.08f, 0.62f);
const osg::Vec4f kTrack(0.95f, 0.97f, 0.99f, 0.28f), kDone(1.0f, 0.74f, 0.26f, 0.95f),
    kWordColor(0.95f, 0.97f, 0.99f, 1);

osg::ref_ptr<osg::Geometry> rectangle(const osg::Vec4f& color) {
  osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
  geometry->setUseVertexBufferObjects(true);
  geometry->setVertexArray(array_of<osg::Vec3Array>({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}));
  geometry->setColorArray(array_of<osg::Vec4Array>({color}), osg::Array::BIND_OVERALL);
  geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_STRIP, 0, 4));
  return geometry;
}

void place(osg::Geometry& geometry, float x, float y, float w, float h) {
  geometry.setVertexArray(array_of<osg::Vec3Array>({{x, y, 0}, {x + w, y, 0}, {x, y + h, 0}, {x + w, y + h, 0}}));
}

osg::ref_ptr<osgText::Text> make_text() {
  osg::ref_ptr<osgText::Text> text = new osgText::Text;
  if (const osg::ref_ptr<osgText::Font> font = find_font()) text->setFont(font);
  text->setShaderTechnique(osgText::NO_TEXT_SHADER);
  text->setColor(kWordColor);
  text->setDataVariance(osg::Object::DYNAMIC);
  return text;
}

void set_size_of(osgText::Text& text, float size) {
  text.setFontResolution(static_cast<unsigned>(size), static_cast<unsigned>(size));
  text.setCharacterSize(size);
}

}  // namespace

ReplayOverlay::ReplayOverlay()
    : camera_(overlay_camera(1)),
      timeline_(new osg::Group),
      track_(rectangle(kTrack)),
      done_(rectangle(kDone)),
      knob_(rectangle(kWordColor)),
      behind_caption_(rectangle(kPanel)),
      text_(make_text()),
      caption_(make_text()) {
  for (osg::Node* node : {static_cast<osg::Node*>(track_.get()), static_cast<osg::Node*>(done_.get()),
                          static_cast<osg::Node*>(knob_.get()), static_cast<osg::Node*>(text_.get())})
    timeline_->addChild(node);
  camera_->addChild(timeline_);
  camera_->addChild(behind_caption_);
  camera_->addChild(caption_);
  text_->setAlignment(osgText::Text::RIGHT_CENTER);
  caption_->setAlignment(osgText::Text::CENTER_BASE_LINE);
  set_caption({}, 0);
  set_timeline_shown(false);
}

ReplayOverlay::Bar ReplayOverlay::bar() const {
  const float margin = 0.02f * free_, thick = std::clamp(height_ / 90, 3.0f, 10.0f);
  return {margin, std::round(2.5f * thick), 0.72f * free_ - margin, thick};
}

void ReplayOverlay::set_size(int width, int height, double taken_right) {
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  const float free = std::max(w - static_cast<float>(taken_right), 0.3f * w);
  if (w == width_ && h == height_ && free == free_) return;
  width_ = w;
  height_ = h;
  free_ = free;
  camera_->setProjectionMatrixAsOrtho2D(0, w, 0, h);
  set_size_of(*text_, std::round(std::clamp(std::min(h / 42, free_ / 66), 9.0f, 26.0f)));
  const float words = std::round(std::clamp(std::min(h / 18, w / 30), 12.0f, 160.0f));
  set_size_of(*caption_, words);
  caption_->setMaximumWidth(0.9f * w);
  caption_->setPosition(osg::Vec3f(std::round(w / 2), std::round(1.6f * words), 0));
  lay_out();
}

void ReplayOverlay::lay_out() {
  const Bar b = bar();
  const float done = static_cast<float>(share_) * b.width;
  place(*track_, b.x, b.y, b.width, b.height);
  place(*done_, b.x, b.y, done, b.height);
  place(*knob_, b.x + done - 0.5f * b.height, b.y - b.height, b.height, 3 * b.height);
  text_->setPosition(osg::Vec3f(std::round(0.98f * free_), std::round(b.y + 0.5f * b.height), 0));
}

void ReplayOverlay::set_caption(const std::string& text, double opacity) {
  const bool shown = !text.empty() && opacity > 0;
  for (osg::Node* node : {static_cast<osg::Node*>(caption_.get()), static_cast<osg::Node*>(behind_caption_.get())})
    node->setNodeMask(shown ? ~0u : 0u);
  if (!shown) return;
  const auto alpha = static_cast<float>(std::min(opacity, 1.0));
  caption_->setText(text, osgText::String::ENCODING_UTF8);
  caption_->setColor(osg::Vec4f(kWordColor.r(), kWordColor.g(), kWordColor.b(), alpha));
  const osg::BoundingBox words = caption_->getBoundingBox();
  const float pad = 0.45f * caption_->getCharacterHeight();
  place(*behind_caption_, words.xMin() - 1.5f * pad, words.yMin() - pad, words.xMax() - words.xMin() + 3 * pad,
        words.yMax() - words.yMin() + 2 * pad);
  behind_caption_->setColorArray(
      array_of<osg::Vec4Array>({osg::Vec4f(kPanel.r(), kPanel.g(), kPanel.b(), alpha * kPanel.a())}),
      osg::Array::BIND_OVERALL);
}

void ReplayOverlay::set_timeline(double first, double last, double time, double speed, bool paused) {
  share_ = last > first ? std::clamp((time - first) / (last - first), 0.0, 1.0) : 1;
  words_ = fmt::format("{:.2f} of {:.2f} s  ·  ×{:g}{}", time, last, std::round(100 * speed) / 100,
                       paused ? "  ·  paused" : "");
  text_->setText(words_, osgText::String::ENCODING_UTF8);
  lay_out();
}

bool ReplayOverlay::on_timeline(float x, float y) const {
  const Bar b = bar();
  return timeline_shown() && x >= b.x - b.height && x <= b.x + b.width + b.height && y >= b.y - 2 * b.height &&
         y <= b.y + 3 * b.height;
}

double ReplayOverlay::share_at(float x) const {
  const Bar b = bar();
  return std::clamp(static_cast<double>((x - b.x) / b.width), 0.0, 1.0);
}

}  // namespace palp
