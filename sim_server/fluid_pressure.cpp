#include "sim_server/fluid_pressure.h"

#include <algorithm>

#include "sim_server/physics/cohesion.h"

namespace palp {

namespace {

Eigen::Vector3d place_of(const Snapshot& s, std::size_t i) {
  return Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>();
}

bool attracts(const MaterialConfig& m) { return m.surface_tension > 0 || m.adhesion > 0; }

}  // namespace

FluidPressure::FluidPressure(const Scene& scene)
    : scene_(scene), box_{scene.bounds_min, scene.bounds_max, scene.config.periodic} {
  for (const Body& body : scene.bodies)
    attracts_ = attracts_ || (body.type == BodyType::fluid && attracts(scene.config.materials[body.material]));
}

void FluidPressure::load(const Snapshot* snapshot) {
  snapshot_ = snapshot;
  grid_.reset();
}

const MaterialConfig& FluidPressure::material(std::size_t particle) const {
  return scene_.config.materials[scene_.bodies[scene_.body[particle]].material];
}

double FluidPressure::volume(std::size_t particle) const {
  const double density = snapshot_->density[particle];
  return density > 0 ? scene_.volume[particle] * material(particle).density / density : scene_.volume[particle];
}

void FluidPressure::list() const {
  position_.clear();
  index_.clear();
  for (std::uint32_t i = 0; i < scene_.position.size(); ++i) {
    const Eigen::Vector3d x = place_of(*snapshot_, i);
    if ((!snapshot_->gone.empty() && snapshot_->gone[i] != 0) || !x.allFinite() ||
        x.cwiseAbs().maxCoeff() > 1e9 * snapshot_->support)
      continue;
    position_.push_back(x);
    index_.push_back(i);
  }
  grid_.emplace(position_, box_, snapshot_->support);
}

double FluidPressure::of(std::uint32_t particle) const {
  const double p_i = snapshot_->pressure[particle], H = snapshot_->support;
  if (!attracts_ || !(H > 0)) return p_i;
  if (!grid_) list();
  const WendlandC2 kernel = WendlandC2::with_support(static_cast<real>(H));
  const double norm = cohesion_norm(H), tension = material(particle).surface_tension;
  const Eigen::Vector3d x = place_of(*snapshot_, particle);
  double virial = 0;
  grid_->near(x, [&](std::uint32_t k) {
    const std::uint32_t j = index_[k];
    const double r = box_.between(x, position_[k]).norm();
    if (j == particle || r >= H) return;
    const bool fluid = scene_.bodies[scene_.body[j]].type == BodyType::fluid;
    const double p_j = fluid ? snapshot_->pressure[j] : p_i;
    const double strength = fluid ? std::min(tension, material(j).surface_tension) : material(particle).adhesion;
    virial += volume(j) * ((p_i + p_j) * kernel.F(static_cast<real>(r)) * r * r -
                           strength / norm * cohesion_phi(static_cast<real>(r / H)) * r);
  });
  return virial / 6;
}

}  // namespace palp
