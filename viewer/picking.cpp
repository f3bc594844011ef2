#include "viewer/picking.h"

#include <algorithm>
#include <cmath>

namespace palp {
namespace {

// Returns the distance at which the ray meets the triangle (Moeller and Trumbore, 1997), from either side.
std::optional<double> meets(const Ray& ray, const osg::Vec3d& a, const osg::Vec3d& b, const osg::Vec3d& c) {
  const osg::Vec3d ab = b - a, ac = c - a;
  const osg::Vec3d p = ray.direction ^ ac;
  const double det = ab * p;
  if (!(std::abs(det) > 0)) return std::nullopt;
  const osg::Vec3d from_a = ray.origin - a;
  const double u = (from_a * p) / det;
  if (!(u >= 0 && u <= 1)) return std::nullopt;
  const osg::Vec3d q = from_a ^ ab;
  const double v = (ray.direction * q) / det;
  if (!(v >= 0 && u + v <= 1)) return std::nullopt;
  const double distance = (ac * q) / det;
  return distance > 0 ? std::optional(distance) : std::nullopt;
}

}  // namespace

std::optional<Hit> pick_particle(const Ray& ray, std::span<const float> positions, std::size_t first, std::size_t count,
                                 double radius, const osg::Vec4d& clip) {
  std::optional<Hit> nearest;
  const std::size_t particles = positions.size() / 3;
  const std::size_t end = std::min(particles, first + std::min(count, particles));
  for (std::size_t i = first; i < end; ++i) {
    const float* p = positions.data() + 3 * i;
    const osg::Vec3d center(p[0], p[1], p[2]);
    const osg::Vec3d to_center = center - ray.origin;
    const double along = to_center * ray.direction;
    const double inside = radius * radius - (to_center.length2() - along * along);
    if (!(inside >= 0)) continue;  // not finite, too
    const double distance = along - std::sqrt(inside);
    if (distance <= 0 || (nearest && distance >= nearest->distance) || !keeps(clip, center)) continue;
    nearest = Hit{i, distance};
  }
  return nearest;
}

std::optional<Hit> pick_surface(const Ray& ray, std::span<const float> vertices,
                                std::span<const std::uint32_t> triangles, const osg::Matrixd& to_world,
                                const osg::Vec4d& clip) {
  // in the frame of the body, so that its vertices stay as they are
  const osg::Matrixd to_body = osg::Matrixd::inverse(to_world);
  const Ray local{ray.origin * to_body, osg::Matrixd::transform3x3(ray.direction, to_body)};
  const auto vertex = [&](std::uint32_t i) {
    const float* v = vertices.data() + 3 * static_cast<std::size_t>(i);
    return osg::Vec3d(v[0], v[1], v[2]);
  };
  const std::size_t count = vertices.size() / 3;
  std::optional<Hit> nearest;
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    if (std::max({triangles[t], triangles[t + 1], triangles[t + 2]}) >= count) continue;
    const auto distance = meets(local, vertex(triangles[t]), vertex(triangles[t + 1]), vertex(triangles[t + 2]));
    if (!distance || (nearest && *distance >= nearest->distance)) continue;
    if (!keeps(clip, ray.origin + ray.direction * *distance)) continue;
    nearest = Hit{t / 3, *distance};
  }
  return nearest;
}

}  // namespace palp
