#include "sim_server/scene/packing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim_server/geometry/point_grid.h"
#include "sim_server/scene/relaxation.h"
#include "sim_server/scene/support_radii.h"
#include "sim_server/scene/walls_at_rest.h"

namespace palp {

namespace {

using Eigen::Vector3d;

// All lengths in spacings.
constexpr double kUneven = 0.02;  // |sum V gradW| from which on particles are packed
constexpr double kLayerDepth = 4;
constexpr double kOccupiedDistance = 0.75;                 // a site nearer than this to a fluid's particle is not open
constexpr double kFilledDistance = 0.9;                    // nor one that is nearer than this to another body's
constexpr double kShortestCell = 0.6, kLongestCell = 1.6;  // sides of a lattice's cell
constexpr double kAlong = 0.1;                             // how far off an axis of the lattice a particle is along it
constexpr double kFirstLayer = 0.12;  // |sum V gradW| of open space, from which on a particle is next to it

// The particles that fluids meet, which are all but those of solids that act by their geometry.
struct Points {
  std::vector<std::uint32_t> particle;
  std::vector<Vector3d> place;
  bool of_one_body;

  explicit Points(const Scene& scene) : of_one_body(true) {
    for (std::uint32_t i = 0; i < scene.position.size(); ++i) {
      if (scene.bodies[scene.body[i]].contact != nullptr) continue;
      particle.push_back(i);
      place.push_back(scene.position[i]);
      of_one_body = of_one_body && scene.body[i] == scene.body[particle.front()];
    }
  }
};

struct Packing {
  Scene& scene;
  const std::vector<std::optional<Solid>>& solids;
  ThreadTeam& team;
  PeriodicBox box;
  double dx, support;
  FluidKernelOf<double> kernel;
  WallsAtRest walls;
  Points points;
  PointGrid around, at;                     // the points, within the support and within what may fill a site
  std::vector<Eigen::Matrix3d> axes;        // by body: of the lattice that its particles were laid in
  std::vector<Eigen::Isometry3d> to_solid;  // by body, from the world

  Packing(Scene& of, const std::vector<std::optional<Solid>>& solids_of, ThreadTeam& threads)
      : scene(of),
        solids(solids_of),
        team(threads),
        box(box_of(of)),
        dx(of.spacing),
        support(fluid_support(of)),
        kernel(FluidKernelOf<double>::with_support(support, dx)),
        walls(of),
        points(of),
        around(points.place, box, support),
        at(points.place, box, kFilledDistance * dx) {
    for (std::size_t b = 0; b < solids.size(); ++b) {
      const Body& body = scene.bodies[b];
      Eigen::Isometry3d to_world = Eigen::Translation3d(body.position) * body.orientation;
      if (solids[b]) to_world = to_world * solids[b]->frame;
      axes.emplace_back(to_world.linear());
      to_solid.push_back(to_world.inverse());
    }
  }

