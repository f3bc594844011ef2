// The share of a solid in the sums over the neighbours of a fluid particle beside it, from the solid's geometry alone:
// the integrals of the kernel over the space that the solid fills, as if that were full of particles.
//
// symbol   meaning                                                                          unit
// s        from the particle to a place in the solid                                        m
// share    int W ds, 1/2 at a plane                                                         -
// slope    -int F s ds = -grad share: out of the solid                                      1/m
// pull     int F s (s . a) ds for an acceleration a                                         that of a
// shear    int F |s . n| ds / d: what the velocity v of the particle against the solid's    1/m^2
//          is multiplied by where that grows in proportion to the distance from it
// d, n     distance of the particle from a face of the solid, below 0 inside; normal, outwards
// k        half the divergence of n: 1 / r for a ball, half of that for a cylinder, 0 for a plane, below 0 in a bore
//
// For the kernels of fluids and a plane or a ball all of these are polynomials (smoothing.h). The plane's part is
// summed over layers a spacing apart, the first half a spacing beneath the surface, in place of the integral: a lattice
// of fluid that ends half a spacing above the surface then is in balance from the start. Solids of several
// faces are put together from their faces: what two solids A and B have in common gets the product of the shares, which
// is exact for a kernel that is a product along the normals and within 0.01 for these, at right angles. What a
// solid does not fill gets the complement. So every corner, edge, rim and hole follows from the solid's own shapes.
//
// A face that the particle does not see, since solid lies before it, does not count: behind a wall all is wall, however
// thin it is. So a wall of any thickness acts as a thick one on either side.
#pragma once

#include "sim_server/physics/distance.h"

