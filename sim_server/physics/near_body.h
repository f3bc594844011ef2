// A solid that acts by its geometry, as a fluid particle beside it sees it (walls.h says what it does).
//
// symbol      meaning                                                                                   unit
// u           velocity of the particle against the solid there; u_t: along its surface                  m/s
// d, n, r     its distance from the solid; normal, outwards; place from the body's centre               m, -, m
// b           (u_t . dn) / |u_t|: by how much the normal turns on the way, over the way                 1/m
// h           1 in a hollow (b < 0); else -(u . n) / (kApproach |u_t|), from 0 to 1                     -
// g_f         g + h b |u_t|^2 n: gravity as what follows the surface feels it                           m/s^2
// nu          viscosity of the particle over its density                                                m^2/s
// l           sqrt(nu / (b |u_t|)) / kLayer where b > 0: how thick the layer is that a bulging surface  m
//             drags along; no less than kLeastLayer dx
// d_d         the distance that the drag has: l at most, and kNearest dx min(1, dx / l) at least        m
//
// Pressure goes on into the solid as it does where fluid flows along the surface, p + rho g_f . s at s from the
// particle: Euler's equation for what is accelerated as it follows the surface. At rest g_f is gravity; around a ball
// of radius R pressure rises outwards by rho |u_t|^2 / R. A wall that does not know this pushes off what comes towards
// it and so is felt as if it were thicker, by a part of a spacing. What leaves a bulging surface again does not follow
// it: a flow that a hand makes comes off near where the body is widest, by a layer along the surface that is thinner
// than a spacing, so that no particle tells. Held all around, balls of three and five spacings have 0.71 and 0.75 of
// their drag at Re 1000 in place of 1.16 and 0.93.
//
// The drag of a solid takes velocity to grow from its surface to the particle in proportion to the distance. Where a
// flow's layer is thinner than a spacing that is wrong in two ways. Particles outside the layer have the velocity of
// the flow there, and drag would be too little (a ball of five spacings has a layer of a third of a spacing at Re
// 1000): they count as if they were at l. 1 / l is what laminar layers have, c sqrt(b |u_t| / nu) with a c from 0.33
// (Blasius, a flat plate at 1 / b from its edge) to 1.3 and more (Homann, where the flow meets a ball). And particles
// that come nearer than half a spacing have a velocity that is a mean over their own size, so that drag would be too
// much: they count as if they were at kNearest. Without the first balls of three spacings at Re 300 and of five at Re
// 1000 have 0.84 and 0.93 of their drag, without the second one of ten at Re 1000 has 1.08.
//
// How the body itself is accelerated is left out: its velocity's changes are known as differences alone, and what turns
// with a light body pushed that so that energy was made (w x (w x r) + 2 w x u in g_f).
#pragma once

#include "sim_server/physics/rigid.h"
#include "sim_server/physics/wall_share.h"

