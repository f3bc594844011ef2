#include "sim_server/solver/contact_store.h"

#include <algorithm>
#include <cmath>

#include "sim_server/geometry/contact_shape.h"

namespace palp {
namespace {

constexpr double kStiffest = 0.4;  // kappa
// Not limited by stability: more makes a bounce depend on the moment of arrival, by 4 % of the speed at this.
constexpr double kStiffestImplicit = 1;
// Of kappa + 2 gamma, whose limit is 4: between two movable bodies, and with one on either side, it counts twice.
constexpr double kMostOfLimit = 1.6;

// kappa and gamma for a share of critical damping.
BounceNumbers damped(double zeta, bool implicit) {
  if (implicit) return {kStiffestImplicit, 2 * zeta * std::sqrt(kStiffestImplicit)};
  const double root = std::sqrt(4 * zeta * zeta + kMostOfLimit) - 2 * zeta;
  const double kappa = std::min(kStiffest, root * root);
  return {kappa, 2 * zeta * std::sqrt(kappa)};
}

// Speed after over speed before, of a ball that first is `start` of its step away, in units of mass, step and speed.
double bounce(const BounceNumbers& n, bool implicit, double start) {
  double depth = -start, v = 1;
  for (int step = 0; step < 1000 && !(v < 0 && depth < -1); ++step) {
    const double half = 0.5 * std::abs(v);
    const double mean = depth >= half   ? std::max(0.0, depth)
                        : depth > -half ? std::pow(depth + half, 2) / (4 * half)
                                        : 0;
    const double share = depth >= half ? 1 : depth > -half ? (depth + half) / (2 * half) : 0;
    if (v <= 0 && depth < -half) break;
    const double moved = implicit ? 1 + share * (n.stiffness + n.damping) : 1;
    v -= std::max(0.0, n.stiffness * mean + n.damping * share * v) / moved;
    depth += v;
  }
  return -v;
}

// Over the moments within a step at which it may arrive.
struct Bounces {
  double mean = 0, most = 0;
};

Bounces bounces(const BounceNumbers& n, bool implicit) {
  constexpr int kStarts = 32;
  Bounces all;
  for (int s = 0; s < kStarts; ++s) {
    const double one = bounce(n, implicit, 1 + (s + 0.5) / kStarts);
    all.mean += one / kStarts;
    all.most = std::max(all.most, one);
  }
  return all;
}

Piece to_piece(const ContactPiece& from, std::size_t first_grid) {
  Piece p{};
  p.R = from.pose.linear().cast<real>();
  p.c = from.pose.translation().cast<real>();
  p.low = from.low.cast<real>();
  p.high = from.high.cast<real>();
  p.type = from.type == ShapeType::sphere     ? PieceType::sphere
           : from.type == ShapeType::cylinder ? PieceType::cylinder
           : from.type == ShapeType::mesh     ? PieceType::grid
                                              : PieceType::box;
  p.subtract = from.subtract;
  if (from.grid >= 0) p.grid = static_cast<std::uint32_t>(first_grid + static_cast<std::size_t>(from.grid));
  return p;
}

void add_grid(const DistanceGrid& from, ContactStore& store) {
  NodeGrid g{};
  g.origin = from.origin.cast<real>();
  g.cell = static_cast<real>(from.cell);
  g.inv_cell = static_cast<real>(1 / from.cell);
  std::copy(from.n.begin(), from.n.end(), g.n);
  g.node = nullptr;
  store.grid.push_back(g);
  for (std::size_t k = 0; k < from.distance.size(); ++k)
    store.node.push_back({from.normal[3 * k], from.normal[3 * k + 1], from.normal[3 * k + 2], from.distance[k]});
}

ContactBody add_shape(const Body& body, ContactStore& store) {
  const ContactShape& from = *body.contact;
  ContactBody to{};
  to.R = from.frame.linear().cast<real>();
  to.c = (from.frame.translation() - body.center).cast<real>();
  to.low = from.bounds.min().cast<real>();
  to.high = from.bounds.max().cast<real>();
  to.boxes = from.boxes;
  to.first = to.solid = static_cast<std::uint32_t>(store.piece.size());
  const std::size_t first_grid = store.grid.size();
  for (const ContactPiece& piece : from.pieces) {
    to.solid += piece.subtract ? 0 : 1;
    store.piece.push_back(to_piece(piece, first_grid));
  }
  for (const DistanceGrid& grid : from.grids) add_grid(grid, store);
  to.last = static_cast<std::uint32_t>(store.piece.size());
  to.first_point = static_cast<std::uint32_t>(store.point.size());
  to.points = static_cast<std::uint32_t>(from.points.size());
  for (const ContactPoint& p : from.points)
    store.point.push_back(pack((p.position - body.center).cast<real>(), static_cast<real>(p.radius)));
  double reach = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const auto which = static_cast<Eigen::AlignedBox3d::CornerType>(corner);
    reach = std::max(reach, (from.frame * from.bounds.corner(which) - body.center).norm());
  }
  to.reach = static_cast<real>(reach);
  return to;
}

// Whether a body is a tool in a hand and the other one stays where it is.
bool is_held(const Scene& scene, std::uint32_t tool, const Body& other) {
  return other.type == BodyKind::fixed &&
         std::any_of(scene.proxies.begin(), scene.proxies.end(), [&](const Proxy& p) { return p.body == tool; });
}

}  // namespace