  bool is_fluid(std::size_t i) const { return scene.bodies[scene.body[i]].type == BodyKind::fluid; }
  bool movable(std::size_t i) const { return is_fluid(i) && solids[scene.body[i]].has_value(); }
  bool in_sight(const Vector3d& x, const Vector3d& y) const { return !walls.some_thin() || walls.in_sight(x, y); }
  const Eigen::Matrix3d& axes_of(std::size_t i) const { return axes[scene.body[i]]; }
};

// Returns whether a place is within the shape of a fluid, which its particles fill.
bool inside_a_fluid(const Packing& p, const Vector3d& place) {
  for (std::size_t b = 0; b < p.solids.size(); ++b) {
    if (!p.solids[b] || p.scene.bodies[b].type != BodyKind::fluid) continue;
    const Vector3d local = p.to_solid[b] * place;
    if (p.solids[b]->bounds.contains(local) && p.solids[b]->contains(local)) return true;
  }
  return false;
}

// Returns the indices of those that a mark says yes to.
std::vector<std::uint32_t> marked(const std::vector<std::uint8_t>& mark) {
  std::vector<std::uint32_t> out;
  for (std::uint32_t i = 0; i < mark.size(); ++i)
    if (mark[i] != 0) out.push_back(i);
  return out;
}

// The sites of a particle's lattice around it, within the support and a spacing of it.
struct Sites {
  int reach, edge;
  explicit Sites(const Packing& p)
      : reach(static_cast<int>(std::ceil(p.support / (kShortestCell * p.dx)))), edge(2 * reach + 1) {}
  int count() const { return edge * edge * edge; }
  // Returns the steps of the lattice to site c.
  Eigen::Array3d steps(int c) const { return Eigen::Array3d(c % edge, c / edge % edge, c / (edge * edge)) - reach; }
  int at(const Eigen::Array3d& steps) const {
    return static_cast<int>(((steps.z() + reach) * edge + steps.y() + reach) * edge + steps.x() + reach);
  }
};

// Returns the sides of the cell that a particle fills in its lattice: how far the next ones along the lattice's axes
// are. Boxes that the spacing does not divide have cells that are longer or shorter.
Eigen::Array3d cell_of(const Packing& p, std::size_t i) {
  Eigen::Array3d cell = Eigen::Array3d::Constant(kLongestCell);
  p.around.near(p.scene.position[i], [&](std::uint32_t k) {
    if (p.scene.body[p.points.particle[k]] != p.scene.body[i]) return;
    const Eigen::Array3d d =
        (p.axes_of(i).transpose() * p.box.between(p.points.place[k], p.scene.position[i]) / p.dx).array().abs();
    for (int a = 0; a < 3; ++a)
      if (d[a] > kShortestCell && d[(a + 1) % 3] < kAlong && d[(a + 2) % 3] < kAlong) cell[a] = std::min(cell[a], d[a]);
  });
  return p.dx * (cell < kLongestCell).select(cell, 1.0);
}

// Calls open(site) for each site of a particle's lattice within its support that neither particles nor solids fill.
template <class Open>
void for_open_sites(const Packing& p, std::size_t i, Open&& open) {
  const Vector3d& x = p.scene.position[i];
  const Sites sites(p);
  const Eigen::Array3d cell = cell_of(p, i);
  const auto fills = [&](std::uint32_t k) {
    return (p.is_fluid(p.points.particle[k]) ? kOccupiedDistance : kFilledDistance) * p.dx;
  };
  // most sites have a particle that is nearer to them than to any other one
  std::vector<std::uint8_t> filled(static_cast<std::size_t>(sites.count()), 0);
  p.around.near(x, [&](std::uint32_t k) {
    const Eigen::Array3d d = (p.axes_of(i).transpose() * p.box.between(p.points.place[k], x)).array() / cell;
    const Eigen::Array3d steps = d.round();
    if ((steps.abs() <= sites.reach).all() && ((d - steps) * cell).matrix().norm() < fills(k))
      filled[static_cast<std::size_t>(sites.at(steps))] = 1;
  });
  for (int c = 0; c < sites.count(); ++c) {
    const Vector3d way = (sites.steps(c) * cell).matrix();
    if (filled[static_cast<std::size_t>(c)] != 0 || way.norm() > p.support) continue;
    const Vector3d site = p.box.wrapped(x + p.axes_of(i) * way);
    bool taken = false;
    p.at.near(site,
              [&](std::uint32_t k) { taken = taken || p.box.between(p.points.place[k], site).norm() < fills(k); });
    if (taken || inside_a_fluid(p, site) || p.walls.at(site).distance < 0) continue;
    if (p.in_sight(x, site)) open(site);
  }
}

// Returns the axis of the lattice that leads out of the fluid for a particle in the first layer beneath a free surface;
// else zero.
Eigen::Vector3f way_out(const Packing& p, std::size_t i) {
  const Vector3d& x = p.scene.position[i];
  Vector3d sum = Vector3d::Zero();
  for_open_sites(p, i, [&](const Vector3d& site) {
    const Vector3d d = p.box.between(site, x);
    sum += p.scene.volume[i] * p.kernel.F(d.norm()) * d;
  });
  if (!(sum.norm() * p.dx > kFirstLayer)) return Eigen::Vector3f::Zero();
  Eigen::Index axis;
  (p.axes_of(i).transpose() * sum).cwiseAbs().maxCoeff(&axis);
  return p.axes_of(i).col(axis).cast<float>();
}

// Returns |sum V gradW| around a particle, its lattice going on into open space, times the spacing.
double unevenness(const Packing& p, std::size_t i, const WallsHere& walls) {
  const Vector3d& x = p.scene.position[i];
  Vector3d sum = -walls.slope;
  const auto add = [&](const Vector3d& place, double volume) {
    const Vector3d d = p.box.between(x, place);
    sum -= volume * p.kernel.F(d.norm()) * d;
  };
  p.around.near(x, [&](std::uint32_t k) {
    if (p.in_sight(x, p.points.place[k])) add(p.points.place[k], p.scene.volume[p.points.particle[k]]);
  });
  for_open_sites(p, i, [&](const Vector3d& site) { add(site, p.scene.volume[i]); });
  return sum.norm() * p.dx;
}

// Returns the particles to move: those where a fluid is uneven beside a solid or another body, and a layer around them.
std::vector<std::uint32_t> uneven_particles(const Packing& p) {
  const std::vector<Vector3d>& x = p.scene.position;
  std::vector<std::uint8_t> mark(x.size(), 0);
  p.team.for_each(x.size(), kParticlesAtOnce, [&](std::size_t i) {
    if (!p.movable(i)) return;
    const WallsHere walls = p.walls.at(x[i]);
    bool meets = walls.distance < p.support;
    const auto look = [&](std::uint32_t k) {
      meets = meets || (p.scene.body[p.points.particle[k]] != p.scene.body[i] &&
                        p.box.between(p.points.place[k], x[i]).norm() < p.support);
    };
    if (!p.points.of_one_body) p.around.near(x[i], look);
    mark[i] = meets && unevenness(p, i, walls) > kUneven ? 1 : 0;
  });
  std::vector<Vector3d> places;
  for (const std::uint32_t i : marked(mark)) places.push_back(x[i]);
  if (places.empty()) return {};
  const double depth = kLayerDepth * p.dx;
  const PointGrid near(places, p.box, depth);
  p.team.for_each(x.size(), kParticlesAtOnce, [&](std::size_t i) {
    if (!p.movable(i) || mark[i] != 0) return;
    near.near(x[i], [&](std::uint32_t k) {
      if (p.box.between(places[k], x[i]).squaredNorm() < depth * depth) mark[i] = 1;
    });
  });
  return marked(mark);
}

struct Site {
  Vector3d place;
  double volume;  // of the particle whose lattice it is of [m^3]
};

// The lattice of the active particles goes on into open space, so that they do not spread into it.
std::vector<Site> open_sites(const Packing& p, const std::vector<std::uint32_t>& active) {
  std::vector<std::vector<Site>> part(active.size() / kParticlesAtOnce + 1);
  p.team.in_chunks(active.size(), kParticlesAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      for_open_sites(p, active[k], [&](const Vector3d& site) {
        part[begin / kParticlesAtOnce].push_back({site, p.scene.volume[active[k]]});
      });
  });
  std::vector<Site> candidates, sites;
  for (const std::vector<Site>& each : part) candidates.insert(candidates.end(), each.begin(), each.end());
  std::vector<Vector3d> places;
  for (const Site& site : candidates) places.push_back(site.place);
  const double taken = kOccupiedDistance * p.dx;
  const PointGrid among(places, p.box, taken);
  std::vector<std::uint8_t> mark(candidates.size(), 0);
  p.team.for_each(candidates.size(), kParticlesAtOnce, [&](std::size_t k) {
    bool first = true;
    among.near(places[k], [&](std::uint32_t j) {
      first = first && (j >= k || p.box.between(places[j], places[k]).norm() >= taken);
    });
    mark[k] = first ? 1 : 0;
  });
  for (const std::uint32_t k : marked(mark)) sites.push_back(candidates[k]);
  return sites;
}

// Keeps the bounds of the bodies whose particles are about to move.
void note_bounds(Scene& scene, const std::vector<std::uint32_t>& active) {
  for (const std::uint32_t k : active) {
    Body& body = scene.bodies[scene.body[k]];
    if (!body.unpacked.isEmpty()) continue;
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) body.unpacked.extend(scene.position[i]);
  }
}

}  // namespace