namespace palp {

// Particles whose push on a body is summed at a time. Where there are many, few of them are beside a solid, and lanes
// share out those that are found in a large part; few particles keep more lanes busy by small ones.
inline constexpr std::uint32_t kWallPart = 128, kLargeWallPart = 256, kManyForWalls = 100000;

// A body beside a fluid particle.
struct NearBody {
  bool near;
  Vec3 r;  // the particle's place from the body's centre, world axes [m]
  Vec3 v;  // the body's velocity there; 0 of a fixed one, whose surface moves along itself and does not squeeze [m/s]
  real d;
  Vec3 n;       // world axes
  Vec3 foot;    // the nearest place on the surface, as r
  Vec3 v_foot;  // the body's velocity there
  WallShare wall;
};

PALP_HD inline NearBody not_near() {
  const Vec3 zero(0, 0, 0);
  return {false, zero, zero, 0, zero, zero, zero, {0, zero, zero, 0}};
}

// A body beside a particle, as MeasureWalls keeps it for the stages that follow: what NearBody does not follow from.
struct alignas(16) KeptBody {
  Packed r_d, n_shear, slope_share;
  Vec3 pull;
  std::uint32_t place;  // of the body among those that have a distance field
};
inline constexpr std::uint32_t kKeptBodies = 2;  // by particle; beside more of them the others are found anew

// A particle that passes a solid: its velocity, and the gravity in which it would rest, world axes; its viscosity over
// its density, 0 where its drag is taken in stages, as layers of what is that viscous are not thin.
struct Passing {
  Vec3 v, g;
  real nu;
};

// The gravity and the layer that a flow has which follows a surface.
struct Following {
  Vec3 g;      // g_f, body axes
  real layer;  // l
};

// The length of the way on which a surface's bend is looked for [spacings], and the least cosine between the normals at
// its ends: past that is an edge or an inner corner, where the flow does not follow the surface.
inline constexpr real kBendStep = real(0.5), kLeastTurn = real(0.5);
// The share of its way along a surface by which a flow comes nearer, from where on it follows that. Chosen by what
// balls and ladles feel (tools/results/felt_remaining.md).
inline constexpr real kApproach = real(0.45);
// The c of 1 / l, the least l and the nearest distance of drag [spacings], chosen in the same way.
inline constexpr real kLayer = real(0.6), kLeastLayer = real(0.25), kNearest = real(0.4);
inline constexpr real kNoLayer = real(1e30);  // [m]
inline constexpr real kAtRest = real(1e-12);  // of |u_t|^2 [m^2/s^2]

struct WallViews {
  WallWrenches by;
  const std::uint32_t* body = nullptr;  // the bodies that have a distance field
  const ContactBody* shape = nullptr;   // of each of them
  const Piece* piece = nullptr;
  const NodeGrid* grid = nullptr;
  std::uint32_t part = kWallPart;   // particles in a part
  Packed* slope = nullptr;          // by particle: slope and share of all bodies
  real* rate = nullptr;             // by particle [1/s]
  std::uint32_t* beside = nullptr;  // by particle: how many bodies it is beside
  std::uint32_t* near = nullptr;    // by part: how many of its particles may be beside a body
  KeptBody* kept = nullptr;         // kKeptBodies by particle
  std::uint8_t* open = nullptr;     // by cell: 1 where no fixed body is within the support radius; null: not known
  bool thin = false;                // some have thin walls (wall_sight.h)
  bool nodes = false;               // distances of some are from a lattice's nodes: they may be a spacing too large
};

// The particles of part `index` of `count`.
struct WallRange {
  std::uint32_t begin, end;
};
PALP_HD inline WallRange wall_range(const WallViews& walls, std::uint32_t index, std::uint32_t count) {
  const std::uint32_t begin = index * walls.part;
  return {begin, min(begin + walls.part, count)};
}

// Sets the members of a body that is near which follow from r, d and n.
PALP_HD inline void complete(NearBody& out, const BodyState& body) {
  out.near = true;
  out.foot = out.r - out.d * out.n;
  out.v_foot = body.v + body.w.cross(out.foot);
  out.v = body.kind == BodyKind::fixed ? Vec3(0, 0, 0) : Vec3(body.v + body.w.cross(out.r));
}

PALP_HD inline KeptBody kept_body(const NearBody& b, std::uint32_t place) {
  return {pack(b.r, b.d), pack(b.n, b.wall.shear), pack(b.wall.slope, b.wall.share), b.wall.pull, place};
}
PALP_HD inline NearBody near_body(const KeptBody& kept, const BodyState& body) {
  NearBody out = not_near();
  out.r = kept.r_d.xyz();
  out.d = kept.r_d.w;
  out.n = kept.n_shear.xyz();
  out.wall = {kept.slope_share.w, kept.slope_share.xyz(), kept.pull, kept.n_shear.w};
  complete(out, body);
  return out;
}

// Returns true where no particle at x can be beside a body.
PALP_HD inline bool far_from_body(const WallViews& walls, const CellGrid& grid, const Medium& medium,
                                  const BodyState& body, std::uint32_t k, const Vec3& x) {
  const real far = walls.shape[k].reach + medium.kernel.support;
  return nearest_image(grid, x - body.x).squaredNorm() > far * far;
}

// Returns what a surface is to a particle at y from the body's centre that passes it with the velocity u against it, in
// a gravity of g; all in body axes.
PALP_HD inline Following following(const WallViews& walls, const ContactBody& shape, const Distance& at, real spacing,
                                   const Vec3& y, const Vec3& u, const Vec3& g, real nu) {
  const Following straight{g, kNoLayer};
  const Vec3 u_t = u - u.dot(at.n) * at.n;
  const real speed2 = u_t.squaredNorm();
  if (shape.boxes || !(speed2 > kAtRest)) return straight;  // faces of boxes are flat
  const real speed = Eigen::numext::sqrt(speed2), step = kBendStep * spacing;
  const Vec3 ahead = solid_distance(shape, walls.piece, walls.grid, y + (step / speed) * u_t).n;
  if (!(ahead.dot(at.n) > kLeastTurn)) return straight;
  const real bend = ahead.dot(u_t) / (speed * step);
  const bool bulges = bend > real(0);
  const real holds = bulges ? min(real(1), positive(u.dot(at.n) / (-kApproach * speed))) : real(1);
  const Vec3 felt = g + (holds * bend * speed2) * at.n;
  if (!bulges || !(nu > real(0))) return {felt, kNoLayer};
  const real layer = Eigen::numext::sqrt(nu / (bend * speed)) / kLayer, least = kLeastLayer * spacing;
  return {felt, layer > least ? layer : least};
}

// Returns d_d at the distance d from a surface that drags along a layer.
PALP_HD inline real drag_distance(real d, real layer, real spacing) {
  const real nearest = kNearest * spacing * min(real(1), spacing / layer);
  return min(d > nearest ? d : nearest, layer);
}

// Returns what a body is to a particle at x. passing: the particle; null where neither pull nor drag is asked for.
PALP_HD inline NearBody near_body(const WallViews& walls, const CellGrid& grid, const Medium& medium,
                                  const BodyState& body, std::uint32_t k, const Vec3& x, const Passing* passing) {
  const ContactBody& shape = walls.shape[k];
  if (far_from_body(walls, grid, medium, body, k, x)) return not_near();
  const Vec3 r = nearest_image(grid, x - body.x);
  const Mat3 R = body.q.toRotationMatrix();
  const Vec3 y = R.transpose() * r;
  if (outside_bounds(shape, y, medium.kernel.support)) return not_near();
  const Distance at = solid_distance(shape, walls.piece, walls.grid, y);
  if (!(at.d < medium.kernel.support)) return not_near();
  NearBody out = not_near();
  out.r = r;
  out.d = at.d;
  out.n = R * at.n;
  complete(out, body);
  Following flow{Vec3(0, 0, 0), kNoLayer};
  if (passing != nullptr)
    flow = following(walls, shape, at, medium.spacing, y, R.transpose() * (passing->v - out.v),
                     R.transpose() * passing->g, passing->nu);
  const WallKernel kernel = wall_kernel(medium.kernel, medium.spacing, flow.g);
  const WallShare share = wall_share(shape, walls.piece, walls.grid, kernel, raised(kernel, at, y));
  const real d = shear_distance(kernel, at.d);
  const real shear = share.shear * (d / drag_distance(d, flow.layer, medium.spacing));
  out.wall = {share.share, R * share.slope, R * share.pull, shear};
  return out;
}

// Returns what body k is to particle i at x, as near_body() does, after MeasureWalls.
PALP_HD inline NearBody known_body(const WallViews& walls, const CellGrid& grid, const Medium& medium,
                                   const BodyState& body, std::uint32_t k, std::uint32_t i, const Vec3& x,
                                   const Passing* passing) {
  const std::uint32_t beside = walls.beside[i];
  for (std::uint32_t s = 0; s < kKeptBodies && s < beside; ++s)
    if (walls.kept[i * kKeptBodies + s].place == k) return near_body(walls.kept[i * kKeptBodies + s], body);
  if (beside > kKeptBodies) return near_body(walls, grid, medium, body, k, x, passing);
  return not_near();
}

}  // namespace palp
