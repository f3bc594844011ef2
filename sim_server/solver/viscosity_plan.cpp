#include "sim_server/solver/viscosity_plan.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "config/error.h"
#include "sim_server/physics/viscous_bodies.h"
#include "sim_server/physics/wall_share.h"
#include "sim_server/solver/lattice.h"

namespace palp {
namespace {

constexpr int kMaxStages = 1000;
// The bound on K of a particle in a corner of walls over that of one within the fluid.
constexpr double kNearWalls = 2;

// Returns int_0^H shear dd of a plane: K of a body over 2 mu and its surface, in fluid that fills the room beside it
// [1/m].
double shear_of_plane(double support, double spacing) {
  const WallKernel kernel{FluidKernel::with_support(static_cast<real>(support), static_cast<real>(spacing)),
                          static_cast<real>(spacing), static_cast<real>(spacing / 4), 0, Vec3(0, 0, 0)};
  constexpr int kParts = 200;
  double sum = 0;
  for (int k = 0; k < kParts; ++k)
    sum += behind_face(kernel, static_cast<real>((k + 0.5) * support / kParts), Vec3(0, 0, 1), 0).shear;
  return sum * support / kParts;
}

// Returns a bound on K / m of a rigid body [1/s], were all the room around it filled with the most viscous fluid.
double body_rate(const Scene& scene, const Plan& plan, const Body& body, double viscosity) {
  const Eigen::Vector3d center = body.position + body.orientation * body.center;
  const double whole = 2 * viscosity * shear_of_plane(plan.support, scene.spacing);
  double sum = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  Eigen::Matrix3d turning = Eigen::Matrix3d::Zero();
  for (const auto& t : body.surface.triangles) {
    Eigen::Vector3d corner[3], r = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      corner[k] = body.position + body.orientation * body.surface.vertices[t[k]] - center;
      r += corner[k] / 3;
    }
    const double K = whole * (corner[1] - corner[0]).cross(corner[2] - corner[0]).norm() / 2;
    sum += K;
    moment += K * r;
    turning += K * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  const Eigen::Matrix3d R = body.orientation.toRotationMatrix();
  const Eigen::Matrix3d inverse = (R * body.inertia * R.transpose()).inverse();
  return body_viscous_rate(body.mass, inverse, sum, moment, turning);
}

// Returns the largest K / m of the scene [1/s], with a margin for the particles' disorder.
double largest_rate(const Scene& scene, const Plan& plan) {
  const double dx = scene.spacing, within = 2 * lattice_sums(plan.support / dx).F / (dx * dx);
  double viscosity = 0, rate = 0;
  for (const Body& body : scene.bodies) {
    if (body.type != BodyKind::fluid) continue;
    const MaterialConfig& m = scene.config.materials[body.material];
    viscosity = std::max(viscosity, m.viscosity);
    rate = std::max(rate, kNearWalls * within * m.viscosity / m.density);
  }
  for (const Body& body : scene.bodies) {
    if (body.type == BodyKind::elastic)
      rate = std::max(rate, kNearWalls * within * viscosity / scene.config.materials[body.material].density);
    if (body.type == BodyKind::rigid) rate = std::max(rate, 1.2 * body_rate(scene, plan, body, viscosity));
  }
  return rate;
}

// Returns the number of stages that a rate K / m times the sub-step needs.
int stages_for(double rate_dt) {
  int s = std::max(1, static_cast<int>(std::min(2 * std::sqrt(rate_dt), kMaxStages + 4.0)) - 3);
  while (s <= kMaxStages && stage_reach(s) < rate_dt) ++s;
  return s;
}

}  // namespace

void plan_viscosity(const Scene& scene, double without, double beside_stages, double stable, Plan& plan) {
  const NumericsConfig& n = scene.config.numerics;
  const double step = 1 / scene.config.rate_hz, with = std::min(without, n.safety * stable);
  const auto steps = [&](double allowed) { return std::max(1.0, std::ceil(step / allowed - 1e-9)); };
  plan.explicit_sub_steps = steps(with);
  plan.viscous_stages = 0;
  // stages have no such share as bonds leave a pair of its viscosity
  if (!plan.fluid || plan.change || plan.method == Method::paper || n.viscosity == ViscosityScheme::explicit_) return;
  const bool asked = n.viscosity == ViscosityScheme::staged;
  if (!asked && (n.sub_steps ? stable >= step / *n.sub_steps : with >= without)) return;
  const double staged = n.sub_steps ? double(*n.sub_steps) : steps(beside_stages);
  const int stages = stages_for(largest_rate(scene, plan) * step / staged);
  // in passes over the neighbours: density, walls and forces, and for the stages their beginning
  if (!asked && !n.sub_steps && 3 * plan.explicit_sub_steps <= staged * (4 + stages)) return;
  if (stages > kMaxStages)
    throw ConfigError(fmt::format(
        "{}: a sub-step of {:.3g} ms would need more than {} stages of viscosity: raise the spacing, rate_hz or "
        "numerics.sub_steps, or lower the viscosity",
        scene.config.path, 1e3 * step / staged, kMaxStages));
  plan.viscous_stages = stages;
}

std::string describe_viscosity(const Plan& plan) {
  if (!plan.fluid) return "";
  if (plan.viscous_stages == 0) return ", viscosity explicit";
  return fmt::format(", viscosity in {} stages a sub-step (explicit: {:.0f} sub-steps)", plan.viscous_stages,
                     plan.explicit_sub_steps);
}

}  // namespace palp