void pack_fluids(Scene& scene, const std::vector<std::optional<Solid>>& solids, ThreadTeam& team,
                 const LoadingProgress& progress) {
  const Packing p(scene, solids, team);
  const std::vector<std::uint32_t> active = uneven_particles(p);
  if (active.empty()) return;
  const double cell = std::pow(scene.spacing, 3);
  Relaxation relaxation{p.box, p.dx, p.support, p.walls, p.points.place, {}, {}, {}, {}};
  std::vector<std::uint32_t> point_of(scene.position.size(), 0);
  for (std::uint32_t k = 0; k < p.points.particle.size(); ++k) {
    point_of[p.points.particle[k]] = k;
    relaxation.volume.push_back(scene.volume[p.points.particle[k]] / cell);
  }
  for (const std::uint32_t i : active) relaxation.moving.push_back(point_of[i]);
  relaxation.held.resize(active.size());
  team.for_each(active.size(), kParticlesAtOnce, [&](std::size_t k) { relaxation.held[k] = way_out(p, active[k]); });
  for (const Site& site : open_sites(p, active)) {
    relaxation.place.push_back(site.place);
    relaxation.volume.push_back(site.volume / cell);
  }
  if (progress) relaxation.progress = [&](double share) { progress("packing fluids around solids", share); };
  relax(relaxation, team);
  note_bounds(scene, active);
  for (const std::uint32_t i : active) {
    scene.position[i] = relaxation.place[point_of[i]];
    scene.volume[i] = relaxation.volume[point_of[i]] * cell;
  }
}

}  // namespace palp
