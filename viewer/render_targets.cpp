#include "viewer/render_targets.h"

#include "viewer/arrays.h"

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

osg::ref_ptr<osg::Geometry> screen_rectangle() {
  osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
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
  for (osg::Texture2D* texture : {color_.get(), depth_.get()}) {
    texture->setTextureSize(width, height);
    texture->dirtyTextureObject();
  }
}

void PictureCopy::drawImplementation(osg::RenderInfo& info) const {
  osg::State& state = *info.getState();
  state.setActiveTextureUnit(0);
  for (osg::Texture2D* texture : {color_.get(), depth_.get()}) {
    texture->apply(state);
    glCopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 0, 0, texture->getTextureWidth(), texture->getTextureHeight());
    state.haveAppliedTextureAttribute(0, texture);
  }
}

}  // namespace palp
