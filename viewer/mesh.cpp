#include "viewer/mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <exception>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include <osg/BoundingBox>
#include <osg/PrimitiveSet>
#include <osg/TriangleIndexFunctor>

#include "viewer/arrays.h"
#include "viewer/medium.h"
#include "viewer/refine.h"
#include "viewer/sharpen.h"
#include "viewer/welded_surface.h"

namespace palp {
namespace {

constexpr float kCreaseCosine = 0.77f;            // 40 degrees
constexpr double kWeldShare = 1e-6;               // of the size: vertices this close are one
constexpr float kSmallestArea = 1e-11f;           // of the size squared: smaller triangles have no direction
constexpr double kHollowShare = 0.15;             // of the area facing the inside, from which a body counts as hollow
constexpr std::size_t kMostAround = 128;          // triangles at a vertex that its normal is the mean of
constexpr std::size_t kMaxEdgeTriangles = 20000;  // finer surfaces are curved; lines on them are clutter

class Cancelled : public std::exception {};

// Counts the work done into a BuildProgress now and then, and ends the work when nobody wants it any more.
class WorkMeter {
 public:
  explicit WorkMeter(BuildProgress* progress) : progress_(progress) {}
  ~WorkMeter() { flush(); }
  WorkMeter(const WorkMeter&) = delete;
  WorkMeter& operator=(const WorkMeter&) = delete;

  // Throws Cancelled.
  void count_one() {
    if (++uncounted_ < 4096) return;
    flush();
    if (progress_ != nullptr && progress_->cancelled) throw Cancelled();
  }

 private:
  void flush() {
    if (progress_ != nullptr) progress_->done += uncounted_;
    uncounted_ = 0;
  }

  BuildProgress* progress_;
  std::size_t uncounted_ = 0;
};

// Numbers the places where vertices are: places in one cell have one number. A table with open addressing, because
// surfaces may have millions of vertices.
class PlaceNumbers {
 public:
  PlaceNumbers(const osg::BoundingBox& box, std::size_t vertices)
      : origin_(box._min),
        cell_(std::max(kWeldShare * box.radius(), 1e-12)),
        keys_(std::bit_ceil(2 * vertices + 2), kFree),
        numbers_(keys_.size()) {}

  // Returns the number of the place and whether it is the first vertex there, which then gets `next`.
  std::pair<unsigned, bool> find_or_add(const osg::Vec3f& place, unsigned next) {
    const osg::Vec3d from = (osg::Vec3d(place) - origin_) / cell_;
    // a side of the box has at most two radii, that is 2 / kWeldShare < 2^21 cells
    const auto cells = [](double x) { return static_cast<std::uint64_t>(std::llround(x)); };
    const std::uint64_t key = cells(from.x()) | cells(from.y()) << 21 | cells(from.z()) << 42;
    const std::size_t mask = keys_.size() - 1;
    std::size_t slot = (key * 0x9e3779b97f4a7c15u >> 20) & mask;
    while (keys_[slot] != kFree && keys_[slot] != key) slot = (slot + 1) & mask;
    const bool is_new = keys_[slot] == kFree;
    if (is_new) {
      keys_[slot] = key;
      numbers_[slot] = next;
    }
    return {numbers_[slot], is_new};
  }

