// Which fluid particles do not see each other, because a thin wall stands between them.
//
// Behind a wall all is wall (wall_share.h), so what lies on the other side of a thin one must not count as fluid, too.
// A solid that is narrow in two directions, a stick or a ball, counts by what it fills, and particles beside it see
// each other through it as past it. So a wall blocks where the line of sight crosses two faces that look away from each
// other, unless both are those of round shapes that are added, and, where a face is flat, both particles stand before
// the faces and not beside their edges.
#pragma once

#include "sim_server/physics/walls.h"

namespace palp {

inline constexpr double kSightNear = 0.01;  // how near to a surface a line of sight meets it [spacings]

// Where a line of sight meets a solid.
struct SightHit {
  bool met;
  Vec3 at, n;           // solid's frame
  std::uint32_t piece;  // whose surface it is
};

// Returns where the line from a to b enters a solid, the solid's frame, by steps of the distance from it. near: how
// near to the surface it is met.
PALP_HD inline SightHit first_hit(const ContactBody& b, const Piece* piece, const NodeGrid* grid, const Vec3& from,
                                  const Vec3& to, real near) {
  constexpr int kMostSteps = 64;
  const real length = (to - from).norm();
  SightHit hit{false, from, Vec3(0, 0, 0), 0};
  if (!(length > real(0))) return hit;
  const Vec3 along = (to - from) / length;
  real t = 0;
  for (int step = 0; step < kMostSteps && t < length; ++step) {
    hit.at = from + t * along;
    const Distance at = distance_in_frame(b, piece, grid, hit.at, &hit.piece);
    if (at.d < near && at.n.dot(along) < real(0)) {
      hit.n = at.n;
      hit.met = true;
      return hit;
    }
    t += at.d > near ? at.d : near;
  }
  return hit;
}

// Returns whether the surface is flat where a line of sight meets it.
PALP_HD inline bool is_flat(const Piece& p, const Vec3& n) {
  return p.type == PieceType::box ||
         (p.type == PieceType::cylinder && Eigen::numext::abs((p.R.transpose() * n).z()) > real(0.5));
}

// Returns whether two places, the solid's frame, lie on the same side of a box, past one of its faces.
PALP_HD inline bool same_side(const Piece& box, const Vec3& x, const Vec3& y) {
  for (int a = 0; a < 3; ++a)
    if ((x[a] < box.low[a] && y[a] < box.low[a]) || (x[a] > box.high[a] && y[a] > box.high[a])) return true;
  return false;
}

// Returns whether the line between two places, the solid's frame, passes through one of the boxes of a solid of boxes.
PALP_HD inline bool passes_a_box(const ContactBody& b, const Piece* piece, const Vec3& x, const Vec3& y) {
  for (std::uint32_t k = b.first; k < b.solid; ++k) {
    if (same_side(piece[k], x, y)) continue;  // as most are, without a division
    real enters = 0, leaves = 1;              // shares of the way from x to y
    for (int a = 0; a < 3; ++a) {
      const real low = piece[k].low[a] - x[a], high = piece[k].high[a] - x[a], way = y[a] - x[a];
      if (way == real(0)) {
        if (low > real(0) || high < real(0)) leaves = real(-1);
        continue;
      }
      const real first = (way > real(0) ? low : high) / way, last = (way > real(0) ? high : low) / way;
      enters = first > enters ? first : enters;
      leaves = last < leaves ? last : leaves;
    }
    if (enters <= leaves) return true;
  }
  return false;
}

// Returns whether a solid blocks the sight between two places, the solid's frame.
PALP_HD inline bool blocks_sight(const ContactBody& b, const Piece* piece, const NodeGrid* grid, const Vec3& x,
                                 const Vec3& y, real near) {
  if (b.boxes && !passes_a_box(b, piece, x, y)) return false;
  const SightHit a = first_hit(b, piece, grid, x, y, near);
  if (!a.met) return false;
  const SightHit c = first_hit(b, piece, grid, y, x, near);
  if (!c.met || !(a.n.dot(c.n) < real(-0.5))) return false;
  const bool flat_a = b.boxes || is_flat(piece[a.piece], a.n), flat_c = b.boxes || is_flat(piece[c.piece], c.n);
  const auto fills = [&](std::uint32_t k) { return piece[k].type != PieceType::grid && !piece[k].subtract; };
  if (!flat_a && !flat_c && fills(a.piece) && fills(c.piece)) return false;
  const auto before = [&](const SightHit& face, const Vec3& eye) {
    const Vec3 foot = eye - (eye - face.at).dot(face.n) * face.n;
    return distance_in_frame(b, piece, grid, foot).d < real(2) * near;
  };
  return !(flat_a && !before(a, x)) && !(flat_c && !before(c, y));
}

// Where all particles are in the sight of one: nearer than the radius, or within a box along the world's axes, which is
// given by the ways from the particle to its corners; empty where low is above high.
struct ClearSpace {
  real radius;  // [m]
  Vec3 low, high;

