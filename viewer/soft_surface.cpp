#include "viewer/soft_surface.h"

#include <utility>

namespace palp {

SoftSurface::SoftSurface(const BodyMesh& mesh, Skin skin)
    : skin_(std::move(skin)),
      geometry_(mesh.solid),
      vertices_(static_cast<osg::Vec3Array*>(mesh.solid->getVertexArray())),
      normals_(static_cast<osg::Vec3Array*>(mesh.solid->getNormalArray())),
      drawn_(static_cast<osg::DrawElementsUInt*>(mesh.solid->getPrimitiveSet(0))),
      triangles_(drawn_->begin(), drawn_->end()) {
  geometry_->setDataVariance(osg::Object::DYNAMIC);
  geometry_->setCullingActive(false);  // its bounds are those at rest
}

void SoftSurface::follow(std::span<const float> places) {
  const bool whole = skin_.find_tears(places);
  skin_.carry(places, vertices_->asVector());
  find_normals();
  vertices_->dirty();
  normals_->dirty();
  if (whole && whole_) return;
  whole_ = whole;
  drawn_->clear();
  for (std::size_t t = 0; t < triangles_.size(); t += 3) {
    const GLuint a = triangles_[t], b = triangles_[t + 1], c = triangles_[t + 2];
    if (skin_.torn(a) || skin_.torn(b) || skin_.torn(c)) continue;
    for (const GLuint v : {a, b, c}) drawn_->push_back(v);
  }
  drawn_->dirty();
}

// A vertex has the mean normal of its triangles; where the surface has an edge each side has vertices of its own.
void SoftSurface::find_normals() {
  std::vector<osg::Vec3f>& normals = normals_->asVector();
  const std::vector<osg::Vec3f>& x = vertices_->asVector();
  std::fill(normals.begin(), normals.end(), osg::Vec3f());
  for (std::size_t t = 0; t < triangles_.size(); t += 3) {
    const GLuint a = triangles_[t], b = triangles_[t + 1], c = triangles_[t + 2];
    const osg::Vec3f area = (x[b] - x[a]) ^ (x[c] - x[a]);
    normals[a] += area;
    normals[b] += area;
    normals[c] += area;
  }
  for (osg::Vec3f& n : normals) n.normalize();
}

}  // namespace palp
