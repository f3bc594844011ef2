#include "sim_server/geometry/contact_shape.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Eigenvalues>

#include "sim_server/geometry/surface.h"

namespace palp {

namespace {

constexpr double kFar = 1e30;
constexpr double kPi = 3.14159265358979323846;
constexpr double kBent = 1.7e-3;  // sine of the angle from which an edge counts: a tenth of a degree

// Cells of a lattice of boxes, gathered greedily into fewer boxes.
void gather_boxes(const std::vector<double> (&cuts)[3], std::vector<bool> wanted, bool subtract,
                  std::vector<ContactPiece>& out) {
  const std::size_t n[3] = {cuts[0].size() - 1, cuts[1].size() - 1, cuts[2].size() - 1};
  const auto at = [&](std::size_t i, std::size_t j, std::size_t k) { return (k * n[1] + j) * n[0] + i; };
  const auto all = [&](std::size_t i0, std::size_t i1, std::size_t j0, std::size_t j1, std::size_t k0, std::size_t k1) {
    for (std::size_t k = k0; k < k1; ++k)
      for (std::size_t j = j0; j < j1; ++j)
        for (std::size_t i = i0; i < i1; ++i)
          if (!wanted[at(i, j, k)]) return false;
    return true;
  };
  for (std::size_t k = 0; k < n[2]; ++k)
    for (std::size_t j = 0; j < n[1]; ++j)
      for (std::size_t i = 0; i < n[0]; ++i) {
        if (!wanted[at(i, j, k)]) continue;
        std::size_t x = i + 1, y = j + 1, z = k + 1;
        while (x < n[0] && all(x, x + 1, j, y, k, z)) ++x;
        while (y < n[1] && all(i, x, y, y + 1, k, z)) ++y;
        while (z < n[2] && all(i, x, j, y, z, z + 1)) ++z;
        for (std::size_t c = k; c < z; ++c)
          for (std::size_t b = j; b < y; ++b)
            for (std::size_t a = i; a < x; ++a) wanted[at(a, b, c)] = false;
        ContactPiece piece;
        piece.subtract = subtract;
        piece.low = {cuts[0][i], cuts[1][j], cuts[2][k]};
        piece.high = {cuts[0][x], cuts[1][y], cuts[2][z]};
        out.push_back(piece);
      }
}

void add_box_pieces(const Solid& solid, ContactShape& shape) {
  const BoxCells cells = box_cells(solid);
  gather_boxes(cells.cuts, cells.inside, false, shape.pieces);
  // what is empty, and all around it
  std::vector<double> cuts[3];
  for (int a = 0; a < 3; ++a) {
    cuts[a] = cells.cuts[a];
    cuts[a].insert(cuts[a].begin(), -kFar);
    cuts[a].push_back(kFar);
  }
  std::vector<bool> empty;
  for (std::size_t k = 0; k < cells.count(2) + 2; ++k)
    for (std::size_t j = 0; j < cells.count(1) + 2; ++j)
      for (std::size_t i = 0; i < cells.count(0) + 2; ++i) {
        const bool edge = i == 0 || j == 0 || k == 0 || i > cells.count(0) || j > cells.count(1) || k > cells.count(2);
        empty.push_back(edge || !cells.at(i - 1, j - 1, k - 1));
      }
  gather_boxes(cuts, std::move(empty), true, shape.pieces);
}

ContactPiece piece_of(const Part& part) {
  ContactPiece piece;
  piece.type = part.type;
  piece.subtract = part.subtract;
  piece.pose = part.pose;
  piece.low = -part.half;
  piece.high = part.half;
  if (part.type == ShapeType::sphere) piece.high.x() = part.radius;
  if (part.type == ShapeType::cylinder) piece.high = {part.radius, part.radius, part.half_height};
  if (part.type == ShapeType::mesh) piece.pose.setIdentity();
  return piece;
}

// Where a cut goes through the solid's hull it has no end: the mouth of a cup would else be closed by the lid of what
// was cut out, which is nearer than its walls.
void open_ends(ContactPiece& piece, const Eigen::AlignedBox3d& bounds) {
  const double far = bounds.diagonal().norm();
  Eigen::AlignedBox3d hull;  // of the solid, in the cut's frame
  for (int c = 0; c < 8; ++c)
    hull.extend(piece.pose.inverse() * bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(c)));
  const bool round = piece.type == ShapeType::cylinder;
  for (int a = round ? 2 : 0; a < 3; ++a) {
    const double low = round ? -piece.high.z() : piece.low[a], high = piece.high[a];
    const double down = hull.min()[a] >= low ? far : 0, up = hull.max()[a] <= high ? far : 0;
    if (round) {
      piece.pose.translation() += piece.pose.linear().col(2) * (up - down) / 2;
      piece.high.z() += (up + down) / 2;
    } else {
      piece.low[a] -= down;
      piece.high[a] += up;
    }
  }
}

// A point of a surface, and the ball inside that touches the surface there. Balls round edges off a little, so that
// their middles stay outside what they lie on: a point of a face's rim that lies on another rim has two nearest faces.
struct Feature {
  Eigen::Vector3d at, middle;
  double radius;
  int round = -1;  // of its part
};

// The ball that touches all faces with these normals through a point, none (radius 0) where there is no such ball.
Feature rounded(const Eigen::Vector3d& at, const std::vector<Eigen::Vector3d>& normals, double radius) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& n : normals) {
    A += n * n.transpose();
    b += radius * n;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(A);
  Eigen::Vector3d inward = Eigen::Vector3d::Zero();
  for (int a = 0; a < 3; ++a) {
    const Eigen::Vector3d axis = solver.eigenvectors().col(a);
    if (solver.eigenvalues()[a] > 1e-4 * solver.eigenvalues()[2])
      inward += axis * axis.dot(b) / solver.eigenvalues()[a];
  }
  double reach = radius;
  for (const Eigen::Vector3d& n : normals) reach = std::min(reach, n.dot(inward));
  if (!(reach > 0.1 * radius) || inward.norm() > 4 * radius) return {at, at, 0};
  return {at, at - inward, reach};
}

