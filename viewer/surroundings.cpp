#include "viewer/surroundings.h"

#include <osg/Depth>

#include "viewer/arrays.h"
#include "viewer/blending.h"
#include "viewer/render_targets.h"
#include "viewer/shaders.h"

namespace palp {
namespace {

// Everything of the scene is drawn after them.
constexpr int kBackgroundBin = -2, kGroundBin = -1;

osg::ref_ptr<osg::Geometry> quad(const osg::Vec2f& low, const osg::Vec2f& high, float z) {
  osg::ref_ptr<osg::Geometry> geometry = geometry_in_strips();
  geometry->setUseVertexBufferObjects(true);
  geometry->setVertexArray(array_of<osg::Vec3Array>(
      {{low.x(), low.y(), z}, {high.x(), low.y(), z}, {low.x(), high.y(), z}, {high.x(), high.y(), z}}));
  geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_STRIP, 0, 4));
  geometry->setCullingActive(false);
  return geometry;
}

}  // namespace

osg::ref_ptr<osg::Node> make_background() {
  osg::ref_ptr<osg::Geometry> geometry = quad({-1, -1}, {1, 1}, 0);
  osg::StateSet* state = geometry->getOrCreateStateSet();
  state->setAttributeAndModes(load_program("background", {"background.vert", "background.frag"}));
  state->setAttributeAndModes(new osg::Depth(osg::Depth::ALWAYS, 0, 1, false));
  state->setRenderBinDetails(kBackgroundBin, "RenderBin");
  return geometry;
}

osg::ref_ptr<osg::Geometry> make_ground() {
  osg::ref_ptr<osg::Geometry> geometry = quad({-1, -1}, {1, 1}, 0);
  osg::StateSet* state = geometry->getOrCreateStateSet();
  state->setAttributeAndModes(load_program("ground", {"ground.vert", "ground.frag", "lighting.glsl"}));
  blend_over(state);
  state->setRenderBinDetails(kGroundBin, "RenderBin");
  state->addUniform(new osg::Uniform("footprint", osg::Vec4f(0, 0, 1, 1)));
  state->addUniform(new osg::Uniform("fade", osg::Vec2f(1, 2)));
  state->addUniform(new osg::Uniform("cell", 0.1f));
  return geometry;
}

}  // namespace palp
