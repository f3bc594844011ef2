#include "sim_server/scene/packing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim_server/geometry/point_grid.h"
#include "sim_server/scene/relaxation.h"
#include "sim_server/scene/solid_layout.h"
#include "sim_server/threads/thread_team.h"

namespace palp {

namespace {

using Eigen::Vector3d;

// All lengths in spacings.
constexpr double kSupport = 2.2;            // of the kernel by which particles are packed
constexpr double kContactDistance = 1.6;    // particles of two bodies this near share a lattice, or are packed
constexpr double kLatticeTolerance = 0.03;  // how far from sites of one lattice is still on it
constexpr double kLayerDepth = 3;           // of the layer around them that is packed
constexpr double kOccupiedDistance = 0.75;  // a site nearer than this to a particle is not open
constexpr double kSheet = 0.5;  // volume over that of a cell below which a solid's particle stands for a sheet, whose
                                // neighbours were cut to its faces and not to sites of a lattice
constexpr double kFirstRow = 0.5;       // of a lattice, off a face
constexpr double kRowTolerance = 0.15;  // how far a row may be off that
constexpr double kLeastOff = 0.2;       // of a particle that is packed, off a solid

// The solids that act on fluids by their geometry, where they stand at the start. Any thread may ask.
class StandingSolids {
 public:
  explicit StandingSolids(const Scene& scene) : box_(box_of(scene)), dx_(scene.spacing) {
    for (const Body& body : scene.bodies) {
      if (body.contact == nullptr) continue;
      layout_.add_solid(body);
      center_.emplace_back(body.position + body.orientation * body.center);
      axes_.emplace_back(body.orientation.toRotationMatrix());
    }
    grids_ = layout_.grids_at(layout_.node.data());
  }
  StandingSolids(StandingSolids&&) = default;  // the grids keep pointing at its nodes

  // Returns the place at least kLeastOff spacings off all of them that a place has to go to, straight off each in turn;
  // on periodic axes it may lie past an end, as the place may.
  FreePlace free_place(Vector3d place) const {
    constexpr int kTurns = 3;  // of a corner each face takes one
    const double least = kLeastOff * dx_;
    double clear = 0;
    for (int turn = 0; turn < kTurns; ++turn) {
      clear = 1e30;
      for (std::size_t k = 0; k < center_.size(); ++k) {
        const auto [d, n] = distance(k, place);
        if (d < least) place += (least - d) * n;
        clear = std::min(clear, std::max(d - least, 0.0));
      }
      if (clear > 0) break;
    }
    return {place, clear};
  }
  // Returns whether a place is where a lattice with these axes would have its first row off a face, an edge or a
  // corner, or farther off.
  bool suits_lattice(const Vector3d& place, const Eigen::Matrix3d& axes) const {
    for (std::size_t k = 0; k < center_.size(); ++k) {
      const auto [d, n] = distance(k, place);
      if (d >= dx_) continue;
      const Eigen::Array3d steps = (axes.transpose() * n).array().abs() * (d / dx_);
      if ((steps > kRowTolerance && (steps - kFirstRow).abs() > kRowTolerance).any() || d < 0) return false;
    }
    return true;
  }

 private:
  struct Way {
    double d;
    Vector3d n;
  };
  // Returns the way to a solid; of one whose bounds are a spacing off, that alone.
  Way distance(std::size_t k, const Vector3d& place) const {
    const Vec3 from = (axes_[k].transpose() * box_.between(place, center_[k])).cast<real>();
    if (outside_bounds(layout_.shape[k], from, static_cast<real>(dx_))) return {dx_, Vector3d::Zero()};
    const Distance at = solid_distance(layout_.shape[k], layout_.piece.data(), grids_.data(), from);
    return {static_cast<double>(at.d), axes_[k] * at.n.cast<double>()};
  }

  PeriodicBox box_;
  double dx_;
  SolidLayout layout_;
  std::vector<NodeGrid> grids_;
  std::vector<Vector3d> center_;       // of mass, by solid
  std::vector<Eigen::Matrix3d> axes_;  // of the body, by solid
};

struct Packing {
  Scene& scene;
  const std::vector<std::optional<Solid>>& solids;
  ThreadTeam& team;
  PeriodicBox box;
  double dx;
  StandingSolids standing;
  std::vector<Eigen::Matrix3d> axes;        // by body: of the lattice that its particles were laid in
  std::vector<Eigen::Isometry3d> to_solid;  // by body, from the world

