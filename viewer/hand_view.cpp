#include "viewer/hand_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <osg/BlendFunc>
#include <osg/CullFace>
#include <osg/Geometry>
#include <osg/LineWidth>

#include "viewer/arrays.h"
#include "viewer/blending.h"
#include "viewer/font.h"
#include "viewer/pose_matrix.h"
#include "viewer/shaders.h"

namespace palp {
namespace {

// Orange first: the colour that one hand alone has always had. All differ for eyes that see less of red and green.
const std::array<osg::Vec4f, kMaxDevices> kColors{
    osg::Vec4f(1.00f, 0.56f, 0.13f, 1), osg::Vec4f(0.35f, 0.70f, 1.00f, 1), osg::Vec4f(0.95f, 0.90f, 0.35f, 1),
    osg::Vec4f(0.85f, 0.45f, 0.75f, 1), osg::Vec4f(0.20f, 0.75f, 0.60f, 1), osg::Vec4f(0.85f, 0.85f, 0.90f, 1),
    osg::Vec4f(0.55f, 0.45f, 0.95f, 1), osg::Vec4f(0.75f, 0.55f, 0.35f, 1)};
const osg::Vec4f kWords(0.96f, 0.97f, 0.99f, 1);

// Over the scene's radius: how far off a hand must be for its wish to show at all, and to show wholly; and what a
// radian counts for.
constexpr double kWishFrom = 0.03, kWishWhole = 0.08, kWishPerRadian = 0.08;
// Between an arrow and its value; so it has the width of a letter on any screen.
constexpr std::string_view kGap = "  ";
constexpr double kLongestValue = 7, kLine = 1.6;  // its length and that of a line, over the height of its letters
constexpr int kWishBin = 13, kValueBin = 14;

osg::ref_ptr<osgText::Text> make_value(osgText::Font* font) {
  osg::ref_ptr<osgText::Text> text = new osgText::Text;
  if (font != nullptr) text->setFont(font);
  text->setShaderTechnique(osgText::NO_TEXT_SHADER);
  text->setCharacterSizeMode(osgText::Text::SCREEN_COORDS);
  text->setAxisAlignment(osgText::Text::SCREEN);
  text->setAlignment(osgText::Text::LEFT_CENTER);
  text->setColor(kWords);
  text->setDataVariance(osg::Object::DYNAMIC);
  text->setCullingActive(false);
  return text;
}

osg::ref_ptr<osg::Geometry> unit_line(const osg::Vec4f& color) {
  osg::ref_ptr<osg::Geometry> line = new osg::Geometry;
  line->setUseVertexBufferObjects(true);
  line->setVertexArray(array_of<osg::Vec3Array>({{0, 0, 0}, {0, 0, 1}}));
  line->setColorArray(array_of<osg::Vec4Array>({color}), osg::Array::BIND_OVERALL);
  line->addPrimitiveSet(new osg::DrawArrays(GL_LINES, 0, 2));
  line->setCullingActive(false);
  osg::StateSet* state = line->getOrCreateStateSet();
  state->setAttributeAndModes(new osg::LineWidth(2));
  state->setMode(GL_DEPTH_TEST, osg::StateAttribute::OFF);
  state->setRenderBinDetails(kWishBin, "RenderBin");
  return line;
}

osg::Vec3d vector_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

void write(osgText::Text& text, const std::string& words) {
  if (text.getText().createUTF8EncodedString() != words) text.setText(words, osgText::String::ENCODING_UTF8);
}

}  // namespace

HandView::HandView(std::uint32_t device)
    : root_(new osg::Group),
      force_(kColors[device % kMaxDevices]),
      torque_(kColors[device % kMaxDevices]),
      values_(new osg::Group),
      reach_box_(kColors[device % kMaxDevices]),
      wish_(new osg::Group),
      wished_tool_(new osg::MatrixTransform),
      line_(new osg::MatrixTransform) {
  const osg::ref_ptr<osgText::Font> font = find_font();
  force_value_ = make_value(font);
  torque_value_ = make_value(font);
  // a text's own state is its font's, and made anew with every size
  osg::StateSet* over_all = values_->getOrCreateStateSet();
  over_all->setMode(GL_DEPTH_TEST, osg::StateAttribute::OFF | osg::StateAttribute::OVERRIDE);
  over_all->setAttributeAndModes(new osg::BlendFunc(osg::BlendFunc::SRC_ALPHA, osg::BlendFunc::ONE_MINUS_SRC_ALPHA));
  over_all->setRenderBinDetails(kValueBin, "RenderBin", osg::StateSet::OVERRIDE_RENDERBIN_DETAILS);
  values_->addChild(force_value_);
  values_->addChild(torque_value_);

  const osg::Vec4f color = kColors[device % kMaxDevices];
  osg::StateSet* state = wished_tool_->getOrCreateStateSet();
  state->setAttributeAndModes(load_program("wish", {"mesh.vert", "mesh.frag", "color.glsl", "lighting.glsl"}));
  state->setAttributeAndModes(new osg::CullFace(osg::CullFace::BACK));
  blend_over(state);
  state->addUniform(new osg::Uniform("glass", 0.30f));
  state->addUniform(new osg::Uniform("tint", osg::Vec4f(color.x(), color.y(), color.z(), 0.6f)));
  state->addUniform(new osg::Uniform("presence", 1.0f));
  state->setRenderBinDetails(kWishBin, "RenderBin");
  line_->addChild(unit_line(color));
  wish_->addChild(wished_tool_);
  wish_->addChild(line_);

  root_->addChild(force_.node());
  root_->addChild(torque_.node());
  root_->addChild(wish_);
  root_->addChild(reach_box_.node());
  root_->addChild(values_);
  hide();
}

void HandView::clear() {
  wished_tool_->removeChildren(0, wished_tool_->getNumChildren());
  tool_.reset();
  from_handle_.reset();
  hide();
}

void HandView::add_tool_part(const osg::Geometry& part) {
  osg::ref_ptr<osg::Geometry> copy = new osg::Geometry(part, osg::CopyOp::SHALLOW_COPY);
  copy->setStateSet(nullptr);
  wished_tool_->addChild(copy);
}

void HandView::set_value_size(float pixels) {
  if (force_value_->getCharacterHeight() == pixels) return;
  for (osgText::Text* text : {force_value_.get(), torque_value_.get()}) {
    text->setFontResolution(static_cast<unsigned>(pixels), static_cast<unsigned>(pixels));
    text->setCharacterSize(pixels);
  }
}

void HandView::set_tool_pose(const osg::Matrixd& pose, double sim_time) {
  tool_ = pose;
  tool_time_ = sim_time;
}

void HandView::hide() {
  force_.hide();
  torque_.hide();
  wish_->setNodeMask(0);
  force_words_.clear();
  torque_words_.clear();
  device_.reset();
  reach_box_.set(std::nullopt, {});
}

void HandView::set_reach(const std::optional<HandReach>& reach) {
  reach_ = reach;
  if (device_) reach_box_.set(reach_, *device_);
}

void HandView::set_values(const WrenchD& wrench) {
  force_words_ = fmt::format("{:.2f} N", vector_of(wrench.force).length());
  torque_words_ = fmt::format("{:.3f} N m", vector_of(wrench.torque).length());
}

std::string HandView::values() const { return force_words_.empty() ? "" : force_words_ + "  ·  " + torque_words_; }

// A force that points at the eye ends where its handle is seen, and with it the torque: then its value stands below
// that of the force.
void HandView::arrange_values(const osg::Matrixd& to_pixels) {
  const bool force = force_.visible() && !force_words_.empty(), torque = torque_.visible() && !torque_words_.empty();
  const osg::Matrixd to_world = osg::Matrixd::inverse(to_pixels);
  const double letter = force_value_->getCharacterHeight();
  // the circle around all ways in which the arrow of the torque can turn
  const osg::Vec3d middle = handle_ * to_pixels;
  const double reach = torque_radius_ / ((middle + osg::Vec3d(1, 0, 0)) * to_world - handle_).length();
  osg::Vec3d beside = middle + osg::Vec3d(reach, 0.7 * reach, 0), end = force_end_ * to_pixels;
  if (torque && std::abs(end.y() - middle.y()) < reach + letter) end.x() = std::max(end.x(), beside.x());
  const osg::Vec3d gap = beside - end;
  if (force && std::abs(gap.y()) < 2 * letter && std::abs(gap.x()) < kLongestValue * letter)
    beside = end - osg::Vec3d(0, kLine * letter, 0);
  // letters are sharp where they begin at a pixel
  const auto snapped = [](const osg::Vec3d& at) { return osg::Vec3d(std::round(at.x()), std::round(at.y()), at.z()); };
  force_value_->setPosition(snapped(end) * to_world);
  torque_value_->setPosition(snapped(beside) * to_world);
  force_value_->setNodeMask(force ? ~0u : 0u);
  torque_value_->setNodeMask(torque ? ~0u : 0u);
  if (force) write(*force_value_, fmt::format("{}{}", kGap, force_words_));
  if (torque) write(*torque_value_, fmt::format("{}{}", kGap, torque_words_));
}

void HandView::set(const ProxySample& sample, const HandScale& scale) {
  handle_ = vector_of(sample.proxy_pose.position);
  const osg::Vec3d force = vector_of(sample.wrench.force), torque = vector_of(sample.wrench.torque);
  const double newtons = force.length(), length = scale.arrow_length * newtons / scale.full_force;
  force_.set(handle_, force, length, 0.016 * scale.scene_radius);
  force_end_ = handle_ + force * (newtons > 0 ? length / newtons : 0);

  const double share = torque.length() / scale.full_torque;
  torque_radius_ = 0.12 * scale.scene_radius;
  torque_.set(handle_, torque, share, torque_radius_);
  set_wish(sample, scale);
  device_ = vector_of(sample.device_pose.position);
  reach_box_.set(reach_, *device_);
}

void HandView::set_wish(const ProxySample& sample, const HandScale& scale) {
  wish_->setNodeMask(0);
  osg::Matrixd handle, wished;
  if ((sample.flags & kEngaged) == 0 || !pose_matrix(sample.proxy_pose, handle) ||
      !pose_matrix(sample.device_pose, wished))
    return;
  if (const double error = std::abs(sample.sim_time - tool_time_);
      tool_ && (!from_handle_ || error <= from_handle_error_)) {
    from_handle_ = *tool_ * osg::Matrixd::inverse(handle);
    from_handle_error_ = error;
  }
  const osg::Vec3d gap = wished.getTrans() - handle.getTrans();
  const osg::Quat turn = (osg::Matrixd::inverse(handle) * wished).getRotate();
  const double angle = 2 * std::acos(std::clamp(std::abs(turn.w()), 0.0, 1.0));
  const double off = gap.length() / scale.scene_radius + kWishPerRadian * angle;
  const double presence = std::clamp((off - kWishFrom) / (kWishWhole - kWishFrom), 0.0, 1.0);
  if (!(presence > 0)) return;
  wish_->setNodeMask(~0u);
  wished_tool_->setNodeMask(from_handle_ ? ~0u : 0u);
  if (from_handle_) wished_tool_->setMatrix(*from_handle_ * wished);
  wished_tool_->getStateSet()->getUniform("presence")->set(static_cast<float>(presence));
  line_->setNodeMask(gap.length2() > 0 ? ~0u : 0u);
  line_->setMatrix(osg::Matrixd::scale(1, 1, gap.length()) * osg::Matrixd::rotate(osg::Vec3d(0, 0, 1), gap) *
                   osg::Matrixd::translate(handle.getTrans()));
}

}  // namespace palp