// Where the mesh sticks out: ends of its convex edges, and points along them. What is flat or hollow is touched by
// points of the other solid.
void add_edge_points(const SurfaceMesh& mesh, double spacing, double radius, std::vector<Feature>& out) {
  struct Edge {
    Eigen::Vector3d normal, other_normal, opposite;
    int triangles = 0;
    double bend = 0;  // sine of the convex angle
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, Edge> edges;
  std::vector<std::vector<Eigen::Vector3d>> normals(mesh.vertices.size());
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
    for (const std::uint32_t v : t) {
      const auto same = [&](const Eigen::Vector3d& n) { return n.dot(normal) > 1 - 1e-6; };
      if (std::none_of(normals[v].begin(), normals[v].end(), same)) normals[v].push_back(normal);
    }
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t from = t[e], to = t[(e + 1) % 3], other = t[(e + 2) % 3];
      Edge& edge = edges[std::minmax(from, to)];
      if (++edge.triangles == 1) {
        edge.normal = normal;
        edge.opposite = mesh.vertices[other];
        continue;
      }
      edge.other_normal = normal;
      const double angle = edge.normal.cross(normal).norm();
      const bool convex = normal.dot(edge.opposite - mesh.vertices[from]) < 0;
      edge.bend = convex ? (edge.normal.dot(normal) < 0 ? 1 : angle) : 0;
    }
  }
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const auto& [ends, edge] : edges) {
    if (edge.bend < kBent) continue;
    const Eigen::Vector3d &a = mesh.vertices[ends.first], &b = mesh.vertices[ends.second];
    used[ends.first] = used[ends.second] = true;
    const double steps = std::ceil((b - a).norm() / spacing - 1e-9);
    for (double s = 1; s < steps; ++s)
      out.push_back(rounded(a + s / steps * (b - a), {edge.normal, edge.other_normal}, radius));
  }
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v]) out.push_back(rounded(mesh.vertices[v], normals[v], radius));
}

