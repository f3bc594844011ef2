#include "sim_server/probes/solids_around.h"

#include <algorithm>
#include <cmath>

#include "sim_server/physics/wall_share.h"
#include "sim_server/scene/scene_heat.h"
#include "sim_server/solver/plan.h"

namespace palp {

// How deep beneath a surface a place still counts as on it, in spacings.
constexpr double kSurfaceOverSpacing = 0.1;

SolidsAround::SolidsAround(const Scene& scene) : SolidsAround(scene, make_plan(scene)) {}

SolidsAround::SolidsAround(const Scene& scene, const Plan& plan)
    : scene_(scene), store_(scene, plan), grids_(store_.grids_at(store_.node.data())), by_geometry_(plan.geometry) {
  for (const std::uint32_t body : store_.shaped) bounds_heat_.push_back(bounds_heat(scene, scene.bodies[body]));
}

Eigen::Vector3d SolidsAround::from_center(std::size_t k, const Eigen::Vector3d& x, const RigidState& state) const {
  const Body& body = scene_.bodies[store_.shaped[k]];
  const Eigen::Vector3d center = state.position + state.orientation * body.center;
  return state.orientation.conjugate() * box_of(scene_).between(x, center);
}

Distance SolidsAround::distance(std::size_t k, const Eigen::Vector3d& r) const {
  return solid_distance(store_.shape[k], store_.piece.data(), grids_.data(), r.cast<real>());
}

double SolidsAround::share(std::size_t k, const Eigen::Vector3d& r, double support) const {
  const Distance at = distance(k, r);
  if (!(at.d < support)) return 0;
  const auto dx = static_cast<real>(scene_.spacing);
  const WallKernel kernel = wall_kernel(FluidKernel::with_support(static_cast<real>(support), dx), dx, Vec3(0, 0, 0));
  const Vec3 x = r.cast<real>();
  // on the surface, as rounding has it, or as a mesh of facets has
  const Vec3 place = at.d > -real(kSurfaceOverSpacing) * dx ? raised(kernel, at, x) : x;
  return std::clamp<double>(wall_share(store_.shape[k], store_.piece.data(), grids_.data(), kernel, place).share, 0, 1);
}

double SolidsAround::share_of_plane(double distance) {
  const double u = std::max(0.0, 1 - std::abs(distance)), u2 = u * u;
  const double beyond = u2 * u2 * u2 * (3.5 - 4.5 * u + 1.5 * u2);
  return distance < 0 ? 1 - beyond : beyond;
}

}  // namespace palp
