#include "sim_server/solver/elastic_store.h"

#include <algorithm>

#include "sim_server/geometry/point_grid.h"
#include "sim_server/physics/gradient_correction.h"
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

}  // namespace

ElasticStore::ElasticStore(const Scene& scene, const Plan& plan) {
  const std::vector<std::uint32_t> particle = elastic_particles(scene, plan);
  const PeriodicBox box = box_of(scene);
  std::vector<Eigen::Vector3d> place(particle.size());
  // rounded as the kernels have it: with corrections of other places torques among particles would not cancel, and a
  // light block a kilometre from the origin would spin ever faster
  for (std::size_t i = 0; i < particle.size(); ++i) place[i] = rounded(scene.position[particle[i]]);
  const double H = plan.elastic_support, reach = kReach * H;
  const PointGrid grid(place, box, H);
  const auto kernel = WendlandC2Of<double>::with_support(H);
  const auto body_of = [&](std::size_t i) -> const Body& { return scene.bodies[scene.body[particle[i]]]; };
  // true for two particles of one elastic body and of all that it is bonded to
  const auto joined = [&](std::size_t i, std::size_t j) {
    const std::uint32_t a = scene.body[particle[i]], b = scene.body[particle[j]];
    const bool both_elastic = scene.bodies[a].type == BodyKind::elastic && scene.bodies[b].type == BodyKind::elastic;
    return a == b || (plan.group[a] == plan.group[b] && !both_elastic);
  };
  const bool paper = plan.method == Method::paper;
  bool flat = false;
  first.push_back(0);
  std::vector<std::uint32_t> near;
  // bonded particles within reach of an elastic one: they are strained, and those next to them feel it
  std::vector<bool> strained(particle.size());
  for (std::uint32_t i = 0; i < particle.size(); ++i) {
    strained[i] = body_of(i).type == BodyKind::elastic;
    grid.near(place[i], [&](std::uint32_t j) {
      if (body_of(j).type == BodyKind::elastic && joined(i, j) && box.between(place[j], place[i]).norm() < reach)
        strained[i] = true;
    });
  }
  for (std::uint32_t i = 0; i < particle.size(); ++i) {
    const std::uint32_t from = particle[i], b = scene.body[from];
    const Body& body = body_of(i);
    rest.push_back(pack(place[i].cast<real>(), static_cast<real>(scene.volume[from])));
    tag.push_back(make_tag(body.type, material_of(scene, plan, b), b));
    u.push_back(pack(Vec3(0, 0, 0), 0));
    v.push_back(pack(scene.velocity[from].cast<real>(), 0));
    rotation.push_back(Quat::Identity());
    near.clear();
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    grid.near(place[i], [&](std::uint32_t j) {
      const Eigen::Vector3d X = box.between(place[j], place[i]);
      const double r = X.norm();
      // forces on a fixed body that no probe asks for need not be complete
      if (!strained[i] && body.type == BodyKind::fixed && !plan.probed[b]) return;
      if (j == i || !joined(i, j) || !(strained[i] || strained[j]) || !(r < reach) || !(r > 0)) return;
      near.push_back(j);
      moment += scene.volume[particle[j]] * kernel.F(r) * X * X.transpose();
    });
    std::sort(near.begin(), near.end());
    neighbor.insert(neighbor.end(), near.begin(), near.end());
    first.push_back(static_cast<std::uint32_t>(neighbor.size()));
    if (paper) continue;
    const GradientCorrection<double> c = gradient_correction(moment, kFlatNeighborhood);
    correction.push_back(c.inverse.cast<real>());
    projection.push_back(c.projection.cast<real>());
    flat = flat || !c.projection.isIdentity(1e-6);
  }
  if (!flat && !plan.tears) projection.clear();
}

}  // namespace palp
