#include "viewer/wall_depths.h"

#include <osg/BlendEquation>
#include <osg/BlendFunc>
#include <osg/Geode>

#include "viewer/render_targets.h"
#include "viewer/shaders.h"

namespace palp {
namespace {

constexpr int kFirstPass = -1;
constexpr double kSlackOverSpacing = 0.8;  // the surface of what lies on a wall is farther off

// The same places, without the state that the part is drawn with in the picture. Four numbers a texel, the least of
// which is kept, take a GPU so long that a step could meet them.
osg::ref_ptr<osg::Geode> bare(const osg::Geometry& part, bool inner) {
  osg::ref_ptr<osg::Geometry> geometry = geometry_in_strips();
  geometry->setUseVertexBufferObjects(true);
  geometry->setVertexArray(const_cast<osg::Array*>(part.getVertexArray()));
  for (const auto& primitives : part.getPrimitiveSetList()) geometry->addPrimitiveSet(primitives);
  osg::ref_ptr<osg::Geode> geode = new osg::Geode;
  geode->addDrawable(geometry);
  geode->getOrCreateStateSet()->addUniform(new osg::Uniform("inner", inner));
  return geode;
}

}  // namespace

osg::ref_ptr<osg::MatrixTransform> hollow_wall(const osg::Geometry& inner, const osg::Geometry& outer) {
  osg::ref_ptr<osg::MatrixTransform> wall = new osg::MatrixTransform;
  wall->addChild(bare(inner, true));
  wall->addChild(bare(outer, false));
  return wall;
}

WallDepths::WallDepths(osg::Node* walls)
    : texture_(float_texture(GL_RGBA32F_ARB, GL_RGBA)), camera_(pass_into(texture_, kFirstPass, false)) {
  osg::StateSet* state = camera_->getOrCreateStateSet();
  state->setAttributeAndModes(load_program("wall depths", {"wall_depths.vert", "wall_depths.frag"}));
  state->setMode(GL_CULL_FACE, osg::StateAttribute::OFF);
  state->setAttributeAndModes(new osg::BlendEquation(osg::BlendEquation::RGBA_MAX));
  state->setAttributeAndModes(new osg::BlendFunc(osg::BlendFunc::ONE, osg::BlendFunc::ONE));
  state->addUniform(new osg::Uniform("wall_slack", 0.0f));
  camera_->addChild(walls);
}

void WallDepths::set_spacing(double spacing) {
  camera_->getStateSet()->getUniform("wall_slack")->set(static_cast<float>(kSlackOverSpacing * spacing));
}

void WallDepths::set_size(int width, int height) {
  if (width == texture_->getTextureWidth() && height == texture_->getTextureHeight()) return;
  resize_pass(*camera_, *texture_, width, height);
}

}  // namespace palp
