#include "sim_server/solver/elastic_store.h"

#include <algorithm>

#include "sim_server/geometry/point_grid.h"
#include "sim_server/physics/gradient_correction.h"
#include "sim_server/solver/elastic_stencil.h"
#include "sim_server/solver/particle_store.h"

namespace palp {
namespace {

// The share of the support radius in which neighbours are listed: one at its very edge weighs nothing, but could be the
// only one that a particle has.
constexpr double kReach = 0.999;

// Returns the index of a body's elastic material: a rigid or static one has that of the first elastic body that is
// bonded to it.
std::uint32_t material_of(const Scene& scene, const Plan& plan, std::uint32_t body) {
  if (scene.bodies[body].type == BodyKind::elastic) return scene.bodies[body].material;
  for (const std::uint32_t b : plan.elastic_bodies)
    if (plan.group[b] == plan.group[body]) return scene.bodies[b].material;
  return scene.bodies[body].material;
}

// Returns the particles of elastic bodies and of those that they are bonded to, by their indices in the scene's order.
std::vector<std::uint32_t> elastic_particles(const Scene& scene, const Plan& plan) {
  std::vector<std::uint32_t> particle(plan.elastic_count);
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    if (plan.force_first[b] >= plan.elastic_count) continue;
    for (std::uint32_t k = 0; k < body.count; ++k) particle[plan.force_first[b] + k] = body.first + k;
  }
  return particle;
}

// The particles at rest, and which of them are neighbours.
struct RestState {
  const Scene& scene;
  const Plan& plan;
  std::vector<std::uint32_t> particle;
  std::vector<Eigen::Vector3d> place;
  PeriodicBox box;
  double reach;
  PointGrid grid;

  RestState(const Scene& of, const Plan& with)
      : scene(of),
        plan(with),
        particle(elastic_particles(of, with)),
        place(places(of, particle)),
        box(box_of(of)),
        reach(kReach * with.elastic_support),
        grid(place, box, with.elastic_support) {}

  // Returns the places as the kernels have them, rounded: with corrections of other places torques among particles
  // would not cancel, and a light block a kilometre from the origin would spin ever faster.
  static std::vector<Eigen::Vector3d> places(const Scene& scene, const std::vector<std::uint32_t>& particle) {
    std::vector<Eigen::Vector3d> out(particle.size());
    for (std::size_t i = 0; i < particle.size(); ++i) out[i] = rounded(scene.position[particle[i]]);
    return out;
  }

  const Body& body_of(std::size_t i) const { return scene.bodies[scene.body[particle[i]]]; }
  Eigen::Vector3d separation(std::size_t i, std::size_t j) const { return box.between(place[j], place[i]); }

  // Returns true for two particles of one elastic body and of all that it is bonded to.
  bool joined(std::size_t i, std::size_t j) const {
    const std::uint32_t a = scene.body[particle[i]], b = scene.body[particle[j]];
    const bool both_elastic = scene.bodies[a].type == BodyKind::elastic && scene.bodies[b].type == BodyKind::elastic;
    return a == b || (plan.group[a] == plan.group[b] && !both_elastic);
  }

  bool elastic(std::size_t i) const { return body_of(i).type == BodyKind::elastic; }

  // Returns which particles are strained: elastic ones, and bonded ones within reach of these, which those next to them
  // feel.
  std::vector<bool> strained() const {
    std::vector<bool> out(particle.size());
    for (std::uint32_t i = 0; i < particle.size(); ++i) {
      out[i] = elastic(i);
      grid.near(place[i], [&](std::uint32_t j) {
        if (elastic(j) && joined(i, j) && separation(i, j).norm() < reach) out[i] = true;
      });
    }
    return out;
  }

  // Returns the neighbours of a particle in the order of their indices.
  std::vector<std::uint32_t> neighbors(std::uint32_t i, const std::vector<bool>& strained) const {
    std::vector<std::uint32_t> out;
    // forces on a fixed body that no probe asks for need not be complete
    const bool idle = body_of(i).type == BodyKind::fixed && !plan.probed[scene.body[particle[i]]];
    if (idle && !strained[i]) return out;
    grid.near(place[i], [&](std::uint32_t j) {
      const double r = separation(i, j).norm();
      if (j == i || !joined(i, j) || !(strained[i] || strained[j])) return;
      if (r < reach && r > 0) out.push_back(j);
    });
    std::sort(out.begin(), out.end());
    return out;
  }
};

// Marks the bonds that neighbours' gradients are not taken from, given those that the particles' own ones are not.
void mark_theirs(const std::vector<std::uint32_t>& first, std::vector<std::uint32_t>& neighbor) {
  const auto index_of = [&](std::uint32_t k) { return ElasticBond{neighbor[k]}.j(); };
  for (std::uint32_t i = 0; i + 1 < first.size(); ++i)
    for (std::uint32_t k = first[i]; k < first[i + 1]; ++k) {
      if (ElasticBond{neighbor[k]}.in_mine()) continue;
      std::uint32_t low = first[index_of(k)], high = first[index_of(k) + 1];  // lists are in the order of indices
      while (low < high) {
        const std::uint32_t middle = low + (high - low) / 2;
        if (index_of(middle) < i)
          low = middle + 1;
        else
          high = middle;
      }
      if (low < first[index_of(k) + 1] && index_of(low) == i) neighbor[low] |= kNotInTheirs;
    }
}

}  // namespace

ElasticStore::ElasticStore(const Scene& scene, const Plan& plan) {
  const RestState at_rest(scene, plan);
  const std::vector<bool> strained = at_rest.strained();
  const auto kernel = WendlandC2Of<double>::with_support(plan.elastic_support);
  const bool paper = plan.method == Method::paper;
  bool flat = false;
  first.push_back(0);
  for (std::uint32_t i = 0; i < at_rest.particle.size(); ++i) {
    const std::uint32_t from = at_rest.particle[i], b = scene.body[from];
    rest.push_back(pack(at_rest.place[i].cast<real>(), static_cast<real>(scene.volume[from])));
    tag.push_back(make_tag(scene.bodies[b].type, material_of(scene, plan, b), b));
    u.push_back(pack(Vec3(0, 0, 0), 0));
    v.push_back(pack(scene.velocity[from].cast<real>(), 0));
    rotation.push_back(Quat::Identity());
    const std::vector<std::uint32_t> near = at_rest.neighbors(i, strained);
    std::vector<RestBond> bonds;
    for (const std::uint32_t j : near) {
      const Eigen::Vector3d X = at_rest.separation(i, j);
      bonds.push_back({X, scene.volume[at_rest.particle[j]] * kernel.F(X.norm()), at_rest.elastic(j)});
    }
    std::vector<bool> counts(near.size(), true);
    if (!paper && takes_balanced_bonds(scene.config.materials[tag.back().material()]))
      counts = at_rest.elastic(i) ? balanced_bonds(bonds, scene.spacing) : bonds_of_clamp(bonds, scene.spacing);
    for (std::size_t k = 0; k < near.size(); ++k) neighbor.push_back(near[k] | (counts[k] ? 0u : kNotInMine));
    first.push_back(static_cast<std::uint32_t>(neighbor.size()));
    if (paper) continue;
    const GradientCorrection<double> c = gradient_correction_of(bonds, counts, kFlatNeighborhood);
    correction.push_back(c.inverse.cast<real>());
    projection.push_back(c.projection.cast<real>());
    flat = flat || !c.projection.isIdentity(1e-6);
  }
  mark_theirs(first, neighbor);
  if (!flat && !plan.tears) projection.clear();
}

}  // namespace palp