namespace palp {

struct WallShare {
  real share;
  Vec3 slope, pull;
  real shear;
};

// The kernel that shares are computed for, and the acceleration of `pull` in the axes of the solid.
struct WallKernel {
  FluidKernel of;  // the support radius H in it
  real spacing;    // dx
  real least;      // the distance below which shear grows no more [m]
  real reach;      // length by which two faces may miss each other and still touch [m]
  Vec3 a;
};

// Returns the kernel that shares are computed for, for an acceleration of `pull`.
PALP_HD inline WallKernel wall_kernel(const FluidKernel& of, real spacing, const Vec3& a) {
  return {of, spacing, real(0.25) * spacing, real(0.01) * spacing, a};
}

// Returns the place for which a particle at x asks wall_share(), at the distance `at` from the solid. One that has got
// beneath a surface, by half a spacing at most, feels what it would on it: from within it sees no face, and a wall that
// neither resists it nor drags it lets go of it. What lies deeper is the guard's alone (walls.h).
PALP_HD inline Vec3 raised(const WallKernel& kernel, const Distance& at, const Vec3& x) {
  const bool beneath = at.d < kernel.reach && at.d > real(-0.5) * kernel.spacing;
  return beneath ? Vec3(x + (kernel.reach - at.d) * at.n) : x;
}

PALP_HD inline WallShare no_wall() { return {0, Vec3(0, 0, 0), Vec3(0, 0, 0), 0}; }
PALP_HD inline WallShare all_wall(const WallKernel& kernel) { return {1, Vec3(0, 0, 0), kernel.a, 0}; }

// Returns the share of what a solid does not fill.
PALP_HD inline WallShare complement(const WallKernel& kernel, const WallShare& of) {
  return {real(1) - of.share, -of.slope, kernel.a - of.pull, of.shear};
}

// Returns the pull across the edge of a right angle, of an acceleration along the other face, over both slopes [m^2].
PALP_HD inline real edge_pull(const WallKernel& kernel) {
  const real slope = kernel.of.over_plane(0);
  return real(1) / (real(2) * kPi * slope * slope);
}

// Returns the share of what two solids have in common.
PALP_HD inline WallShare common(const WallKernel& kernel, const WallShare& a, const WallShare& b) {
  const real cross = edge_pull(kernel);
  const Vec3 pull = b.share * a.pull + a.share * b.pull - (a.share * b.share) * kernel.a +
                    cross * (b.slope.dot(kernel.a) * a.slope + a.slope.dot(kernel.a) * b.slope);
  return {a.share * b.share, b.share * a.slope + a.share * b.slope, pull, b.share * a.shear + a.share * b.shear};
}

// The sums over layers behind a plane at a distance d >= 0: the share; the slope along the normal; its second moment,
// which is the pull of a unit acceleration along the normal.
struct PlaneSums {
  real share, slope, second;
};
PALP_HD inline PlaneSums plane_sums(const WallKernel& kernel, real d) {
  PlaneSums out{0, 0, 0};
  for (real z = d + real(0.5) * kernel.spacing; z < kernel.of.support; z += kernel.spacing) {
    const real fall = real(2) * kPi * kernel.spacing * z * kernel.of.W(z);
    out.share += kernel.spacing * kernel.of.over_plane(z);
    out.slope += fall;
    out.second += fall * z;
  }
  return out;
}

// Returns the distance that shear has at the distance d from a face.
PALP_HD inline real shear_distance(const WallKernel& kernel, real d) { return d > kernel.least ? d : kernel.least; }

// Returns what shear is for a slope at the distance d from a face.
PALP_HD inline real shear_of(const WallKernel& kernel, real slope, real d) { return slope / shear_distance(kernel, d); }

// Returns the share of what lies behind a face at the distance d >= 0.
PALP_HD inline WallShare behind_face(const WallKernel& kernel, real d, const Vec3& n, real k) {
  if (!(d < kernel.of.support)) return no_wall();
  const PlaneSums plane = plane_sums(kernel, d);
  const real kd = k * d, Q = d * plane.share + kernel.of.second_tail(d), Q3 = kernel.of.fourth_tail(d);
  const real across = plane.second - d * kd * plane.slope - k * k * (real(2) * d * Q + k * Q3);
  const real along = plane.share - real(2) * k * Q + k * k * (d * Q + real(0.5) * k * Q3);
  const real g = plane.slope * (real(1) - kd) - k * k * Q;
  const Vec3 pull = along * kernel.a + ((across - along) * n.dot(kernel.a)) * n;
  return {plane.share - k * Q, g * n, pull, shear_of(kernel, g, d)};
}

// Returns the share of what lies behind a face, on either side of it.
PALP_HD inline WallShare face_share(const WallKernel& kernel, real d, const Vec3& n, real k) {
  if (d < real(0)) return complement(kernel, behind_face(kernel, -d, -n, -k));
  return behind_face(kernel, d, n, k);
}

// Returns the share of a ball of radius R: of what lies behind its near side, less what that counts past its far one.
PALP_HD inline WallShare ball_share(const WallKernel& kernel, real d, const Vec3& n, real R) {
  const real r = d + R, k = real(1) / (r > kernel.least ? r : kernel.least);
  const WallShare near = face_share(kernel, d, n, k);
  if (!(d + real(2) * R < kernel.of.support)) return near;
  const WallShare far = behind_face(kernel, d + real(2) * R, n, k);
  return {near.share - far.share, near.slope - far.slope, near.pull - far.pull, near.shear - far.shear};
}

// Returns the share of a cylinder without ends about the axis z, from its profile (cylinder_profile.h): by the distance
// r from the axis, along n, the share, the slope, and pull along n and around the axis.
PALP_HD inline WallShare rod_share(const WallKernel& kernel, const NodeGrid& profile, real r, const Vec3& n,
                                   const Vec3& axis, real d) {
  const real at = r * profile.inv_cell;
  const int last = profile.n[0] - 1, k = static_cast<int>(at);
  if (k >= last) return no_wall();
  const real t = at - real(k);
  const Packed a = profile.node[k], b = profile.node[k + 1];
  const auto mix = [t](real low, real high) { return low + t * (high - low); };
  const real share = mix(a.x, b.x), slope = mix(a.y, b.y), along = mix(a.z, b.z), around = mix(a.w, b.w);
  const real out = n.dot(kernel.a), up = axis.dot(kernel.a);
  const Vec3 pull = (along * out) * n + (share * up) * axis + around * (kernel.a - out * n - up * axis);
  return {share, slope * n, pull, shear_of(kernel, slope, Eigen::numext::abs(d))};
}

// The part of space between two planes across an axis: share and shear as above, slope and pull along that axis for a
// unit acceleration along it. Along the other two axes pull is the share.
struct Slab {
  real share, slope, pull, shear;
};
PALP_HD inline Slab full_slab() { return {1, 0, 1, 0}; }

// Returns what lies behind a plane at the distance d, below 0 within; the axis is its normal.
PALP_HD inline Slab behind_plane(const WallKernel& kernel, real d) {
  if (!(Eigen::numext::abs(d) < kernel.of.support)) return d > real(0) ? Slab{0, 0, 0, 0} : full_slab();
  const real away = Eigen::numext::abs(d);
  const PlaneSums sums = plane_sums(kernel, away);
  const real shear = shear_of(kernel, sums.slope, away);
  if (d < real(0)) return {real(1) - sums.share, sums.slope, real(1) - sums.second, shear};
  return {sums.share, sums.slope, sums.second, shear};
}

// Returns what lies between two planes, of which `low` has its normal against the axis.
PALP_HD inline Slab between(const Slab& high, const Slab& low) {
  return {high.share + low.share - real(1), high.slope - low.slope, high.pull + low.pull - real(1),
          high.shear + low.shear};
}

// Returns the share of what three slabs across three axes at right angles have in common, in those axes.
PALP_HD inline WallShare in_common(const WallKernel& kernel, const Slab (&s)[3]) {
  const real cross = edge_pull(kernel);
  WallShare out{s[0].share * s[1].share * s[2].share, Vec3(0, 0, 0), Vec3(0, 0, 0), 0};
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    const real both = s[b].share * s[c].share;
    out.slope[a] = s[a].slope * both;
    out.shear += s[a].shear * both;
    out.pull[a] = s[a].pull * both * kernel.a[a] +
                  cross * s[a].slope * (s[b].slope * s[c].share * kernel.a[b] + s[c].slope * s[b].share * kernel.a[c]);
  }
  return out;
}

