#include "viewer/shadow_map.h"

#include <algorithm>
#include <cmath>

#include <osg/PointSprite>
#include <osg/PolygonOffset>

#include "viewer/render_targets.h"
#include "viewer/shaders.h"

namespace palp {
namespace {

// To the key light, as in lighting.glsl.
const osg::Vec3d kKeyLight(-0.42, -0.50, 0.76);
constexpr double kRadiusOverSpacing = 0.6;  // of a particle's shadow
constexpr double kSinkOverSpacing = 1.3;    // of particles
constexpr double kMargin = 1.25;            // of the lit sphere over that around the box

}  // namespace

ShadowMap::ShadowMap()
    : depth_(new osg::Texture2D),
      points_(new osg::Group),
      from_eye_(new osg::Uniform("shadow_from_eye", osg::Matrixf())),
      texel_(new osg::Uniform("shadow_texel", 0.001f)) {
  depth_->setInternalFormat(GL_DEPTH_COMPONENT24);
  depth_->setSourceFormat(GL_DEPTH_COMPONENT);
  depth_->setSourceType(GL_UNSIGNED_INT);
  depth_->setFilter(osg::Texture::MIN_FILTER, osg::Texture::LINEAR);
  depth_->setFilter(osg::Texture::MAG_FILTER, osg::Texture::LINEAR);
  depth_->setWrap(osg::Texture::WRAP_S, osg::Texture::CLAMP_TO_BORDER);
  depth_->setWrap(osg::Texture::WRAP_T, osg::Texture::CLAMP_TO_BORDER);
  depth_->setBorderColor(osg::Vec4d(1, 1, 1, 1));
  depth_->setShadowComparison(true);
  depth_->setShadowCompareFunc(osg::Texture::LEQUAL);

  camera_ = new osg::Camera;
  camera_->setReferenceFrame(osg::Transform::ABSOLUTE_RF);
  camera_->setRenderOrder(osg::Camera::PRE_RENDER, -1);
  camera_->setRenderTargetImplementation(osg::Camera::FRAME_BUFFER_OBJECT);
  camera_->setImplicitBufferAttachmentMask(0, 0);
  camera_->attach(osg::Camera::DEPTH_BUFFER, depth_);
  camera_->setClearMask(GL_DEPTH_BUFFER_BIT);
  camera_->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
  camera_->setCullingActive(false);
  camera_->setAllowEventFocus(false);
  camera_->setCullMask(kCastsShadow);
  osg::StateSet* state = camera_->getOrCreateStateSet();
  const auto winning = osg::StateAttribute::ON | osg::StateAttribute::OVERRIDE;
  state->setAttributeAndModes(load_program("shadow", {"shadow.vert", "shadow.frag"}), winning);
  state->setAttributeAndModes(new osg::PolygonOffset(1.5f, 4.0f), winning);
  state->setTextureAttributeAndModes(0, new osg::PointSprite);
  state->setMode(GL_VERTEX_PROGRAM_POINT_SIZE, osg::StateAttribute::ON);
  state->addUniform(new osg::Uniform("sprites", false));
  state->addUniform(new osg::Uniform("radius", 0.01f));
  state->addUniform(new osg::Uniform("sink", 0.0f));
  state->addUniform(new osg::Uniform("target_height", 1.0f));
  state->addUniform(new osg::Uniform("clip_plane", osg::Vec4f(0, 0, 0, 1)));
  points_->getOrCreateStateSet()->addUniform(new osg::Uniform("sprites", true));
  points_->getStateSet()->addUniform(new osg::Uniform("sink", 0.0f));
  camera_->addChild(points_);
}

void ShadowMap::add_surfaces(osg::Node* surfaces) { camera_->addChild(surfaces); }
void ShadowMap::add_points(osg::Node* points) { points_->addChild(points); }

void ShadowMap::give_to(osg::StateSet& state) {
  state.setTextureAttribute(kShadowUnit, depth_);
  state.addUniform(new osg::Uniform("shadow_map", static_cast<int>(kShadowUnit)));
  state.addUniform(from_eye_);
  state.addUniform(texel_);
}

void ShadowMap::set_spacing(double spacing) {
  camera_->getStateSet()->getUniform("radius")->set(static_cast<float>(kRadiusOverSpacing * spacing));
  points_->getStateSet()->getUniform("sink")->set(static_cast<float>(kSinkOverSpacing * spacing));
}

void ShadowMap::set_size(int texels) {
  if (texels == texels_) return;
  texels_ = texels;
  resize_pass(*camera_, *depth_, texels, texels);
  camera_->getStateSet()->getUniform("target_height")->set(static_cast<float>(texels));
}

void ShadowMap::set_view(const osg::BoundingBoxd& box, const osg::Matrixd& view) {
  const double radius = kMargin * std::max(box.radius(), 1e-3);
  osg::Vec3d light = kKeyLight;
  light.normalize();
  camera_->setViewMatrixAsLookAt(box.center() + light * (2 * radius), box.center(), osg::Vec3d(0, 1, 0));
  camera_->setProjectionMatrixAsOrtho(-radius, radius, -radius, radius, 0.5 * radius, 4 * radius);
  const osg::Matrixd bias = osg::Matrixd::scale(0.5, 0.5, 0.5) * osg::Matrixd::translate(0.5, 0.5, 0.5);
  from_eye_->set(
      osg::Matrixf(osg::Matrixd::inverse(view) * camera_->getViewMatrix() * camera_->getProjectionMatrix() * bias));
  texel_->set(static_cast<float>(2 * radius / std::max(texels_, 1)));
}

void ShadowMap::set_clip(const osg::Vec4d& equation) {
  camera_->getStateSet()
      ->getUniform("clip_plane")
      ->set(osg::Vec4f(osg::Matrixd::inverse(camera_->getViewMatrix()) * equation));
}

}  // namespace palp