BounceNumbers bounce_numbers(double restitution, bool implicit) {
  const auto is_more = [&](double zeta) {
    const Bounces found = bounces(damped(zeta, implicit), implicit);
    return found.mean > restitution || found.most > 0.999;  // between the starts it may be more
  };
  double low = 0, high = implicit ? 4 : 1.2;
  if (is_more(high)) return damped(high, implicit);
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = (low + high) / 2;
    (is_more(middle) ? low : high) = middle;
  }
  return damped(high, implicit);
}

ContactLaw meet(const MaterialConfig& a, const MaterialConfig& b, bool implicit) {
  const double restitution = std::min(a.restitution, b.restitution);
  const BounceNumbers bounce = bounce_numbers(restitution, implicit);
  ContactLaw law{};
  law.friction = static_cast<real>(std::sqrt(a.friction * b.friction));
  law.kinetic = static_cast<real>(std::sqrt(a.kinetic_friction * b.kinetic_friction));
  law.stiffness = static_cast<real>(bounce.stiffness);
  law.damping = static_cast<real>(bounce.damping);
  law.tangential = static_cast<real>(std::min(kStiffest, bounce.stiffness));
  law.implicit = implicit;
  return law;
}

ContactStore::ContactStore(const Scene& scene, const Plan& plan) : shape_of_(scene.bodies.size(), kNone) {
  Parts parts(scene.bodies.size());
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    if (scene.bodies[b].contact == nullptr) continue;
    shape_of_[b] = static_cast<std::uint32_t>(shape.size());
    shape.push_back(add_shape(scene.bodies[b], *this));
  }
  add_rigid_pairs(scene, plan, parts);
  for (const std::uint32_t b : plan.elastic_bodies)
    add_soft_parts(scene, plan, b, plan.force_first[b], elastic_part, parts);
  first_frozen = static_cast<std::uint32_t>(states);
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b)
    if (plan.changes[b]) add_soft_parts(scene, plan, b, plan.slot_first[b], frozen_part, parts);
  of_body.push_back(0);
  if (held_pairs > 0) held.resize(pair.size(), kNone);
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
      pair.push_back({a, b, shape_of_[a], shape_of_[b], static_cast<std::uint32_t>(states),
                      meet(scene.config.materials[first.material], scene.config.materials[second.material], implicit)});
      states += shape[shape_of_[a]].points + shape[shape_of_[b]].points;
      parts[a].push_back(2 * index);
      parts[b].push_back(2 * index + 1);
    }
  rigid_pairs = static_cast<std::uint32_t>(pair.size());
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b)
    few = few && (scene.bodies[b].type != BodyKind::rigid || parts[b].size() <= 2);
}

void ContactStore::add_soft_parts(const Scene& scene, const Plan& plan, std::uint32_t a, std::uint32_t first,
                                  std::vector<SoftPart>& list, Parts& parts) {
  constexpr std::uint32_t kPart = 256;  // particles: enough for a block of threads, few enough for many blocks
  for (std::uint32_t done = 0; done < scene.bodies[a].count; done += kPart) {
    SoftPart one{first + done, std::min(kPart, scene.bodies[a].count - done), static_cast<std::uint32_t>(pair.size()),
                 0};
    for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
      if (shape_of_[b] == kNone || plan.group[a] == plan.group[b]) continue;
      ContactLaw law = meet(scene.config.materials[scene.bodies[a].material],
                            scene.config.materials[scene.bodies[b].material], false);
      // its own elasticity makes it bounce; the layer that touches is only damped as springs are (rigid.h)
      law.stiffness = real(0.4);
      law.damping = real(0.15);
      law.tangential = law.stiffness;
      parts[b].push_back(2 * static_cast<std::uint32_t>(pair.size()) + 1);
      pair.push_back({a, b, kNone, shape_of_[b], static_cast<std::uint32_t>(states), law});
      states += one.count;
      ++one.pairs;
    }
    if (one.pairs > 0) list.push_back(one);
  }
}

std::vector<NodeGrid> ContactStore::grids_at(const Packed* from) const {
  std::vector<NodeGrid> out = grid;
  for (NodeGrid& g : out) {
    g.node = from;
    from += static_cast<std::size_t>(g.n[0]) * static_cast<std::size_t>(g.n[1]) * static_cast<std::size_t>(g.n[2]);
  }
  return out;
}

}  // namespace palp
