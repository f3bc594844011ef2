// Particles as OpenGL's points, from arrays that change from picture to picture.
#pragma once

#include <cstdint>

#include <osg/Geometry>
#include <osg/PrimitiveSet>
#include <osg/ref_ptr>

#include "viewer/gpu_pacing.h"
#include "viewer/streamed_array.h"

namespace palp {

// Points that are drawn wherever they are, and that nobody asks for their bounds: OSG would go through a million of
// them in each picture.
class Points : public osg::Geometry {
 public:
  // more: four numbers beside each vertex, gl_MultiTexCoord0 in its shader; null: there are none.
  Points(StreamedArray<osg::Vec4Array>* vertices, StreamedArray<osg::Vec4ubArray>* colors,
         StreamedArray<osg::Vec4Array>* more = nullptr)
      : vertices_(vertices), colors_(colors), more_(more) {
    setUseDisplayList(false);
    setUseVertexBufferObjects(true);
    setCullingActive(false);
    setVertexArray(vertices);
    setColorArray(colors, osg::Array::BIND_PER_VERTEX);
    if (more != nullptr) setTexCoordArray(0, more, osg::Array::BIND_PER_VERTEX);
  }
  osg::BoundingBox computeBoundingBox() const override { return {}; }
  osg::BoundingSphere computeBound() const override { return {}; }
  // Each piece has its share of every range.
  void drawImplementation(osg::RenderInfo& info) const override {
    vertices_->copy(info);
    colors_->copy(info);
    if (more_) more_->copy(info);
    drawVertexArraysImplementation(info);
    in_pieces(info, kMostPieces, [&](int k, int n) {
      for (const auto& primitives : getPrimitiveSetList()) {
        const auto& range = static_cast<const osg::DrawArrays&>(*primitives);
        const auto from = range.getCount() * std::int64_t{k} / n, to = range.getCount() * std::int64_t{k + 1} / n;
        glDrawArrays(GL_POINTS, range.getFirst() + static_cast<GLint>(from), static_cast<GLsizei>(to - from));
      }
    });
    info.getState()->unbindVertexBufferObject();
  }

 private:
  static constexpr int kMostPieces = 64;
  osg::ref_ptr<StreamedArray<osg::Vec4Array>> vertices_;
  osg::ref_ptr<StreamedArray<osg::Vec4ubArray>> colors_;
  osg::ref_ptr<StreamedArray<osg::Vec4Array>> more_;
};

}  // namespace palp
