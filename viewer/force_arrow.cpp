#include "viewer/force_arrow.h"

#include <algorithm>
#include <cmath>

#include <osg/BlendFunc>
#include <osg/Depth>
#include <osg/Geometry>
#include <osg/PrimitiveSet>

#include "viewer/arrays.h"
#include "viewer/color_map.h"
#include "viewer/shaders.h"

namespace palp {
namespace {

constexpr int kSides = 24;
constexpr double kHeadRadiusOverShaft = 2.6;
constexpr double kHeadLengthOverShaft = 6.5;
constexpr double kMemory = 6;           // [s] in which the remembered peak falls by a factor of e
constexpr double kSmallestScale = 0.5;  // [N]
const osg::Vec4f kColor(1.0f, 0.56f, 0.13f, 1.0f);

// A surface of revolution about z through the rings (radius, z), normals from the slope between them.
osg::ref_ptr<osg::Geometry> revolve(std::initializer_list<osg::Vec2f> profile) {
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
  osg::ref_ptr<osg::Vec3Array> normals = new osg::Vec3Array;
  osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
  for (auto a = profile.begin(), b = a + 1; b != profile.end(); a = b++) {
    const auto begin = static_cast<GLint>(vertices->size());
    osg::Vec2f across(b->y() - a->y(), a->x() - b->x());
    across.normalize();
    for (int i = 0; i <= kSides; ++i) {
      const float angle = 2.0f * static_cast<float>(M_PI) * static_cast<float>(i) / kSides;
      const float c = std::cos(angle), s = std::sin(angle);
      for (const osg::Vec2f& ring : {*b, *a}) {
        vertices->push_back({ring.x() * c, ring.x() * s, ring.y()});
        normals->push_back({across.x() * c, across.x() * s, across.y()});
      }
    }
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLE_STRIP, begin, 2 * (kSides + 1)));
  }
  geometry->setUseVertexBufferObjects(true);
  geometry->setVertexArray(vertices);
  geometry->setNormalArray(normals, osg::Array::BIND_PER_VERTEX);
  geometry->setColorArray(array_of<osg::Vec4Array>({kColor}), osg::Array::BIND_OVERALL);
  geometry->setCullingActive(false);
  return geometry;
}

}  // namespace

ForceArrow::ForceArrow()
    : root_(new osg::Group),
      pose_(new osg::MatrixTransform),
      shaft_(new osg::MatrixTransform),
      head_(new osg::MatrixTransform) {
  shaft_->addChild(revolve({{0, 0}, {1, 0}, {1, 1}, {0, 1}}));
  head_->addChild(revolve({{0, 0}, {1, 0}, {0, 1}}));
  pose_->addChild(shaft_);
  pose_->addChild(head_);

  osg::ref_ptr<osg::Program> program = load_program("arrow", {"mesh.vert", "mesh.frag", "lighting.glsl"});
  osg::ref_ptr<osg::Group> seen = new osg::Group;
  seen->addChild(pose_);
  seen->getOrCreateStateSet()->setAttributeAndModes(program);
  seen->getStateSet()->setMode(GL_RESCALE_NORMAL, osg::StateAttribute::OFF);

  // what lies behind other things, after everything solid
  osg::ref_ptr<osg::Group> hidden = new osg::Group;
  hidden->addChild(pose_);
  osg::StateSet* state = hidden->getOrCreateStateSet();
  state->setAttributeAndModes(program);
  state->addUniform(new osg::Uniform("ghost", 0.28f));
  state->setAttributeAndModes(new osg::BlendFunc(osg::BlendFunc::SRC_ALPHA, osg::BlendFunc::ONE_MINUS_SRC_ALPHA));
  state->setAttributeAndModes(new osg::Depth(osg::Depth::GREATER, 0, 1, false));
  state->setRenderBinDetails(12, "RenderBin");
  root_->addChild(seen);
  root_->addChild(hidden);
  hide();
}

void ForceArrow::hide() { root_->setNodeMask(0); }

void ForceArrow::set(const osg::Vec3d& origin, const osg::Vec3d& force, double length, double thickness) {
  const bool drawable = origin.valid() && force.valid() && std::isfinite(length) && length > thickness &&
                        thickness > 0 && force.length2() > 0;
  if (!drawable) {
    hide();
    return;
  }
  root_->setNodeMask(~0u);
  // a short arrow keeps its shape: the head never takes more than half of it
  const double shape = std::min(1.0, 0.5 * length / (kHeadLengthOverShaft * thickness));
  const double head = kHeadLengthOverShaft * thickness * shape;
  const double shaft_radius = thickness * std::max(shape, 0.5);
  pose_->setMatrix(osg::Matrixd::rotate(osg::Vec3d(0, 0, 1), force) * osg::Matrixd::translate(origin));
  shaft_->setMatrix(osg::Matrixd::scale(shaft_radius, shaft_radius, length - head));
  head_->setMatrix(osg::Matrixd::scale(kHeadRadiusOverShaft * shaft_radius, kHeadRadiusOverShaft * shaft_radius, head) *
                   osg::Matrixd::translate(0, 0, length - head));
}

double ForceScale::update(double force, double sim_time) {
  const double passed = sim_time >= time_ ? sim_time - time_ : 0;  // time runs backwards at a reset
  time_ = sim_time;
  peak_ *= std::exp(-passed / kMemory);
  if (std::isfinite(force)) peak_ = std::max(peak_, force);
  const double wanted = nice_ceiling(std::max(peak_, kSmallestScale));
  if (wanted > full_scale_ || peak_ < 0.3 * full_scale_) full_scale_ = wanted;
  return full_scale_;
}

}  // namespace palp
