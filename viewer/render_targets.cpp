#include "viewer/render_targets.h"

#include <array>

#include "viewer/arrays.h"
#include "viewer/gpu_pacing.h"

namespace palp {
namespace {

void set_plain_sampling(osg::Texture2D& texture, osg::Texture::FilterMode filter) {
  texture.setFilter(osg::Texture::MIN_FILTER, filter);
  texture.setFilter(osg::Texture::MAG_FILTER, filter);
  texture.setWrap(osg::Texture::WRAP_S, osg::Texture::CLAMP_TO_EDGE);
  texture.setWrap(osg::Texture::WRAP_T, osg::Texture::CLAMP_TO_EDGE);
  texture.setResizeNonPowerOfTwoHint(false);
  texture.setTextureSize(1, 1);
}

constexpr int kMostStrips = 32;
constexpr int kMostOfCopy = 4;  // each costs a GPU more than the texels in it

// Confines drawing to the k-th of n strips of what it is confined to already, for as long as this lives.
class Strip {
 public:
  Strip(int k, int n) : confined_(glIsEnabled(GL_SCISSOR_TEST) == GL_TRUE) {
    glGetIntegerv(confined_ ? GL_SCISSOR_BOX : GL_VIEWPORT, box_.data());
    const int from = box_[3] * k / n, to = box_[3] * (k + 1) / n;
    glEnable(GL_SCISSOR_TEST);
    glScissor(box_[0], box_[1] + from, box_[2], to - from);
  }
  ~Strip() {
    glScissor(box_[0], box_[1], box_[2], box_[3]);
    if (!confined_) glDisable(GL_SCISSOR_TEST);
  }
  Strip(const Strip&) = delete;
  Strip& operator=(const Strip&) = delete;

 private:
  bool confined_;
  std::array<GLint, 4> box_{};
};

class Strips : public osg::Geometry {
 public:
  void drawImplementation(osg::RenderInfo& info) const override {
    in_pieces(info, kMostStrips, [&](int k, int n) {
      const Strip strip(k, n);
      osg::Geometry::drawImplementation(info);
    });
  }
};

}  // namespace

osg::ref_ptr<osg::Texture2D> float_texture(GLenum internal_format, GLenum format) {
  osg::ref_ptr<osg::Texture2D> texture = new osg::Texture2D;
  texture->setInternalFormat(static_cast<GLint>(internal_format));
  texture->setSourceFormat(format);
  texture->setSourceType(GL_FLOAT);
  set_plain_sampling(*texture, osg::Texture::NEAREST);
  return texture;
}

osg::ref_ptr<osg::Camera> pass_into(osg::Texture2D* texture, int order, bool with_depth) {
  osg::ref_ptr<osg::Camera> pass = new osg::Camera;
  pass->setReferenceFrame(osg::Transform::RELATIVE_RF);
  pass->setRenderOrder(osg::Camera::PRE_RENDER, order);
  pass->setRenderTargetImplementation(osg::Camera::FRAME_BUFFER_OBJECT);
  pass->setImplicitBufferAttachmentMask(0, 0);
  pass->attach(osg::Camera::COLOR_BUFFER0, texture);
  if (with_depth) pass->attach(osg::Camera::DEPTH_BUFFER, GL_DEPTH_COMPONENT24);
  pass->setClearMask(GL_COLOR_BUFFER_BIT | (with_depth ? GL_DEPTH_BUFFER_BIT : 0u));
  pass->setClearColor(osg::Vec4f(0, 0, 0, 0));
  pass->setViewport(0, 0, 1, 1);
  pass->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
  pass->setCullingActive(false);
  pass->setAllowEventFocus(false);
  osg::StateSet* state = pass->getOrCreateStateSet();
  state->setMode(GL_DEPTH_TEST, with_depth ? osg::StateAttribute::ON : osg::StateAttribute::OFF);
  return pass;
}

void resize_pass(osg::Camera& pass, osg::Texture2D& texture, int width, int height) {
  texture.setTextureSize(width, height);
  texture.dirtyTextureObject();
  pass.setViewport(0, 0, width, height);
  pass.dirtyAttachmentMap();
}

osg::ref_ptr<osg::Geometry> geometry_in_strips() { return new Strips; }

osg::ref_ptr<osg::Geometry> screen_rectangle() {
  osg::ref_ptr<osg::Geometry> geometry = geometry_in_strips();
  geometry->setUseVertexBufferObjects(true);
  geometry->setVertexArray(array_of<osg::Vec3Array>({{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {1, 1, 0}}));
  geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_STRIP, 0, 4));
  geometry->setCullingActive(false);
  return geometry;
}

PictureCopy::PictureCopy() : color_(new osg::Texture2D), depth_(new osg::Texture2D) {
  color_->setInternalFormat(GL_RGB8);
  color_->setSourceFormat(GL_RGB);
  color_->setSourceType(GL_UNSIGNED_BYTE);
  set_plain_sampling(*color_, osg::Texture::LINEAR);
  depth_->setInternalFormat(GL_DEPTH_COMPONENT24);
  depth_->setSourceFormat(GL_DEPTH_COMPONENT);
  depth_->setSourceType(GL_UNSIGNED_INT);
  set_plain_sampling(*depth_, osg::Texture::NEAREST);
  setUseDisplayList(false);
  setSupportsDisplayList(false);
  setCullingActive(false);
}

void PictureCopy::set_size(int width, int height) {
  if (width == color_->getTextureWidth() && height == color_->getTextureHeight()) return;
  for (osg::Texture2D* texture : {color_.get(), depth_.get()}) {
    texture->setTextureSize(width, height);
    texture->dirtyTextureObject();
  }
}

void PictureCopy::drawImplementation(osg::RenderInfo& info) const {
  osg::State& state = *info.getState();
  state.setActiveTextureUnit(0);
  for (osg::Texture2D* texture : {color_.get(), depth_.get()}) {
    in_pieces(info, kMostOfCopy, [&](int k, int n) {
      const int height = texture->getTextureHeight(), from = height * k / n, to = height * (k + 1) / n;
      texture->apply(state);
      glCopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, from, 0, from, texture->getTextureWidth(), to - from);
    });
    state.haveAppliedTextureAttribute(0, texture);
  }
}

}  // namespace palp