  bool movable(std::size_t i) const {
    return scene.bodies[scene.body[i]].type == BodyKind::fluid && solids[scene.body[i]].has_value();
  }
  bool is_sheet(std::size_t i) const {
    return scene.bodies[scene.body[i]].contact != nullptr && scene.volume[i] < kSheet * dx * dx * dx;
  }
  const Eigen::Matrix3d& axes_of(std::size_t i) const { return axes[scene.body[i]]; }
};

Packing begin_packing(Scene& scene, const std::vector<std::optional<Solid>>& solids, ThreadTeam& team) {
  Packing p{scene, solids, team, box_of(scene), scene.spacing, StandingSolids(scene), {}, {}};
  for (std::size_t b = 0; b < solids.size(); ++b) {
    const Body& body = scene.bodies[b];
    Eigen::Isometry3d to_world = pose_of(body);
    if (solids[b]) to_world = to_world * solids[b]->frame;
    p.axes.emplace_back(to_world.linear());
    p.to_solid.push_back(to_world.inverse());
  }
  return p;
}

bool on_lattice(const Vector3d& steps) {
  return ((steps.array() - steps.array().round()).abs() < kLatticeTolerance).all();
}

// Returns the indices of those that a mark says yes to.
std::vector<std::uint32_t> marked(const std::vector<std::uint8_t>& mark) {
  std::vector<std::uint32_t> out;
  for (std::uint32_t i = 0; i < mark.size(); ++i)
    if (mark[i] != 0) out.push_back(i);
  return out;
}

// Returns the particles to move: those near a place where a fluid meets another body off its lattice.
std::vector<std::uint32_t> off_lattice_particles(const Packing& p) {
  const std::vector<Vector3d>& x = p.scene.position;
  std::vector<std::uint8_t> mark(x.size(), 0);
  {
    const PointGrid grid(x, p.box, kContactDistance * p.dx);
    p.team.for_each(x.size(), kParticlesAtOnce, [&](std::size_t i) {
      if (!p.movable(i)) return;
      bool fits = true, beside_particles = false;
      grid.near(x[i], [&](std::uint32_t j) {
        if (p.scene.body[i] == p.scene.body[j] || !fits || p.is_sheet(j)) return;
        const Vector3d d = p.axes_of(i).transpose() * p.box.between(x[j], x[i]) / p.dx;
        if (d.squaredNorm() >= kContactDistance * kContactDistance) return;
        beside_particles = true;
        fits = on_lattice(d);
      });
      if (!beside_particles) fits = p.standing.suits_lattice(x[i], p.axes_of(i));
      mark[i] = fits ? 0 : 1;
    });
  }
  std::vector<Vector3d> places;
  for (const std::uint32_t i : marked(mark)) places.push_back(x[i]);
  if (places.empty()) return {};
  const PointGrid near(places, p.box, kLayerDepth * p.dx);
  const double depth2 = kLayerDepth * kLayerDepth * p.dx * p.dx;
  p.team.for_each(x.size(), kParticlesAtOnce, [&](std::size_t i) {
    if (!p.movable(i) || mark[i] != 0) return;
    bool found = false;
    near.near(x[i], [&](std::uint32_t k) { found = found || p.box.between(places[k], x[i]).squaredNorm() < depth2; });
    mark[i] = found ? 1 : 0;
  });
  return marked(mark);
}

bool inside_a_body(const Packing& p, const Vector3d& place) {
  for (std::size_t b = 0; b < p.solids.size(); ++b) {
    if (!p.solids[b]) continue;
    const Vector3d local = p.to_solid[b] * place;
    if (p.solids[b]->bounds.contains(local) && p.solids[b]->contains(local)) return true;
  }
  return false;
}

// Number c of the steps of a cube that reaches as many steps to either side.
Vector3d lattice_steps(int c, int reach) {
  const int edge = 2 * reach + 1, x = c % edge, y = c / edge % edge, z = c / (edge * edge);
  return Vector3d(x, y, z) - Vector3d::Constant(reach);
}

// Appends the sites of a particle's lattice within its support that no particle fills.
void add_open_sites(const Packing& p, const PointGrid& around, const PointGrid& at, std::size_t i,
                    std::vector<Vector3d>& out) {
  const std::vector<Vector3d>& x = p.scene.position;
  const double occupied2 = kOccupiedDistance * kOccupiedDistance;
  // most sites have a particle that is nearer to them than to any other one
  std::array<bool, 125> filled{};
  around.near(x[i], [&](std::uint32_t j) {
    const Vector3d d = p.axes_of(i).transpose() * p.box.between(x[j], x[i]) / p.dx;
    const Eigen::Array3d steps = d.array().round();
    if ((steps.abs() <= 2).all() && (d - steps.matrix()).squaredNorm() < occupied2)
      filled[static_cast<std::size_t>((steps.z() + 2) * 25 + (steps.y() + 2) * 5 + steps.x() + 2)] = true;
  });
  for (int c = 0; c < 125; ++c) {
    const Vector3d steps = lattice_steps(c, 2);
    if (filled[static_cast<std::size_t>(c)] || steps.norm() > kSupport) continue;
    const Vector3d site = p.box.wrapped(x[i] + p.axes_of(i) * steps * p.dx);
    bool taken = false;
    at.near(site, [&](std::uint32_t j) {
      taken = taken || p.box.between(x[j], site).squaredNorm() < occupied2 * p.dx * p.dx;
    });
    if (!taken) out.push_back(site);
  }
}

// The lattice of the active particles goes on into open space, so that they do not spread into it.
std::vector<Vector3d> open_sites(const Packing& p, const std::vector<std::uint32_t>& active) {
  const std::vector<Vector3d>& x = p.scene.position;
  const PointGrid around(x, p.box, kSupport * p.dx), at(x, p.box, kOccupiedDistance * p.dx);
  std::vector<std::vector<Vector3d>> part(active.size() / kParticlesAtOnce + 1);
  p.team.in_chunks(active.size(), kParticlesAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) add_open_sites(p, around, at, active[k], part[begin / kParticlesAtOnce]);
  });
  std::vector<Vector3d> candidates, sites;
  for (const std::vector<Vector3d>& each : part) candidates.insert(candidates.end(), each.begin(), each.end());
  const PointGrid among(candidates, p.box, kOccupiedDistance * p.dx);
  std::vector<std::uint8_t> mark(candidates.size(), 0);
  p.team.for_each(candidates.size(), kParticlesAtOnce, [&](std::size_t k) {
    bool first = true;
    among.near(candidates[k], [&](std::uint32_t j) {
      first = first && (j >= k || p.box.between(candidates[j], candidates[k]).norm() >= kOccupiedDistance * p.dx);
    });
    mark[k] = first && !inside_a_body(p, candidates[k]) ? 1 : 0;
  });
  for (const std::uint32_t k : marked(mark)) sites.push_back(candidates[k]);
  return sites;
}

