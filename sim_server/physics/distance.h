// Signed distance from solids and its gradient, in the solid's own frame [m]. Boxes, spheres and cylinders are exact,
// so a plane is flat to the last bit; a mesh's distances and normals are stored at the nodes of a lattice (B1 of the
// references: interpolated normals of unit length kink less than a gradient of interpolated distances).
#pragma once

#include <cmath>

#include "sim_server/physics/real.h"

namespace palp {

struct Distance {
  real d;  // below zero inside
  Vec3 n;  // unit, outwards
};

// The nodes of a lattice, x fastest, a cell apart.
struct NodeGrid {
  Vec3 origin;
  real cell, inv_cell;
  int n[3];
  const Packed* node;  // normal, distance
};

enum class PieceType : std::uint32_t { box, sphere, cylinder, grid };

struct Piece {
  Mat3 R;          // rotation to the solid's frame
  Vec3 c;          // origin in the solid's frame
  Vec3 low, high;  // box: corners; sphere: high.x the radius; cylinder: high.x the radius, high.z half the height
  PieceType type;
  bool subtract;
  std::uint32_t grid;
};

// One body's solid.
struct ContactBody {
  Mat3 R;                            // rotation of the solid's frame to body axes
  Vec3 c;                            // origin of the solid's frame, from the centre of mass in body axes
  Vec3 low, high;                    // bounds in the solid's frame
  real reach;                        // largest distance of the solid from the centre of mass
  bool thin;                         // it has walls thinner than the support radius of fluids (wall_sight.h)
  bool boxes;                        // its pieces are boxes that fill it, then boxes that fill all the rest of space
  std::uint32_t first, solid, last;  // boxes: pieces [first, solid) fill it, [solid, last) the rest; else [first, last)
                                     // are added and subtracted in order
  std::uint32_t first_point, points;
  std::uint32_t first_round, rounds;
};

// A circle of a body's surface, in body axes about the centre of mass. Its points stand evenly around it, and each
// moves within its sector to where the circle comes nearest to the other solid: so a body rolls on one point a circle,
// and no distance between points is felt.
struct Round {
  Vec3 center;
  Vec3 axis, zero;  // where its first point is; unit, normal to each other
  real reach;       // largest distance of the surface from the center
  real points;
};

// A point of a body's surface: the middle of a ball inside that touches it, about the centre of mass, body axes, and
// that ball's radius. round: index of the circle that it is one of the points of, kNone.
struct SurfacePoint {
  Packed ball;
  std::uint32_t round;
};

// Returns the way across a circle against n, a unit normal in body axes, and its length, the sine of the angle by which
// the circle leans; not normalized.
PALP_HD inline Vec3 across(const Round& round, const Vec3& n) { return n.dot(round.axis) * round.axis - n; }

// A circle that leans by less than this, as a sine, lies flat on the other solid, and none of its points is the
// nearest.
inline constexpr real kLiesFlat = real(1e-3);

// Returns the place of a point that is as far around the circle from the sector that faces against n as `place` is from
// the first. So a point keeps its memory of the contact while the body rolls on.
PALP_HD inline Vec3 counted_from(const Round& round, const Vec3& n, const Vec3& place) {
  const Vec3 to = across(round, n), side = round.axis.cross(round.zero), arm = place - round.center;
  if (!(to.squaredNorm() > kLiesFlat * kLiesFlat)) return place;
  const real sector = real(6.2831853071795865) / round.points;
  const real turn = sector * Eigen::numext::round(std::atan2(to.dot(side), to.dot(round.zero)) / sector);
  const real c = Eigen::numext::cos(turn), s = Eigen::numext::sin(turn);
  const real x = arm.dot(round.zero), y = arm.dot(side);
  return round.center + (c * x - s * y) * round.zero + (s * x + c * y) * side;
}

// Returns where in its sector the point at `place` comes nearest to a solid with the normal n there.
PALP_HD inline Vec3 nearest_in_sector(const Round& round, const Vec3& n, const Vec3& place) {
  const Vec3 to = across(round, n), arm = place - round.center;
  const real size = to.norm(), radius = arm.norm();
  // sectors overlap by a hundredth, or rounding would leave gaps between them
  const real least = Eigen::numext::cos(real(1.01) * real(3.14159265358979324) / round.points);
  if (!(size > kLiesFlat) || !(arm.dot(to) > least * radius * size)) return place;
  return round.center + (radius / size) * to;
}

// Returns true for a point y, in body axes from the centre of mass, that is more than margin outside the bounds along
// an axis of the solid's frame.
PALP_HD inline bool outside_bounds(const ContactBody& shape, const Vec3& y, real margin) {
  const Vec3 z = shape.R.transpose() * (y - shape.c);
  for (int a = 0; a < 3; ++a)
    if (z[a] < shape.low[a] - margin || z[a] > shape.high[a] + margin) return true;
  return false;
}

// Returns true where the bounds of two solids, the second at x from the first, are more than margin apart along an axis
// of the first one's frame. x leads from one centre of mass to the other; R and R_other turn body axes to those of x.
PALP_HD inline bool bounds_apart(const ContactBody& shape, const Mat3& R, const ContactBody& other, const Mat3& R_other,
                                 const Vec3& x, real margin) {
  const Mat3 to = shape.R.transpose() * R.transpose(), turn = to * R_other * other.R;
  const Vec3 middle = real(0.5) * (other.low + other.high), half = real(0.5) * (other.high - other.low);
  const Vec3 z = to * (x + R_other * other.c) - shape.R.transpose() * shape.c + turn * middle;
  for (int a = 0; a < 3; ++a) {
    const real extent = turn.row(a).cwiseAbs().dot(half) + margin;
    if (z[a] + extent < shape.low[a] || z[a] - extent > shape.high[a]) return true;
  }
  return false;
}

PALP_HD inline Distance box_distance(const Vec3& x, const Vec3& low, const Vec3& high) {
  Vec3 q, side, out;
  int axis = 0;
  for (int a = 0; a < 3; ++a) {
    const real below = low[a] - x[a], above = x[a] - high[a];
    q[a] = below > above ? below : above;
    side[a] = below > above ? real(-1) : real(1);
    out[a] = q[a] > real(0) ? q[a] : real(0);
    if (q[a] > q[axis]) axis = a;
  }
  if (!(q[axis] > real(0))) {
    Vec3 n(0, 0, 0);
    n[axis] = side[axis];
    return {q[axis], n};
  }
  const real d = out.norm();
  return {d, out.cwiseProduct(side) / d};
}

PALP_HD inline Distance sphere_distance(const Vec3& x, real radius) {
  const real r = x.norm();
  return {r - radius, r > real(0) ? Vec3(x / r) : Vec3(0, 0, 1)};
}

PALP_HD inline Distance cylinder_distance(const Vec3& x, real radius, real half) {
  const real r = Eigen::numext::sqrt(x.x() * x.x() + x.y() * x.y());
  const real side = x.z() < real(0) ? real(-1) : real(1);
  const real across = r - radius, along = side * x.z() - half;
  const Vec3 outward = r > real(0) ? Vec3(x.x() / r, x.y() / r, 0) : Vec3(1, 0, 0);
  if (across > real(0) && along > real(0)) {
    const real d = Eigen::numext::sqrt(across * across + along * along);
    return {d, (across * outward + along * side * Vec3(0, 0, 1)) / d};
  }
  if (across > along) return {across, outward};
  return {along, Vec3(0, 0, side)};
}

// Returns the distance that a lattice stores; past its nodes that at the nearest point of the lattice, with the way
// there added.
PALP_HD inline Distance grid_distance(const NodeGrid& g, const Vec3& x) {
  int at[3];
  real f[3];
  Vec3 past(0, 0, 0);
  for (int a = 0; a < 3; ++a) {
    const real t = (x[a] - g.origin[a]) * g.inv_cell, most = real(g.n[a] - 1);
    const real inside = t > real(0) ? (t < most ? t : most) : real(0);
    past[a] = (t - inside) * g.cell;
    at[a] = static_cast<int>(inside);
    if (at[a] > g.n[a] - 2) at[a] = g.n[a] - 2;
    f[a] = inside - real(at[a]);
  }
  Vec3 n(0, 0, 0);
  real d = 0;
  for (int c = 0; c < 8; ++c) {
    const int i = c & 1, j = (c >> 1) & 1, k = c >> 2;
    const real w = (i ? f[0] : 1 - f[0]) * (j ? f[1] : 1 - f[1]) * (k ? f[2] : 1 - f[2]);
    const Packed p = g.node[(std::size_t(at[2] + k) * g.n[1] + at[1] + j) * g.n[0] + at[0] + i];
    n += w * p.xyz();
    d += w * p.w;
  }
  const real size = n.norm();
  n = size > real(0) ? Vec3(n / size) : Vec3(0, 0, 1);
  const real gap = past.norm();
  if (gap > real(0)) {
    const Vec3 to = past + (d > real(0) ? d : real(0)) * n;
    d = to.norm();
    n = to / d;
  }
  return {d, n};
}

PALP_HD inline Distance piece_distance(const Piece& p, const NodeGrid* grids, const Vec3& x) {
  const Vec3 y = p.R.transpose() * (x - p.c);
  Distance out;
  if (p.type == PieceType::box)
    out = box_distance(y, p.low, p.high);
  else if (p.type == PieceType::sphere)
    out = sphere_distance(y, p.high.x());
  else if (p.type == PieceType::cylinder)
    out = cylinder_distance(y, p.high.x(), p.high.z());
  else
    out = grid_distance(grids[p.grid], y);
  out.n = p.R * out.n;
  return out;
}

// Returns the distance of a body's solid; y and the result are in the solid's frame. piece: null, or gets the index of
// the piece whose surface is nearest.
PALP_HD inline Distance distance_in_frame(const ContactBody& b, const Piece* pieces, const NodeGrid* grids,
                                          const Vec3& y, std::uint32_t* piece = nullptr) {
  Distance best{real(1e30), Vec3(0, 0, 1)};
  const auto take = [&](const Distance& one, std::uint32_t k) {
    best = one;
    if (piece != nullptr) *piece = k;
  };
  if (b.boxes) {
    for (std::uint32_t k = b.first; k < b.solid; ++k) {
      const Distance one = box_distance(y, pieces[k].low, pieces[k].high);
      if (one.d < best.d) take(one, k);
    }
    // inside the nearest way out leads to the nearest of the boxes that are empty
    if (!(best.d > real(0))) {
      best.d = real(1e30);
      for (std::uint32_t k = b.solid; k < b.last; ++k) {
        const Distance one = box_distance(y, pieces[k].low, pieces[k].high);
        if (one.d < best.d) take(one, k);
      }
      best = {best.d > real(0) ? -best.d : real(0), -best.n};
    }
  } else {
    for (std::uint32_t k = b.first; k < b.last; ++k) {
      const Distance one = piece_distance(pieces[k], grids, y);
      if (pieces[k].subtract) {
        if (-one.d > best.d) take({-one.d, -one.n}, k);
      } else if (one.d < best.d) {
        take(one, k);
      }
    }
  }
  return best;
}

// Returns the distance of a body's solid; x and the result are in body axes about the centre of mass.
PALP_HD inline Distance solid_distance(const ContactBody& b, const Piece* pieces, const NodeGrid* grids,
                                       const Vec3& x) {
  Distance best = distance_in_frame(b, pieces, grids, b.R.transpose() * (x - b.c));
  best.n = b.R * best.n;
  return best;
}

}  // namespace palp
