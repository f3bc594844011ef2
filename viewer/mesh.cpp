#include "viewer/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include <osg/BoundingBox>
#include <osg/PrimitiveSet>

#include "viewer/arrays.h"

namespace palp {
namespace {

constexpr float kCreaseCosine = 0.77f;            // 40 degrees
constexpr double kWeldShare = 1e-6;               // of the size: vertices this close are one
constexpr float kSmallestArea = 1e-11f;           // of the size squared: smaller triangles have no direction
constexpr double kHollowShare = 0.15;             // of the area facing the inside, from which a body counts as hollow
constexpr std::size_t kMostAround = 128;          // triangles at a vertex that its normal is the mean of
constexpr std::size_t kMaxEdgeTriangles = 20000;  // finer surfaces are curved; lines on them are clutter

struct Triangle {
  std::array<unsigned, 3> corner;  // welded vertices
  osg::Vec3f normal;
  float area;
};

struct Surface {
  std::vector<osg::Vec3f> vertices;  // welded
  std::vector<Triangle> triangles;
  osg::BoundingBox box;
};

// Vertices at the same place become one, so that surfaces written as loose triangles are shaded smoothly too.
Surface weld(const BodyDescription& body) {
  Surface surface;
  const std::size_t count = body.vertices.size() / 3;
  std::vector<unsigned> welded(count);
  const auto vertex = [&body](std::size_t i) {
    return osg::Vec3f(body.vertices[3 * i], body.vertices[3 * i + 1], body.vertices[3 * i + 2]);
  };
  const auto usable = [](const osg::Vec3f& v) { return std::isfinite(v.length2()); };
  for (std::size_t i = 0; i < count; ++i) {
    if (usable(vertex(i))) surface.box.expandBy(vertex(i));
  }
  const double cell = std::max(kWeldShare * surface.box.radius(), 1e-12);
  std::map<std::tuple<long, long, long>, unsigned> seen;
  for (std::size_t i = 0; i < count; ++i) {
    const osg::Vec3f v = vertex(i);
    if (!usable(v)) {
      welded[i] = ~0u;
      continue;
    }
    const osg::Vec3d from = osg::Vec3d(v) - osg::Vec3d(surface.box._min);
    const auto [at, is_new] =
        seen.try_emplace({std::lround(from.x() / cell), std::lround(from.y() / cell), std::lround(from.z() / cell)},
                         static_cast<unsigned>(surface.vertices.size()));
    if (is_new) surface.vertices.push_back(v);
    welded[i] = at->second;
  }
  for (std::size_t t = 0; t + 2 < body.triangles.size(); t += 3) {
    Triangle triangle{};
    bool good = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t index = body.triangles[t + k];
      good = good && index < count && welded[index] != ~0u;
      if (good) triangle.corner[k] = welded[index];
    }
    const auto& c = triangle.corner;
    if (!good || c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) continue;
    const osg::Vec3f& a = surface.vertices[triangle.corner[0]];
    triangle.normal = (surface.vertices[triangle.corner[1]] - a) ^ (surface.vertices[triangle.corner[2]] - a);
    triangle.area = 0.5f * triangle.normal.normalize();
    if (triangle.area > kSmallestArea * surface.box.radius2()) surface.triangles.push_back(triangle);
  }
  return surface;
}

bool faces_inside(const Surface& surface, const Triangle& t) {
  const osg::Vec3f middle =
      (surface.vertices[t.corner[0]] + surface.vertices[t.corner[1]] + surface.vertices[t.corner[2]]) / 3.0f;
  return t.normal * (osg::Vec3f(surface.box.center()) - middle) > 0.02f * surface.box.radius();
}

bool is_hollow(const Surface& surface) {
  double all = 0, inside = 0;
  for (const Triangle& t : surface.triangles) {
    all += t.area;
    if (faces_inside(surface, t)) inside += t.area;
  }
  return inside > kHollowShare * all;
}

class GeometryBuilder {
 public:
  explicit GeometryBuilder(const Surface& surface) : surface_(surface), around_(surface.vertices.size()) {
    for (unsigned t = 0; t < surface.triangles.size(); ++t) {
      for (const unsigned v : surface.triangles[t].corner)
        if (around_[v].size() < kMostAround) around_[v].push_back(t);
    }
  }

  void add(const Triangle& t) {
    for (const unsigned v : t.corner) {
      osg::Vec3f normal;
      for (const unsigned other : around_[v]) {
        const Triangle& o = surface_.triangles[other];
        if (o.normal * t.normal > kCreaseCosine) normal += o.normal * o.area;
      }
      normal.normalize();
      vertices_->push_back(surface_.vertices[v]);
      normals_->push_back(normal);
    }
  }

  osg::ref_ptr<osg::Geometry> finish(const osg::Vec4f& color) {
    if (vertices_->empty()) return nullptr;
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setUseVertexBufferObjects(true);
    geometry->setVertexArray(vertices_);
    geometry->setNormalArray(normals_, osg::Array::BIND_PER_VERTEX);
    geometry->setColorArray(array_of<osg::Vec4Array>({color}), osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(new osg::DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices_->size())));
    return geometry;
  }

 private:
  const Surface& surface_;
  std::vector<std::vector<unsigned>> around_;
  osg::ref_ptr<osg::Vec3Array> vertices_ = new osg::Vec3Array;
  osg::ref_ptr<osg::Vec3Array> normals_ = new osg::Vec3Array;
};

osg::ref_ptr<osg::Geometry> crease_lines(const Surface& surface) {
  std::map<std::pair<unsigned, unsigned>, std::vector<unsigned>> sides;
  for (unsigned t = 0; t < surface.triangles.size(); ++t) {
    const auto& c = surface.triangles[t].corner;
    for (std::size_t k = 0; k < 3; ++k) sides[std::minmax(c[k], c[(k + 1) % 3])].push_back(t);
  }
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
  for (const auto& [edge, of] : sides) {
    const bool smooth =
        of.size() == 2 && surface.triangles[of[0]].normal * surface.triangles[of[1]].normal > kCreaseCosine;
    if (smooth) continue;
    vertices->push_back(surface.vertices[edge.first]);
    vertices->push_back(surface.vertices[edge.second]);
  }
  if (vertices->empty()) return nullptr;
  osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
  geometry->setUseVertexBufferObjects(true);
  geometry->setVertexArray(vertices);
  geometry->setColorArray(array_of<osg::Vec4Array>({osg::Vec4f(0.86f, 0.92f, 0.97f, 0.42f)}), osg::Array::BIND_OVERALL);
  geometry->addPrimitiveSet(new osg::DrawArrays(GL_LINES, 0, static_cast<GLsizei>(vertices->size())));
  return geometry;
}

}  // namespace

BodyMesh build_mesh(const BodyDescription& body) {
  const Surface surface = weld(body);
  const bool hollow = body.kind == BodyKind::fixed && is_hollow(surface);
  GeometryBuilder solid(surface), glass(surface);
  for (const Triangle& t : surface.triangles) {
    const bool outside = hollow && !faces_inside(surface, t);
    (outside ? glass : solid).add(t);
  }
  const osg::Vec4f color(body.color[0], body.color[1], body.color[2], 1.0f);
  BodyMesh mesh;
  mesh.solid = solid.finish(color);
  mesh.glass = glass.finish(color);
  if (hollow && surface.triangles.size() <= kMaxEdgeTriangles) mesh.edges = crease_lines(surface);
  return mesh;
}

}  // namespace palp
