#include "sim_server/solver/contact_store.h"

#include <algorithm>

#include "sim_server/geometry/contact_shape.h"
#include "sim_server/solver/constants.h"

namespace palp {
namespace {

// Adds the points of a body's surface, and its circles.
void add_points(const Body& body, ContactBody& to, ContactStore& store) {
  const ContactShape& from = *body.contact;
  to.first_point = static_cast<std::uint32_t>(store.point.size());
  to.points = static_cast<std::uint32_t>(from.points.size());
  to.first_round = static_cast<std::uint32_t>(store.round.size());
  to.rounds = static_cast<std::uint32_t>(from.rounds.size());
  for (const ContactPoint& p : from.points)
    store.point.push_back({pack((p.position - body.center).cast<real>(), static_cast<real>(p.radius)),
                           p.round < 0 ? kNone : to.first_round + static_cast<std::uint32_t>(p.round)});
  for (const ContactRound& r : from.rounds)
    store.round.push_back({(r.center - body.center).cast<real>(), r.axis.cast<real>(), r.zero.cast<real>(),
                           static_cast<real>(r.reach), static_cast<real>(r.points)});
}

// Returns true when a body is a tool in a hand and the other one is fixed.
bool is_held(const Scene& scene, std::uint32_t tool, const Body& other) {
  return other.type == BodyKind::fixed &&
         std::any_of(scene.proxies.begin(), scene.proxies.end(), [&](const Proxy& p) { return p.body == tool; });
}

}  // namespace

ContactStore::ContactStore(const Scene& scene, const Plan& plan)
    : SolidShapes(solid_shapes(scene)), shape_of_(scene.bodies.size(), kNone) {
  Parts parts(scene.bodies.size());
  for (std::uint32_t k = 0; k < shaped.size(); ++k) {
    shape_of_[shaped[k]] = k;
    add_points(scene.bodies[shaped[k]], shape[k], *this);
  }
  if (plan.geometry || plan.heat_walls)
    add_profiles(FluidKernelOf<double>::with_support(plan.support, scene.spacing), *this);
  if (plan.geometry) mark_thin(scene, plan.support, *this);
  add_rigid_pairs(scene, plan, parts);
  first_soft = static_cast<std::uint32_t>(states);
  for (const std::uint32_t b : plan.elastic_bodies)
    add_soft_parts(scene, plan, b, plan.force_first[b], elastic_part, parts);
  elastic_states = states - first_soft;
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b)
    if (plan.changes[b]) add_soft_parts(scene, plan, b, plan.slot_first[b], frozen_part, parts);
  of_body.push_back(0);
  if (held_pairs > 0) held.resize(rigid_pairs, kNone);
  for (const std::vector<std::uint32_t>& list : parts) {
    part.insert(part.end(), list.begin(), list.end());
    of_body.push_back(static_cast<std::uint32_t>(part.size()));
  }
}

void ContactStore::add_rigid_pairs(const Scene& scene, const Plan& plan, Parts& parts) {
  for (std::uint32_t a = 0; a < scene.bodies.size(); ++a)
    for (std::uint32_t b = a + 1; b < scene.bodies.size(); ++b) {
      const Body &first = scene.bodies[a], &second = scene.bodies[b];
      if (shape_of_[a] == kNone || shape_of_[b] == kNone || plan.group[a] == plan.group[b]) continue;
      if (first.type == BodyKind::fixed && second.type == BodyKind::fixed) continue;
      const auto index = static_cast<std::uint32_t>(pair.size());
      const bool implicit = is_held(scene, a, second) || is_held(scene, b, first);
      if (implicit) {
        held.resize(index + 1, kNone);
        held[index] = held_pairs++;
      }
      pair.push_back(
          {a, b, shape_of_[a], shape_of_[b], static_cast<std::uint32_t>(states),
           contact_law(scene.config.materials[first.material], scene.config.materials[second.material], implicit)});
      for (const ContactBody& one : {shape[shape_of_[a]], shape[shape_of_[b]]}) states += one.points + one.rounds;
      parts[a].push_back(2 * index);
      parts[b].push_back(2 * index + 1);
    }
  rigid_pairs = static_cast<std::uint32_t>(pair.size());
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b)
    single_pass = single_pass && (scene.bodies[b].type != BodyKind::rigid || parts[b].size() <= 2);
}

void ContactStore::add_soft_parts(const Scene& scene, const Plan& plan, std::uint32_t a, std::uint32_t first,
                                  std::vector<SoftPart>& list, Parts& parts) {
  constexpr std::uint32_t kPart = 256;  // particles: enough for a block of threads, few enough for many blocks
  std::vector<ContactLaw> laws;         // with each body: to make one takes long
  for (const Body& other : scene.bodies)
    laws.push_back(
        soft_contact_law(scene.config.materials[scene.bodies[a].material], scene.config.materials[other.material]));
  const Body& of = scene.bodies[a];
  const Quat lattice = of.lattice ? Quat((of.orientation * *of.lattice).cast<real>()) : Quat(0, 0, 0, 0);
  for (std::uint32_t done = 0; done < of.count; done += kPart) {
    SoftPart one{first + done, std::min(kPart, of.count - done), static_cast<std::uint32_t>(pair.size()), 0, lattice};
    for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
      if (shape_of_[b] == kNone || plan.group[a] == plan.group[b]) continue;
      parts[b].push_back(2 * static_cast<std::uint32_t>(pair.size()) + 1);
      pair.push_back({a, b, kNone, shape_of_[b], static_cast<std::uint32_t>(states), laws[b]});
      states += one.count;
      ++one.pairs;
      elastic_on_rigid = elastic_on_rigid || (!plan.changes[a] && scene.bodies[b].type == BodyKind::rigid);
    }
    if (one.pairs > 0) list.push_back(one);
  }
}

}  // namespace palp
