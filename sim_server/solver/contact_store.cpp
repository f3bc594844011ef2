#include "sim_server/solver/contact_store.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "sim_server/geometry/contact_shape.h"
#include "sim_server/physics/wall_sight.h"
#include "sim_server/solver/constants.h"
#include "sim_server/solver/cylinder_profile.h"

namespace palp {
namespace {

// Gives each cylinder the profile of its shares, which those of one radius have in common.
void add_profiles(const FluidKernelOf<double>& kernel, ContactStore& store) {
  const double support = kernel.support;
  std::map<real, std::uint32_t> of_radius;
  for (Piece& piece : store.piece) {
    if (piece.type != PieceType::cylinder) continue;
    const real radius = piece.high.x();
    const auto [found, first] = of_radius.try_emplace(radius, static_cast<std::uint32_t>(store.grid.size()));
    piece.grid = found->second;
    if (!first) continue;
    const double cell = (radius + support) / kProfileParts;
    store.grid.push_back(
        {Vec3(0, 0, 0), static_cast<real>(cell), static_cast<real>(1 / cell), {kProfileParts + 1, 1, 1}, nullptr});
    const std::vector<Packed> nodes = cylinder_profile(radius, kernel);
    store.node.insert(store.node.end(), nodes.begin(), nodes.end());
  }
}

// Adds the solid of a body with the points and rounds of its surface.
void add_shape(const Body& body, ContactStore& store) {
  const ContactShape& from = *body.contact;
  ContactBody& to = store.add_solid(body);
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

// Moves the faces of a fixed body that lie on the ends of periodic axes past these: its images go on there.
void reach_past_periods(const Scene& scene, const Body& body, ContactBody& shape, std::vector<Piece>& pieces) {
  if (body.type != BodyKind::fixed) return;
  const Mat3 R = body.orientation.toRotationMatrix().cast<real>() * shape.R;
  const Vec3 origin =
      (body.position + body.orientation * body.center).cast<real>() + Vec3(body.orientation.cast<real>() * shape.c);
  const auto bit = static_cast<real>(1e-3 * scene.spacing);
  // moves `at`, the coordinate along an axis of a frame at `from`, if it is that of an end
  const auto move = [&](const Vec3& axis, const Vec3& from, real& at) {
    for (int a = 0; a < 3; ++a) {
      if (!scene.config.periodic[static_cast<std::size_t>(a)] || std::abs(axis[a]) < real(0.999999)) continue;
      const auto low = static_cast<real>(scene.bounds_min[a]), high = static_cast<real>(scene.bounds_max[a]);
      const real place = from[a] + axis[a] * at;
      if (std::abs(place - low) < bit) at -= axis[a] * (high - low);
      if (std::abs(place - high) < bit) at += axis[a] * (high - low);
    }
  };
  for (std::uint32_t k = shape.first; k < shape.last; ++k) {
    Piece& p = pieces[k];
    const Vec3 from = origin + R * p.c;
    if (p.type == PieceType::cylinder) {
      real low = -p.high.z(), high = p.high.z();
      const Vec3 axis = R * p.R.col(2);
      move(axis, from, low);
      move(axis, from, high);
      p.c += real(0.5) * (low + high) * p.R.col(2);
      p.high.z() = real(0.5) * (high - low);
    }
    for (int a = 0; a < 3 && p.type == PieceType::box; ++a) {
      move(R * p.R.col(a), from, p.low[a]);
      move(R * p.R.col(a), from, p.high[a]);
    }
  }
  const Vec3 size = shape.high - shape.low;
  for (int a = 0; a < 3; ++a) {
    move(R.col(a), origin, shape.low[a]);
    move(R.col(a), origin, shape.high[a]);
  }
  shape.reach += (shape.high - shape.low - size).norm();
}

// Calls f(place, normal) for places on a surface, no farther apart than `apart` [m], and at least one on each triangle.
template <class F>
void for_each_place(const SurfaceMesh& surface, double apart, F&& f) {
  constexpr double kMostParts = 64;  // of an edge
  for (const auto& t : surface.triangles) {
    const Eigen::Vector3d &a = surface.vertices[t[0]], b = surface.vertices[t[1]] - a, c = surface.vertices[t[2]] - a;
    const Eigen::Vector3d normal = b.cross(c).normalized();
    const double parts = std::clamp(std::ceil(std::max(b.norm(), c.norm()) / apart), 1.0, kMostParts);
    for (double i = 0; i < parts; ++i)
      for (double j = 0; i + j < parts; ++j)
        f(Eigen::Vector3d(a + (i + 1.0 / 3) / parts * b + (j + 1.0 / 3) / parts * c), normal);
  }
}

// Returns whether a body has walls through which fluid particles would see each other.
bool is_thin(const Body& body, const ContactBody& shape, const Scene& scene, double support, const ContactStore& store,
             const std::vector<NodeGrid>& grids) {
  const auto near = static_cast<real>(kSightNear * scene.spacing);
  const Eigen::Isometry3d to_solid = body.contact->frame.inverse();
  // fluids keep as far off a surface as the guard reaches, so that those beside a thicker wall do not reach through it
  const double deepest = support - 2 * double(kGuardReach) * scene.spacing;
  bool thin = false;
  for_each_place(body.surface, support / 2, [&](const Eigen::Vector3d& at, const Eigen::Vector3d& normal) {
    const Vec3 n = (to_solid.linear() * normal).cast<real>(), x = (to_solid * at).cast<real>();
    for (int k = 1; k <= 4 && !thin; ++k) {
      const Vec3 behind = x - real(0.25 * k * deepest) * n;  // within the wall nothing looks out of it
      thin = distance_in_frame(shape, store.piece.data(), grids.data(), behind).d > real(0) &&
             blocks_sight(shape, store.piece.data(), grids.data(), x + real(0.1 * scene.spacing) * n, behind, near);
    }
  });
  return thin;
}

// Returns true when a body is a tool in a hand and the other one is fixed.
bool is_held(const Scene& scene, std::uint32_t tool, const Body& other) {
  return other.type == BodyKind::fixed &&
         std::any_of(scene.proxies.begin(), scene.proxies.end(), [&](const Proxy& p) { return p.body == tool; });
}

}  // namespace

ContactStore::ContactStore(const Scene& scene, const Plan& plan) : shape_of_(scene.bodies.size(), kNone) {
  Parts parts(scene.bodies.size());
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    if (scene.bodies[b].contact == nullptr) continue;
    shape_of_[b] = static_cast<std::uint32_t>(shape.size());
    shaped.push_back(b);
    add_shape(scene.bodies[b], *this);
    reach_past_periods(scene, scene.bodies[b], shape.back(), piece);
  }
  if (plan.geometry || plan.heat_walls)
    add_profiles(FluidKernelOf<double>::with_support(plan.support, scene.spacing), *this);
  if (plan.geometry) {
    const std::vector<NodeGrid> grids = grids_at(node.data());
    for (std::size_t k = 0; k < shape.size(); ++k)
      shape[k].thin = is_thin(scene.bodies[shaped[k]], shape[k], scene, plan.support, *this, grids);
  }
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