// Brings the volumes of the moved particles nearer to their body's mean until each body has its volume: shares of space
// leave out what lies between particles and walls, or count it twice.
void keep_volumes(Scene& scene, const std::vector<std::uint32_t>& moved) {
  std::vector<double> excess(scene.bodies.size(), 0), most(scene.bodies.size(), 0);
  for (std::size_t i = 0; i < scene.volume.size(); ++i) excess[scene.body[i]] += scene.volume[i];
  for (std::size_t b = 0; b < excess.size(); ++b) excess[b] -= scene.bodies[b].volume;
  // what a particle's volume is over the mean, where less of it helps, or more
  const auto over = [&](std::uint32_t i) {
    const Body& body = scene.bodies[scene.body[i]];
    const double out = scene.volume[i] - body.volume / body.count;
    return out * excess[scene.body[i]] > 0 ? out : 0;
  };
  for (const std::uint32_t i : moved) most[scene.body[i]] += over(i);
  for (const std::uint32_t i : moved) {
    const std::uint32_t b = scene.body[i];
    if (over(i) != 0) scene.volume[i] -= over(i) * std::min(1.0, excess[b] / most[b]);
  }
}

}  // namespace

void pack_fluids(Scene& scene, const std::vector<std::optional<Solid>>& solids, ThreadTeam& team,
                 const LoadingProgress& progress) {
  const Packing p = begin_packing(scene, solids, team);
  const std::vector<std::uint32_t> active = off_lattice_particles(p);
  if (active.empty()) return;
  const double cell = std::pow(scene.spacing, 3);
  Relaxation points{p.box, p.dx, scene.position, {}, active, {}, {}};
  for (const double volume : scene.volume) points.volume.push_back(volume / cell);
  const std::vector<Vector3d> open = open_sites(p, active);
  points.place.insert(points.place.end(), open.begin(), open.end());
  points.volume.resize(points.place.size(), 1.0);
  points.hold = [&p](const Vector3d& place) { return p.standing.free_place(place); };
  if (progress) points.progress = [&](double share) { progress("packing fluids around solids", share); };
  relax(points, team);
  for (const std::uint32_t i : active) {
    scene.position[i] = points.place[i];
    scene.volume[i] = points.volume[i] * cell;
  }
  keep_volumes(scene, active);
}

}  // namespace palp
