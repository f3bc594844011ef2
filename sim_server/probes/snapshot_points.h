// The particles of a snapshot that have a place, for finding those near one. Host, double precision.
#pragma once

#include "sim_server/geometry/point_grid.h"
#include "sim_server/solver/simulation.h"

namespace palp {

// Returns the place of a particle, x y z [m].
inline Eigen::Vector3d place_of(const Snapshot& s, std::size_t particle) {
  return Eigen::Map<const Eigen::Vector3f>(&s.position[3 * particle]).cast<double>();
}

// Returns whether a particle has left the domain.
inline bool is_inactive(const Snapshot& s, std::size_t particle) {
  return !s.inactive.empty() && s.inactive[particle] != 0;
}

inline const MaterialConfig& material_of(const Scene& scene, std::size_t particle) {
  return scene.config.materials[scene.bodies[scene.body[particle]].material];
}

// Returns the volume that a particle fills at its density [m^3].
inline double volume_of(const Scene& scene, const Snapshot& s, std::size_t particle) {
  const double density = s.density[particle];
  return density > 0 ? scene.volume[particle] * material_of(scene, particle).density / density : scene.volume[particle];
}

class SnapshotPoints {
 public:
  // reach: the radius that near() covers [m]. solids: those too, not only fluids.
  SnapshotPoints(const Scene& scene, const Snapshot& s, double reach, bool solids)
      : box_(box_of(scene)),
        particle_(with_place(scene, s, reach, solids)),
        place_(places(s, particle_)),
        grid_(place_, box_, reach) {}

  // Calls visit(particle, its distance from x) for every one within reach, and for some farther ones; each once.
  template <class Visit>
  void near(const Eigen::Vector3d& x, Visit&& visit) const {
    grid_.near(x, [&](std::uint32_t k) { visit(particle_[k], box_.between(x, place_[k]).norm()); });
  }

 private:
  static std::vector<std::uint32_t> with_place(const Scene& scene, const Snapshot& s, double reach, bool solids) {
    std::vector<std::uint32_t> found;
    for (std::uint32_t i = 0; i < scene.position.size(); ++i) {
      if (is_inactive(s, i) || (!solids && scene.bodies[scene.body[i]].type != BodyKind::fluid)) continue;
      // far strays have no place in the grid and no weight anywhere inside the domain
      const Eigen::Vector3d x = place_of(s, i);
      if (x.allFinite() && x.cwiseAbs().maxCoeff() <= 1e9 * reach) found.push_back(i);
    }
    return found;
  }
  static std::vector<Eigen::Vector3d> places(const Snapshot& s, const std::vector<std::uint32_t>& particles) {
    std::vector<Eigen::Vector3d> x;
    x.reserve(particles.size());
    for (const std::uint32_t i : particles) x.push_back(place_of(s, i));
    return x;
  }

  PeriodicBox box_;
  std::vector<std::uint32_t> particle_;
  std::vector<Eigen::Vector3d> place_;
  PointGrid grid_;
};

}  // namespace palp