  // Returns whether it has what lies at -x_ij from the particle.
  PALP_HD bool holds(const Vec3& x_ij) const {
    if (x_ij.squaredNorm() < radius * radius) return true;
    for (int a = 0; a < 3; ++a)
      if (!(low[a] <= -x_ij[a] && -x_ij[a] <= high[a])) return false;
    return true;
  }
};
PALP_HD inline ClearSpace all_clear() { return {real(1e18), Vec3(0, 0, 0), Vec3(0, 0, 0)}; }

// Leaves of a clear space what lies in one of the boxes that fill all but a solid of boxes, that with a particle at x,
// the solid's frame. R: from there to the world's axes; nothing is left where it turns, or the particle is in none.
PALP_HD inline void keep_room(const ContactBody& b, const Piece* piece, const Mat3& R, const Vec3& x,
                              ClearSpace& clear) {
  std::uint32_t k = b.boxes && R.isIdentity(real(1e-6)) ? b.solid : b.last;
  while (k < b.last && !WallShape::within(piece[k], x)) ++k;
  for (int a = 0; a < 3; ++a) {
    clear.low[a] = k < b.last ? -min(-clear.low[a], x[a] - piece[k].low[a]) : real(1);
    clear.high[a] = k < b.last ? min(clear.high[a], piece[k].high[a] - x[a]) : real(-1);
  }
}

// The thin walls of a scene.
struct WallSight {
  WallViews walls;
  const BodyState* body;
  CellGrid grid;
  real reach;  // of the lists [m]
  real near;   // kSightNear [m]

  // Returns where around a particle at x no thin wall is, as far as lists reach.
  PALP_HD ClearSpace clear_around(const Vec3& x) const {
    const Vec3 far(reach, reach, reach);
    ClearSpace clear{reach, -far, far};
    for (std::uint32_t k = 0; k < walls.by.bodies; ++k) {
      const ContactBody& shape = walls.shape[k];
      if (!shape.thin) continue;
      const BodyState& b = body[walls.body[k]];
      const Mat3 R = b.q.toRotationMatrix();
      const Vec3 y = R.transpose() * nearest_image(grid, x - b.x);
      if (outside_bounds(shape, y, reach)) continue;
      const Vec3 z = shape.R.transpose() * (y - shape.c);
      clear.radius = min(clear.radius, distance_in_frame(shape, walls.piece, walls.grid, z).d - near);
      keep_room(shape, walls.piece, R * shape.R, z, clear);
    }
    if (!(clear.radius > real(0))) clear.radius = 0;
    return clear;
  }

  // Returns whether no thin wall stands between particles at x and at x - x_ij.
  PALP_HD bool open(const Vec3& x, const Vec3& x_ij) const {
    const real r = x_ij.norm();
    for (std::uint32_t k = 0; k < walls.by.bodies; ++k) {
      const ContactBody& shape = walls.shape[k];
      if (!shape.thin) continue;
      const BodyState& b = body[walls.body[k]];
      const Mat3 R = b.q.toRotationMatrix();
      const Vec3 y = R.transpose() * nearest_image(grid, x - b.x);
      if (outside_bounds(shape, y, r)) continue;
      const Vec3 from = shape.R.transpose() * (y - shape.c), to = from - shape.R.transpose() * (R.transpose() * x_ij);
      if (blocks_sight(shape, walls.piece, walls.grid, from, to, near)) return false;
    }
    return true;
  }
};

}  // namespace palp