// Rings around the axis. Few points are enough, since they move along a ring that is whole; the others must stand back
// from what one touches by more than it gives, or a roll over them is felt. Points of rods thinner than
// two spacings stay where they are: one of half a spacing's radius that rolled at 0.1 m/s gained a third of its speed.
void add_rings(const Part& part, double spacing, double ball, std::vector<Feature>& out,
               std::vector<ContactRound>& rounds) {
  const double around = 4 * std::ceil(std::max(8.0, kPi * part.radius / (2 * spacing)));
  const double along = std::max(1.0, std::ceil(2 * part.half_height / spacing - 1e-9));
  for (double k = 0; k <= along; ++k) {
    const double z = (2 * k / along - 1) * part.half_height, inner = part.half_height - ball;
    const double middle = std::clamp(z, -inner, inner);
    const int round = part.radius < spacing ? -1 : static_cast<int>(rounds.size());
    if (round >= 0)
      rounds.push_back({part.pose * Eigen::Vector3d(0, 0, middle), part.pose.linear().col(2), part.pose.linear().col(0),
                        part.radius, around});
    for (double i = 0; i < around; ++i) {
      const double angle = 2 * kPi * i / around;
      const Eigen::Vector3d outward(std::cos(angle), std::sin(angle), 0);
      out.push_back({part.pose * (part.radius * outward + z * Eigen::Vector3d::UnitZ()),
                     part.pose * ((part.radius - ball) * outward + middle * Eigen::Vector3d::UnitZ()), ball, round});
    }
  }
}

void add_ball(const Part& part, double spacing, double ball, std::vector<Feature>& out) {
  const double count = std::max(64.0, std::ceil(16 * kPi * std::pow(part.radius / spacing, 2)));
  for (double i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1) / count, angle = i * kPi * (3 - std::sqrt(5.0)), r = std::sqrt(1 - z * z);
    const Eigen::Vector3d outward(r * std::cos(angle), r * std::sin(angle), z);
    out.push_back({part.pose * Eigen::Vector3d(part.radius * outward),
                   part.pose * Eigen::Vector3d((part.radius - ball) * outward), ball});
  }
}

Solid alone(const Part& part) {
  Solid solid;
  solid.parts = {part};
  solid.bounds = part.bounds;
  return solid;
}

// Returns whether a point of the part's surface is on the solid's, too.
bool on_surface(const Solid& solid, const Part& part, const Eigen::Vector3d& x) {
  constexpr double kBit = 1e-6;
  const Eigen::Vector3d middle = part.bounds.center();
  return !solid.contains(x + kBit * (x - middle)) && solid.contains(x - kBit * (x - middle));
}

// Returns whether a point is on the round surface of a cylinder, but for what a marched surface errs by.
bool on_round(const Part& cylinder, const Eigen::Vector3d& x, double spacing) {
  const Eigen::Vector3d y = cylinder.pose.inverse() * x;
  return std::abs(y.head<2>().norm() - cylinder.radius) < 0.1 * spacing;
}

// Vertices of the marched surface where two parts' surfaces meet. turning: cylinders whose rims are whole, so
// that their own points serve all of these.
void add_meeting_points(const Solid& solid, const SurfaceMesh& surface, double spacing,
                        const std::vector<const Part*>& turning, ContactShape& shape) {
  const Eigen::Isometry3d to_solid = solid.frame.inverse();
  const double near = 0.5 * spacing;
  for (const Eigen::Vector3d& v : surface.vertices) {
    const Eigen::Vector3d x = to_solid * v;
    if (std::any_of(turning.begin(), turning.end(), [&](const Part* p) { return on_round(*p, x, spacing); })) continue;
    int parts = 0;
    for (const Part& part : solid.parts) {
      bool in = false, out = false;
      for (int a = 0; a < 3; ++a)
        for (const double step : {-near, near}) (part.contains(x + step * Eigen::Vector3d::Unit(a)) ? in : out) = true;
      parts += in && out ? 1 : 0;
    }
    if (parts > 1) shape.points.push_back({v, 0});
  }
}