 private:
  static constexpr std::uint64_t kFree = ~std::uint64_t{0};
  osg::Vec3d origin_;
  double cell_;  // [m]
  std::vector<std::uint64_t> keys_;
  std::vector<unsigned> numbers_;
};

// Vertices at the same place become one, so that surfaces written as loose triangles are shaded smoothly too.
// welded: gets the number in surface.vertices of each vertex, ~0 for one that is not finite.
void weld_vertices(const BodyDescription& body, Surface& surface, std::vector<unsigned>& welded, WorkMeter& meter) {
  const std::size_t count = body.vertices.size() / 3;
  const auto vertex = [&body](std::size_t i) {
    return osg::Vec3f(body.vertices[3 * i], body.vertices[3 * i + 1], body.vertices[3 * i + 2]);
  };
  const auto usable = [](const osg::Vec3f& v) { return std::isfinite(v.length2()); };
  for (std::size_t i = 0; i < count; ++i) {
    if (usable(vertex(i))) surface.box.expandBy(vertex(i));
  }
  welded.assign(count, ~0u);
  PlaceNumbers places(surface.box, count);
  for (std::size_t i = 0; i < count; ++i) {
    meter.count_one();
    const osg::Vec3f v = vertex(i);
    if (!usable(v)) continue;
    const auto [number, is_new] = places.find_or_add(v, static_cast<unsigned>(surface.vertices.size()));
    if (is_new) surface.vertices.push_back(v);
    welded[i] = number;
  }
}

Surface weld(const BodyDescription& body, WorkMeter& meter) {
  Surface surface;
  std::vector<unsigned> welded;
  weld_vertices(body, surface, welded, meter);
  surface.triangles.reserve(body.triangles.size() / 3);
  for (std::size_t t = 0; t + 2 < body.triangles.size(); t += 3) {
    meter.count_one();
    Triangle triangle{};
    bool good = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t index = body.triangles[t + k];
      good = good && index < welded.size() && welded[index] != ~0u;
      if (good) triangle.corner[k] = welded[index];
    }
    const auto& c = triangle.corner;
    if (!good || c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) continue;
    if (measure(surface, triangle)) surface.triangles.push_back(triangle);
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

// The triangles at each vertex, at most kMostAround of them.
class TrianglesAround {
 public:
  explicit TrianglesAround(const Surface& surface) : first_(surface.vertices.size() + 1) {
    std::vector<std::size_t> count(surface.vertices.size());
    for (const Triangle& t : surface.triangles) {
      for (const unsigned v : t.corner) count[v] = std::min(count[v] + 1, kMostAround);
    }
    for (std::size_t v = 0; v < count.size(); ++v) first_[v + 1] = first_[v] + count[v];
    triangles_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (unsigned t = 0; t < surface.triangles.size(); ++t) {
      for (const unsigned v : surface.triangles[t].corner)
        if (next[v] < first_[v + 1]) triangles_[next[v]++] = t;
    }
  }
  std::span<const unsigned> of(unsigned vertex) const {
    return {triangles_.data() + first_[vertex], first_[vertex + 1] - first_[vertex]};
  }

 private:
  std::vector<std::size_t> first_;  // by vertex, of triangles_
  std::vector<unsigned> triangles_;
};

// Triangles share a drawn vertex where they share place and normal, so that smooth surfaces are small and quick to
// draw.
class GeometryBuilder {
 public:
  GeometryBuilder(const Surface& surface, const TrianglesAround& around)
      : surface_(surface), around_(around), newest_(surface.vertices.size(), kNone) {}

  void add(const Triangle& t) {
    for (const unsigned v : t.corner) indices_->push_back(drawn_vertex(v, normal_at(v, t)));
  }

  osg::ref_ptr<osg::Geometry> finish(const osg::Vec4f& color) {
    if (vertices_->empty()) return nullptr;
    osg::ref_ptr<osg::Geometry> geometry = new osg::Geometry;
    geometry->setUseVertexBufferObjects(true);
    geometry->setVertexArray(vertices_);
    geometry->setNormalArray(normals_, osg::Array::BIND_PER_VERTEX);
    geometry->setColorArray(array_of<osg::Vec4Array>({color}), osg::Array::BIND_OVERALL);
    geometry->addPrimitiveSet(indices_);
    geometry->getBoundingBox();  // kept, so that the thread that draws need not compute it
    return geometry;
  }

 private:
  static constexpr unsigned kNone = ~0u;
  static constexpr int kMostTried = 8;  // a vertex of many normals is drawn more often, but found in constant time

  osg::Vec3f normal_at(unsigned v, const Triangle& t) const {
    if (t.primitive >= 0) {
      const osg::Vec3f exact =
          surface_.primitives[static_cast<std::size_t>(t.primitive)].normal(osg::Vec3d(surface_.vertices[v]));
      return exact * t.normal < 0 ? -exact : exact;
    }
    osg::Vec3f normal;
    for (const unsigned other : around_.of(v)) {
      const Triangle& o = surface_.triangles[other];
      if (o.normal * t.normal > kCreaseCosine) normal += o.normal * o.area;
    }
    normal.normalize();
    return normal;
  }

  unsigned drawn_vertex(unsigned v, const osg::Vec3f& normal) {
    unsigned at = newest_[v];
    for (int i = 0; i < kMostTried && at != kNone; ++i, at = older_[at]) {
      if ((*normals_)[at] == normal) return at;
    }
    vertices_->push_back(surface_.vertices[v]);
    normals_->push_back(normal);
    older_.push_back(newest_[v]);
    return newest_[v] = static_cast<unsigned>(older_.size() - 1);
  }

  const Surface& surface_;
  const TrianglesAround& around_;
  std::vector<unsigned> newest_;  // by welded vertex: the drawn vertex that was added last for it
  std::vector<unsigned> older_;   // by drawn vertex: the one added before it for the same welded vertex
  osg::ref_ptr<osg::Vec3Array> vertices_ = new osg::Vec3Array;
  osg::ref_ptr<osg::Vec3Array> normals_ = new osg::Vec3Array;
  osg::ref_ptr<osg::DrawElementsUInt> indices_ = new osg::DrawElementsUInt(GL_TRIANGLES);
};

bool is_smooth(const Triangle& a, const Triangle& b) {
  return a.normal * b.normal > kCreaseCosine || (a.primitive >= 0 && a.primitive == b.primitive);
}

osg::ref_ptr<osg::Geometry> crease_lines(const Surface& surface) {
  std::map<std::pair<unsigned, unsigned>, std::vector<unsigned>> sides;
  for (unsigned t = 0; t < surface.triangles.size(); ++t) {
    const auto& c = surface.triangles[t].corner;
    for (std::size_t k = 0; k < 3; ++k) sides[std::minmax(c[k], c[(k + 1) % 3])].push_back(t);
  }
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array;
  for (const auto& [edge, of] : sides) {
    const bool smooth = of.size() == 2 && is_smooth(surface.triangles[of[0]], surface.triangles[of[1]]);
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

struct TakeTriangles {
  Surface* out = nullptr;
  void operator()(unsigned a, unsigned b, unsigned c) const {
    Triangle triangle{{a, b, c}, {}, 0};
    if (measure(*out, triangle)) out->triangles.push_back(triangle);
  }
};

}  // namespace

Surface surface_of(const osg::Geometry& part) {
  Surface surface;
  const auto* vertices = dynamic_cast<const osg::Vec3Array*>(part.getVertexArray());
  if (vertices == nullptr) return surface;
  surface.vertices.assign(vertices->begin(), vertices->end());
  for (const osg::Vec3f& vertex : surface.vertices) surface.box.expandBy(vertex);
  osg::TriangleIndexFunctor<TakeTriangles> take;
  take.out = &surface;
  part.accept(take);
  return surface;
}

bool measure(const Surface& surface, Triangle& t) {
  const osg::Vec3f& a = surface.vertices[t.corner[0]];
  t.normal = (surface.vertices[t.corner[1]] - a) ^ (surface.vertices[t.corner[2]] - a);
  t.area = 0.5f * t.normal.normalize();
  return t.area > kSmallestArea * surface.box.radius2();
}

std::size_t build_work(const BodyDescription& body) {
  return body.vertices.size() / 3 + 2 * (body.triangles.size() / 3);
}

bool has_skin(const BodyDescription& body) {
  return body.kind == BodyKind::elastic && !body.triangles.empty() && !body.rest.empty() &&
         body.rest.size() == 3 * std::size_t{body.count} && usual_medium(body) == Medium::opaque;
}

BodyMesh build_mesh(const BodyDescription& body, BuildProgress* progress, double longest_edge) {
  BodyMesh mesh;
  try {
    WorkMeter meter(progress);
    Surface surface = weld(body, meter);
    sharpen(surface);
    if (longest_edge > 0) refine(surface, longest_edge);
    const bool hollow = body.kind == BodyKind::fixed && is_hollow(surface);
    const TrianglesAround around(surface);
    GeometryBuilder solid(surface, around), glass(surface, around);
    for (const Triangle& t : surface.triangles) {
      meter.count_one();
      const bool outside = hollow && !faces_inside(surface, t);
      (outside ? glass : solid).add(t);
    }
    const osg::Vec4f color(body.color[0], body.color[1], body.color[2], 1.0f);
    mesh.solid = solid.finish(color);
    mesh.glass = glass.finish(color);
    if (hollow && surface.triangles.size() <= kMaxEdgeTriangles) mesh.edges = crease_lines(surface);
  } catch (const Cancelled&) {
    return {};
  }
  return mesh;
}

}  // namespace palp