// The solid of a body, and what its shares are asked for.
struct WallShape {
  const ContactBody& body;
  const Piece* piece;
  const NodeGrid* grid;
  WallKernel kernel;

  // Returns true where solid hides a face: at its place y (solid's frame) the solid itself, or another part of it, ends
  // there or goes on. Boxes that fill a solid lie side by side, so that a face between two of them counts for both:
  // there only solid that lies before it, on the particle's side x, hides it.
  PALP_HD bool hides(const Vec3& y, const Vec3& x) const {
    if (!body.boxes) return distance_in_frame(body, piece, grid, y).d < kernel.reach;
    const Vec3 back = x - y;
    const real length = back.norm();
    if (!(length > real(0))) return false;
    const Vec3 before = y + (kernel.reach / length) * back;
    for (std::uint32_t k = body.first; k < body.solid; ++k)
      if (within(piece[k], before)) return true;
    return false;
  }
  PALP_HD static bool within(const Piece& box, const Vec3& y) {
    for (int a = 0; a < 3; ++a)
      if (y[a] < box.low[a] || y[a] > box.high[a]) return false;
    return true;
  }
};

// Says of the faces of a piece whether a particle at x, solid's frame, sees them.
struct FacesInSight {
  const WallShape& shape;
  const Piece& p;
  Vec3 x;

  // Returns true where solid hides the face at the distance d with the normal n, solid's frame: a face that is looked
  // at from within.
  PALP_HD bool hidden(real d, const Vec3& n) const {
    return (p.subtract ? d > real(0) : d < real(0)) && shape.hides(x - d * n, x);
  }
};

// Returns the share of a box for a particle at y, both in the box's axes, as the result and kernel.a are; nothing where
// it is taken away and hidden. to_solid: a rotation to the solid's frame, of vectors.
template <class ToSolid>
PALP_HD inline WallShare box_share(const FacesInSight& faces, const WallKernel& kernel, const Vec3& y,
                                   ToSolid to_solid) {
  const Vec3 &low = faces.p.low, &high = faces.p.high;
  for (int a = 0; a < 3; ++a)
    if (!(y[a] - high[a] < kernel.of.support && low[a] - y[a] < kernel.of.support)) return no_wall();
  bool gone = false;
  const auto face = [&](real d, int a, real side) {
    Vec3 n(0, 0, 0);
    n[a] = side;
    if (!(Eigen::numext::abs(d) < kernel.of.support) || !faces.hidden(d, to_solid(n))) return behind_plane(kernel, d);
    gone = faces.p.subtract;
    return full_slab();
  };
  Slab slab[3];
  for (int a = 0; a < 3; ++a) {
    slab[a] = between(face(y[a] - high[a], a, 1), face(low[a] - y[a], a, -1));
    if (!(slab[a].share > real(0))) return no_wall();
  }
  return gone ? no_wall() : in_common(kernel, slab);
}

