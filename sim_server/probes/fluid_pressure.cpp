#include "sim_server/probes/fluid_pressure.h"

#include <algorithm>

#include "sim_server/physics/cohesion.h"

namespace palp {

void FluidPressure::load(const Snapshot* snapshot) {
  snapshot_ = snapshot;
  points_.reset();
}

double FluidPressure::of(std::uint32_t particle) const {
  const double p_i = snapshot_->pressure[particle], H = snapshot_->support;
  const MaterialConfig& material = material_of(scene_, particle);
  const double tension = material.surface_tension, adhesion = material.adhesion;
  if ((tension == 0 && adhesion == 0) || !(H > 0)) return p_i;
  if (!points_) points_.emplace(scene_, *snapshot_, H, true);
  const FluidKernel kernel = FluidKernel::with_support(static_cast<real>(H), static_cast<real>(scene_.spacing));
  const double norm = cohesion_norm(H);
  double virial = 0;
  points_->near(place_of(*snapshot_, particle), [&](std::uint32_t j, double r) {
    if (j == particle || r >= H) return;
    const bool fluid = scene_.bodies[scene_.body[j]].type == BodyKind::fluid;
    const double p_j = fluid ? snapshot_->pressure[j] : p_i;
    const double strength = fluid ? std::min(tension, material_of(scene_, j).surface_tension) : adhesion;
    virial += volume_of(scene_, *snapshot_, j) * ((p_i + p_j) * kernel.F(static_cast<real>(r)) * r * r -
                                                  strength / norm * cohesion_phi(static_cast<real>(r / H)) * r);
  });
  return virial / 6;
}

}  // namespace palp
