#include "sim_server/trade/scene_medium.h"

#include <algorithm>
#include <set>

#include "sim_server/geometry/solid.h"

namespace palp {

namespace {

double area_of(const SurfaceMesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
    area += 0.5 * (q - p).cross(r - p).norm();
  }
  return area;
}

double area_of(const Part& part) {
  const Eigen::Vector3d& h = part.half;
  switch (part.type) {
    case ShapeType::sphere:
      return 4 * EIGEN_PI * part.radius * part.radius;
    case ShapeType::cylinder:
      return 2 * EIGEN_PI * part.radius * (part.radius + 2 * part.half_height);
    case ShapeType::mesh:
      return area_of(part.mesh->mesh());
    default:
      return 8 * (h.x() * h.y() + h.y() * h.z() + h.z() * h.x());
  }
}

struct Extent {
  double volume = 0;  // [m^3]
  double length = 0;  // [m]
};

// Returns the largest shape of a body that is made of shapes; nothing of one that is read from a file.
Extent largest_shape(const BodyConfig& body) {
  Extent largest;
  if (body.shapes.empty() || body.shapes.front().type == ShapeType::particles) return largest;
  for (const Part& part : make_solid(body.shapes).parts) {
    const double volume = part.moments.volume;
    if (!part.subtract && volume > largest.volume) largest = {volume, 6 * volume / area_of(part)};
  }
  return largest;
}

}  // namespace

std::string medium_of(const SceneConfig& config) {
  std::set<BodyKind> kinds;
  for (const BodyConfig& body : config.bodies) {
    if (body.temperature) return "changing";
    kinds.insert(body.type);
  }
  const bool fluid = kinds.count(BodyKind::fluid) > 0, elastic = kinds.count(BodyKind::elastic) > 0;
  if (fluid && elastic) return "mixed";
  return fluid ? "fluid" : elastic ? "elastic" : "rigid";
}

double resolved_length(const SceneConfig& config, bool matter) {
  double tool = 0;
  Extent free, any;
  const auto larger = [](const Extent& a, const Extent& b) { return b.volume > a.volume ? b : a; };
  for (const BodyConfig& body : config.bodies) {
    const Extent extent = largest_shape(body);
    const bool held = std::any_of(config.proxies.begin(), config.proxies.end(),
                                  [&](const ProxyConfig& proxy) { return proxy.body == body.name; });
    if (held && extent.length > 0) tool = tool > 0 ? std::min(tool, extent.length) : extent.length;
    if (!held && body.type != BodyKind::fixed) free = larger(free, extent);
    any = larger(any, extent);
  }
  if (tool > 0 && !matter) return tool;
  return free.length > 0 ? free.length : any.length;
}

}  // namespace palp