// Returns the share of a piece of a body's solid, the solid's frame. Where the piece is taken away it is that of the
// piece itself, nothing if what is before it hides it.
PALP_HD inline WallShare piece_share(const WallShape& shape, const Piece& p, const Vec3& x) {
  const WallKernel& kernel = shape.kernel;
  const Vec3 y = p.R.transpose() * (x - p.c);
  const FacesInSight faces{shape, p, x};
  if (p.type == PieceType::box) {
    WallKernel turned = kernel;
    turned.a = p.R.transpose() * kernel.a;
    const WallShare out = box_share(faces, turned, y, [&](const Vec3& n) { return Vec3(p.R * n); });
    return {out.share, p.R * out.slope, p.R * out.pull, out.shear};
  }
  bool gone = false;  // taken away, and hidden
  const auto face_by = [&](real d, const Vec3& n, auto share_of) {
    if (!(Eigen::numext::abs(d) < kernel.of.support)) return d > real(0) ? no_wall() : all_wall(kernel);
    const Vec3 world = p.R * n;
    if (!faces.hidden(d, world)) return share_of(world);
    gone = p.subtract;
    return all_wall(kernel);
  };
  const auto face = [&](real d, const Vec3& n) {
    return face_by(d, n, [&](const Vec3& world) { return face_share(kernel, d, world, 0); });
  };
  WallShare out;
  if (p.type == PieceType::sphere) {
    const Distance at = sphere_distance(y, p.high.x());
    out = face_by(at.d, at.n, [&](const Vec3& world) { return ball_share(kernel, at.d, world, p.high.x()); });
  } else if (p.type == PieceType::cylinder) {
    const real r = Eigen::numext::sqrt(y.x() * y.x() + y.y() * y.y()), d = r - p.high.x();
    const Vec3 n = r > real(0) ? Vec3(y.x() / r, y.y() / r, 0) : Vec3(1, 0, 0);
    out = face_by(d, n, [&](const Vec3& world) {
      return rod_share(kernel, shape.grid[p.grid], r, world, p.R * Vec3(0, 0, 1), d);
    });
    if (out.share > real(0)) {
      const Vec3 up(0, 0, 1);
      const WallShare high = face(y.z() - p.high.z(), up), low = face(-y.z() - p.high.z(), -up);
      out = common(kernel, out,
                   {high.share + low.share - real(1), high.slope + low.slope, high.pull + low.pull - kernel.a,
                    high.shear + low.shear});
    }
  } else {
    const Distance at = grid_distance(shape.grid[p.grid], y);
    out = face(at.d, at.n);
  }
  return gone ? no_wall() : out;
}

// Returns the share of a body's solid for a particle at x; that and the result are in body axes about the centre of
// mass, as kernel.a is.
PALP_HD inline WallShare wall_share(const ContactBody& body, const Piece* piece, const NodeGrid* grid,
                                    WallKernel kernel, const Vec3& x) {
  kernel.a = body.R.transpose() * kernel.a;
  const WallShape shape{body, piece, grid, kernel};
  const Vec3 y = body.R.transpose() * (x - body.c);
  WallShare out = no_wall();
  if (body.boxes) {
    for (std::uint32_t k = body.first; k < body.solid; ++k) {
      const WallShare one = box_share({shape, piece[k], y}, kernel, y, [](const Vec3& n) { return n; });
      out = {out.share + one.share, out.slope + one.slope, out.pull + one.pull, out.shear + one.shear};
    }
  } else {
    WallShare empty = all_wall(kernel);  // of what is not solid
    for (std::uint32_t k = body.first; k < body.last; ++k) {
      const WallShare one = piece_share(shape, piece[k], y);
      empty = piece[k].subtract ? complement(kernel, common(kernel, complement(kernel, empty), complement(kernel, one)))
                                : common(kernel, empty, complement(kernel, one));
    }
    out = complement(kernel, empty);
  }
  return {out.share, body.R * out.slope, body.R * out.pull, out.shear};
}

}  // namespace palp
