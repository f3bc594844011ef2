#include "sim_server/scene/walls_at_rest.h"

#include <algorithm>

#include "sim_server/physics/wall_sight.h"
#include "sim_server/scene/support_radii.h"

namespace palp {

using Eigen::Vector3d;

WallsAtRest::WallsAtRest(const Scene& scene) : scene_(scene), shapes_(solid_shapes(scene)) {
  const double support = fluid_support(scene);
  add_profiles(FluidKernelOf<double>::with_support(support, scene.spacing), shapes_);
  mark_thin(scene, support, shapes_);
  grids_ = shapes_.grids_at(shapes_.node.data());
  const auto dx = static_cast<real>(scene.spacing);
  kernel_ = wall_kernel(FluidKernel::with_support(static_cast<real>(support), dx), dx, Vec3(0, 0, 0));
  some_thin_ =
      std::any_of(shapes_.shape.begin(), shapes_.shape.end(), [](const ContactBody& shape) { return shape.thin; });
}

Vec3 WallsAtRest::from_center(std::size_t k, const Vector3d& x) const {
  const Body& body = scene_.bodies[shapes_.shaped[k]];
  const Vector3d center = body.position + body.orientation * body.center;
  return (body.orientation.conjugate() * box_of(scene_).between(x, center)).cast<real>();
}

WallsHere WallsAtRest::at(const Vector3d& x) const {
  WallsHere out;
  for (std::size_t k = 0; k < shapes_.shape.size(); ++k) {
    const ContactBody& shape = shapes_.shape[k];
    const Vec3 y = from_center(k, x);
    if (outside_bounds(shape, y, kernel_.of.support)) continue;
    const Eigen::Quaterniond& turn = scene_.bodies[shapes_.shaped[k]].orientation;
    const Distance near = solid_distance(shape, shapes_.piece.data(), grids_.data(), y);
    if (static_cast<double>(near.d) < out.distance) {
      out.distance = static_cast<double>(near.d);
      out.normal = turn * near.n.cast<double>();
    }
    if (!(near.d < kernel_.of.support)) continue;
    const WallShare wall = wall_share(shape, shapes_.piece.data(), grids_.data(), kernel_, raised(kernel_, near, y));
    out.slope += turn * wall.slope.cast<double>();
    out.share += static_cast<double>(wall.share);
  }
  return out;
}

bool WallsAtRest::in_sight(const Vector3d& x, const Vector3d& y) const {
  const auto near = static_cast<real>(kSightNear * scene_.spacing);
  for (std::size_t k = 0; k < shapes_.shape.size(); ++k) {
    const ContactBody& shape = shapes_.shape[k];
    if (!shape.thin) continue;
    const Vec3 from = from_center(k, x);
    if (outside_bounds(shape, from, kernel_.of.support)) continue;
    const auto local = [&shape](const Vec3& z) { return Vec3(shape.R.transpose() * (z - shape.c)); };
    const Vec3 to =
        from + (scene_.bodies[shapes_.shaped[k]].orientation.conjugate() * box_of(scene_).between(y, x)).cast<real>();
    if (blocks_sight(shape, shapes_.piece.data(), grids_.data(), local(from), local(to), near)) return false;
  }
  return true;
}

}  // namespace palp
