#include "sim_server/scene/solid_shapes.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "sim_server/geometry/contact_shape.h"
#include "sim_server/physics/wall_sight.h"
#include "sim_server/scene/cylinder_profile.h"

namespace palp {
namespace {

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

void add_grid(const DistanceGrid& from, SolidShapes& out) {
  NodeGrid g{};
  g.origin = from.origin.cast<real>();
  g.cell = static_cast<real>(from.cell);
  g.inv_cell = static_cast<real>(1 / from.cell);
  std::copy(from.n.begin(), from.n.end(), g.n);
  g.node = nullptr;
  out.grid.push_back(g);
  for (std::size_t k = 0; k < from.distance.size(); ++k)
    out.node.push_back({from.normal[3 * k], from.normal[3 * k + 1], from.normal[3 * k + 2], from.distance[k]});
}

ContactBody shape_of(const Body& body, SolidShapes& out) {
  const ContactShape& from = *body.contact;
  ContactBody to{};
  to.R = from.frame.linear().cast<real>();
  to.c = (from.frame.translation() - body.center).cast<real>();
  to.low = from.bounds.min().cast<real>();
  to.high = from.bounds.max().cast<real>();
  to.boxes = from.boxes;
  to.first = to.solid = static_cast<std::uint32_t>(out.piece.size());
  const std::size_t first_grid = out.grid.size();
  for (const ContactPiece& piece : from.pieces) {
    to.solid += piece.subtract ? 0 : 1;
    out.piece.push_back(to_piece(piece, first_grid));
  }
  for (const DistanceGrid& grid : from.grids) add_grid(grid, out);
  to.last = static_cast<std::uint32_t>(out.piece.size());
  double reach = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const auto which = static_cast<Eigen::AlignedBox3d::CornerType>(corner);
    reach = std::max(reach, (from.frame * from.bounds.corner(which) - body.center).norm());
  }
  to.reach = static_cast<real>(reach);
  return to;
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
bool is_thin(const Body& body, const ContactBody& shape, const Scene& scene, double support, const SolidShapes& shapes,
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
      thin = distance_in_frame(shape, shapes.piece.data(), grids.data(), behind).d > real(0) &&
             blocks_sight(shape, shapes.piece.data(), grids.data(), x + real(0.1 * scene.spacing) * n, behind, near);
    }
  });
  return thin;
}

}  // namespace

std::vector<NodeGrid> SolidShapes::grids_at(const Packed* from) const {
  std::vector<NodeGrid> out = grid;
  for (NodeGrid& g : out) {
    g.node = from;
    from += static_cast<std::size_t>(g.n[0]) * static_cast<std::size_t>(g.n[1]) * static_cast<std::size_t>(g.n[2]);
  }
  return out;
}

SolidShapes solid_shapes(const Scene& scene) {
  SolidShapes out;
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    if (scene.bodies[b].contact == nullptr) continue;
    out.shaped.push_back(b);
    out.shape.push_back(shape_of(scene.bodies[b], out));
    reach_past_periods(scene, scene.bodies[b], out.shape.back(), out.piece);
  }
  return out;
}

// Gives each cylinder the profile of its shares, which those of one radius have in common.
void add_profiles(const FluidKernelOf<double>& kernel, SolidShapes& shapes) {
  const double support = kernel.support;
  std::map<real, std::uint32_t> of_radius;
  for (Piece& piece : shapes.piece) {
    if (piece.type != PieceType::cylinder) continue;
    const real radius = piece.high.x();
    const auto [found, first] = of_radius.try_emplace(radius, static_cast<std::uint32_t>(shapes.grid.size()));
    piece.grid = found->second;
    if (!first) continue;
    const double cell = (radius + support) / kProfileParts;
    shapes.grid.push_back(
        {Vec3(0, 0, 0), static_cast<real>(cell), static_cast<real>(1 / cell), {kProfileParts + 1, 1, 1}, nullptr});
    const std::vector<Packed> nodes = cylinder_profile(radius, kernel);
    shapes.node.insert(shapes.node.end(), nodes.begin(), nodes.end());
  }
}

void mark_thin(const Scene& scene, double support, SolidShapes& shapes) {
  const std::vector<NodeGrid> grids = shapes.grids_at(shapes.node.data());
  for (std::size_t k = 0; k < shapes.shape.size(); ++k)
    shapes.shape[k].thin = is_thin(scene.bodies[shapes.shaped[k]], shapes.shape[k], scene, support, shapes, grids);
}

}  // namespace palp
