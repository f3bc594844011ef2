#include "viewer/arrow_parts.h"

#include <cmath>

#include <osg/BlendFunc>
#include <osg/Depth>
#include <osg/PrimitiveSet>

#include "viewer/arrays.h"
#include "viewer/shaders.h"

namespace palp {

osg::ref_ptr<osg::Geometry> revolve(std::span<const osg::Vec2f> profile, const osg::Vec4f& color) {
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
  osg::ref_ptr<osg::Vec3Array> normals = new osg::Vec3Array;
  osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
  for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
    const osg::Vec2f &a = profile[k], &b = profile[k + 1];
    const auto begin = static_cast<GLint>(vertices->size());
    osg::Vec2f across(b.y() - a.y(), a.x() - b.x());
    across.normalize();
    for (int i = 0; i <= kSidesOfArrows; ++i) {
      const float angle = 2.0f * static_cast<float>(M_PI) * static_cast<float>(i) / kSidesOfArrows;
      const float c = std::cos(angle), s = std::sin(angle);
      for (const osg::Vec2f& ring : {b, a}) {
        vertices->push_back({ring.x() * c, ring.x() * s, ring.y()});
        normals->push_back({across.x() * c, across.x() * s, across.y()});
      }
    }
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_STRIP, begin, 2 * (kSidesOfArrows + 1)));
  }
  geometry->setUseVertexBufferObjects(true);
  geometry->setVertexArray(vertices);
  geometry->setNormalArray(normals, osg::Array::BIND_PER_VERTEX);
  geometry->setColorArray(array_of<osg::Vec4Array>({color}), osg::Array::BIND_OVERALL);
  geometry->setCullingActive(false);
  return geometry;
}

osg::ref_ptr<osg::Group> seen_and_hidden(osg::Node* shape) {
  osg::ref_ptr<osg::Group> root = new osg::Group;
  osg::ref_ptr<osg::Program> program = load_program("arrow", {"mesh.vert", "mesh.frag", "color.glsl", "lighting.glsl"});
  osg::ref_ptr<osg::Group> seen = new osg::Group;
  seen->addChild(shape);
  seen->getOrCreateStateSet()->setAttributeAndModes(program);

  // what lies behind other things, after everything solid
  osg::ref_ptr<osg::Group> hidden = new osg::Group;
  hidden->addChild(shape);
  osg::StateSet* state = hidden->getOrCreateStateSet();
  state->setAttributeAndModes(program);
  state->addUniform(new osg::Uniform("ghost", 0.28f));
  state->setAttributeAndModes(new osg::BlendFunc(osg::BlendFunc::SRC_ALPHA, osg::BlendFunc::ONE_MINUS_SRC_ALPHA));
  state->setAttributeAndModes(new osg::Depth(osg::Depth::GREATER, 0, 1, false));
  state->setRenderBinDetails(12, "RenderBin");
  root->addChild(seen);
  root->addChild(hidden);
  return root;
}

}  // namespace palp