void add_features(const Part& part, double spacing, double ball, std::vector<Feature>& out,
                  std::vector<ContactRound>& rounds) {
  if (part.type == ShapeType::sphere)
    add_ball(part, spacing, ball, out);
  else if (part.type == ShapeType::cylinder)
    add_rings(part, spacing, ball, out, rounds);
  else
    add_edge_points(part.type == ShapeType::mesh ? part.mesh->mesh() : solid_surface(alone(part), spacing), spacing,
                    ball, out);
}

// Adds the points of a part. whole: by round, whether all of it is on the surface.
void add_found(const std::vector<Feature>& found, const std::vector<ContactRound>& rounds,
               const std::vector<bool>& whole, const Eigen::Isometry3d& frame, ContactShape& shape) {
  std::vector<int> place(rounds.size(), -1);
  for (std::size_t k = 0; k < rounds.size(); ++k) {
    if (!whole[k]) continue;
    place[k] = static_cast<int>(shape.rounds.size());
    const ContactRound& r = rounds[k];
    shape.rounds.push_back({frame * r.center, frame.linear() * r.axis, frame.linear() * r.zero, r.reach, r.points});
  }
  for (const Feature& f : found)
    shape.points.push_back({frame * f.middle, f.radius, f.round < 0 ? -1 : place[static_cast<std::size_t>(f.round)]});
}

void add_points(const Solid& solid, const SurfaceMesh& surface, double spacing, ContactShape& shape) {
  std::vector<Feature> found;
  std::vector<const Part*> turning;
  const auto ball_in = [&](const Eigen::AlignedBox3d& bounds) {
    return std::min(spacing / 4, 0.25 * bounds.sizes().minCoeff());
  };
  if (shape.boxes) {
    double ball = ball_in(solid.bounds);  // it has to fit into each wall
    for (const ContactPiece& box : shape.pieces)
      if (!box.subtract) ball = std::min(ball, 0.25 * (box.high - box.low).minCoeff());
    add_edge_points(surface, spacing, ball, found);
    for (const Feature& f : found) shape.points.push_back({f.middle, f.radius});
    return;
  }
  const bool cut = std::any_of(solid.parts.begin(), solid.parts.end(), [](const Part& p) { return p.subtract; });
  for (const Part& part : solid.parts) {
    if (part.subtract) continue;
    if (part.type == ShapeType::sphere && !cut) {
      shape.points.push_back({solid.frame * part.pose.translation(), part.radius});
      continue;
    }
    found.clear();
    std::vector<ContactRound> rounds;
    // a cut may leave less than the ball of what is around the point
    add_features(part, spacing, cut ? 0 : ball_in(part.bounds), found, rounds);
    std::vector<bool> whole(rounds.size(), true);
    const auto lost = [&](const Feature& f) { return solid.parts.size() > 1 && !on_surface(solid, part, f.at); };
    for (const Feature& f : found)
      if (f.round >= 0 && lost(f)) whole[static_cast<std::size_t>(f.round)] = false;
    std::erase_if(found, lost);
    if (!rounds.empty() && std::find(whole.begin(), whole.end(), false) == whole.end()) turning.push_back(&part);
    add_found(found, rounds, whole, solid.frame, shape);
  }
  if (cut) add_meeting_points(solid, surface, spacing, turning, shape);
}

}  // namespace

std::shared_ptr<const ContactShape> make_contact_shape(const Solid& solid, const SurfaceMesh& surface, double spacing) {
  auto shape = std::make_shared<ContactShape>();
  shape->frame = solid.frame;
  shape->bounds = solid.bounds;
  shape->boxes = solid.aligned_boxes();
  if (shape->boxes) {
    add_box_pieces(solid, *shape);
  } else {
    for (const Part& part : solid.parts) {
      shape->pieces.push_back(piece_of(part));
      if (part.subtract && (part.type == ShapeType::box || part.type == ShapeType::cylinder))
        open_ends(shape->pieces.back(), solid.bounds);
      if (part.type != ShapeType::mesh) continue;
      shape->pieces.back().grid = static_cast<int>(shape->grids.size());
      shape->grids.push_back(distance_grid(part, spacing / 2));
    }
  }
  add_points(solid, surface, spacing, *shape);
  return shape;
}

}  // namespace palp
