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

// Returns whether the line between two places, the solid's frame, passes through one of the boxes of a solid of boxes.
PALP_HD inline bool passes_a_box(const ContactBody& b, const Piece* piece, const Vec3& x, const Vec3& y) {
  for (std::uint32_t k = b.first; k < b.solid; ++k) {
    real enters = 0, leaves = 1;  // shares of the way from x to y
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

// The thin walls of a scene.
struct WallSight {
  WallViews walls;
  const BodyState* body;
  CellGrid grid;
  real reach;  // of the lists [m]
  real near;   // kSightNear [m]

  // Returns a distance from a particle at x within which no thin wall is, at most the reach of the lists.
  PALP_HD real clear_around(const Vec3& x) const {
    real clear = reach;
    for (std::uint32_t k = 0; k < walls.by.bodies; ++k) {
      const ContactBody& shape = walls.shape[k];
      if (!shape.thin) continue;
      const BodyState& b = body[walls.body[k]];
      const Vec3 y = b.q.toRotationMatrix().transpose() * nearest_image(grid, x - b.x);
      if (outside_bounds(shape, y, clear)) continue;
      clear = min(clear, solid_distance(shape, walls.piece, walls.grid, y).d - near);
    }
    return clear > real(0) ? clear : real(0);
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
