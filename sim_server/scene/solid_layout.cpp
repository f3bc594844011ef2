#include "sim_server/scene/solid_layout.h"

#include <algorithm>

#include "sim_server/geometry/contact_shape.h"

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

void add_grid(const DistanceGrid& from, SolidLayout& to) {
  NodeGrid g{};
  g.origin = from.origin.cast<real>();
  g.cell = static_cast<real>(from.cell);
  g.inv_cell = static_cast<real>(1 / from.cell);
  std::copy(from.n.begin(), from.n.end(), g.n);
  g.node = nullptr;
  to.grid.push_back(g);
  for (std::size_t k = 0; k < from.distance.size(); ++k)
    to.node.push_back({from.normal[3 * k], from.normal[3 * k + 1], from.normal[3 * k + 2], from.distance[k]});
}

}  // namespace

ContactBody& SolidLayout::add_solid(const Body& body) {
  const ContactShape& from = *body.contact;
  ContactBody to{};
  to.R = from.frame.linear().cast<real>();
  to.c = (from.frame.translation() - body.center).cast<real>();
  to.low = from.bounds.min().cast<real>();
  to.high = from.bounds.max().cast<real>();
  to.boxes = from.boxes;
  to.first = to.solid = static_cast<std::uint32_t>(piece.size());
  const std::size_t first_grid = grid.size();
  for (const ContactPiece& one : from.pieces) {
    to.solid += one.subtract ? 0 : 1;
    piece.push_back(to_piece(one, first_grid));
  }
  for (const DistanceGrid& one : from.grids) add_grid(one, *this);
  to.last = static_cast<std::uint32_t>(piece.size());
  double reach = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const auto which = static_cast<Eigen::AlignedBox3d::CornerType>(corner);
    reach = std::max(reach, (from.frame * from.bounds.corner(which) - body.center).norm());
  }
  to.reach = static_cast<real>(reach);
  return shape.emplace_back(to);
}

std::vector<NodeGrid> SolidLayout::grids_at(const Packed* from) const {
  std::vector<NodeGrid> out = grid;
  for (NodeGrid& g : out) {
    g.node = from;
    from += static_cast<std::size_t>(g.n[0]) * static_cast<std::size_t>(g.n[1]) * static_cast<std::size_t>(g.n[2]);
  }
  return out;
}

}  // namespace palp
