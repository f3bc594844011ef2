#include "sim_server/scene/packing.h"

#include <algorithm>
#include <cmath>

#include "sim_server/geometry/point_grid.h"
#include "sim_server/physics/smoothing.h"

namespace palp {

namespace {

using Eigen::Vector3d;

// All lengths in spacings.
constexpr double kSupport = 2.2;            // of the kernel
constexpr double kContactDistance = 1.6;    // particles of two bodies this near share a lattice, or are packed
constexpr double kLatticeTolerance = 0.03;  // how far from sites of one lattice is still on it
constexpr double kLayerDepth = 3;           // of the layer around them that is packed
constexpr double kListSkin = 0.3;           // that a particle moves at most before neighbours are listed anew
constexpr double kOccupiedDistance = 0.75;  // a site nearer than this to a particle is not open
constexpr int kMinLists = 3;                // neighbours are listed anew this often at least
constexpr int kMaxLists = 12;               // and this often while two particles are nearer than kMinDistance
constexpr int kShiftsPerList = 20;          // particles move this often between two lists
constexpr double kMinDistance = 0.88;
constexpr double kShiftCoefficient = 0.2;  // of the displacement, over spacing^2 sum V gradW
constexpr double kMaxShift = 0.1;          // a displacement at most
constexpr double kConvergedShift = 2e-3;   // a largest displacement at which packing ends
constexpr double kMaxVolumeChange = 0.25;  // change of a particle's volume

constexpr auto kKernel = WendlandC2Of<double>::unit();  // of q = r / H

struct Packing {
  Scene& scene;
  const std::vector<std::optional<Solid>>& solids;
  PeriodicBox box;
  double dx;

  const Body& body_of(std::size_t i) const { return scene.bodies[scene.body[i]]; }
  bool movable(std::size_t i) const { return body_of(i).type == BodyKind::fluid && solids[scene.body[i]].has_value(); }
  // Axes of the lattice that particle i was laid in.
  Eigen::Matrix3d axes(std::size_t i) const {
    return body_of(i).orientation.toRotationMatrix() * solids[scene.body[i]]->frame.linear();
  }
};

bool on_lattice(const Vector3d& steps) {
  return ((steps.array() - steps.array().round()).abs() < kLatticeTolerance).all();
}

// Particles to move: those near a place where a fluid meets another body off its lattice.
std::vector<std::uint32_t> off_lattice_particles(const Packing& p) {
  const std::vector<Vector3d>& x = p.scene.position;
  const PointGrid grid(x, p.box, kContactDistance * p.dx);
  std::vector<Vector3d> places;
  for (std::uint32_t i = 0; i < x.size(); ++i) {
    if (!p.movable(i)) continue;
    bool fits = true;
    const Eigen::Matrix3d to_lattice = p.axes(i).transpose() / p.dx;
    grid.near(x[i], [&](std::uint32_t j) {
      if (!fits || p.scene.body[i] == p.scene.body[j]) return;
      const Vector3d d = to_lattice * p.box.between(x[j], x[i]);
      if (d.norm() < kContactDistance) fits = on_lattice(d);
    });
    if (!fits) places.push_back(x[i]);
  }
  std::vector<std::uint32_t> active;
  if (places.empty()) return active;
  const PointGrid near(places, p.box, kLayerDepth * p.dx);
  for (std::uint32_t i = 0; i < x.size(); ++i) {
    if (!p.movable(i)) continue;
    bool found = false;
    near.near(x[i],
              [&](std::uint32_t k) { found = found || p.box.between(places[k], x[i]).norm() < kLayerDepth * p.dx; });
    if (found) active.push_back(i);
  }
  return active;
}

bool inside_a_body(const Packing& p, const Vector3d& place) {
  for (std::size_t b = 0; b < p.solids.size(); ++b) {
    if (!p.solids[b]) continue;
    const Body& body = p.scene.bodies[b];
    const Eigen::Isometry3d to_world = Eigen::Translation3d(body.position) * body.orientation * p.solids[b]->frame;
    const Vector3d local = to_world.inverse() * place;
    if (p.solids[b]->bounds.contains(local) && p.solids[b]->contains(local)) return true;
  }
  return false;
}

// Number c of the steps of a cube that reaches as many steps to either side.
Vector3d lattice_steps(int c, int reach) {
  const int edge = 2 * reach + 1, x = c % edge, y = c / edge % edge, z = c / (edge * edge);
  return Vector3d(x, y, z) - Vector3d::Constant(reach);
}

// The lattice of the active particles goes on into open space, so that they do not spread into it.
std::vector<Vector3d> open_sites(const Packing& p, const std::vector<std::uint32_t>& active) {
  const std::vector<Vector3d>& x = p.scene.position;
  const PointGrid grid(x, p.box, kOccupiedDistance * p.dx);
  std::vector<Vector3d> candidates, sites;
  for (const std::uint32_t i : active) {
    const Eigen::Matrix3d axes = p.axes(i) * p.dx;
    for (int c = 0; c < 125; ++c) {
      const Vector3d steps = lattice_steps(c, 2);
      if (steps.norm() > kSupport) continue;
      const Vector3d site = p.box.wrapped(x[i] + axes * steps);
      bool filled = false;
      grid.near(site, [&](std::uint32_t j) {
        filled = filled || p.box.between(x[j], site).norm() < kOccupiedDistance * p.dx;
      });
      if (!filled) candidates.push_back(site);
    }
  }
  const PointGrid among(candidates, p.box, kOccupiedDistance * p.dx);
  for (std::uint32_t k = 0; k < candidates.size(); ++k) {
    bool first = true;
    among.near(candidates[k], [&](std::uint32_t j) {
      first = first && (j >= k || p.box.between(candidates[j], candidates[k]).norm() >= kOccupiedDistance * p.dx);
    });
    if (first && !inside_a_body(p, candidates[k])) sites.push_back(candidates[k]);
  }
  return sites;
}

// Neighbours of the active particles among particles and, counted on from those, open sites.
struct Neighbors {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> index;
};

Neighbors list_neighbors(const Packing& p, const std::vector<std::uint32_t>& active, const std::vector<Vector3d>& all) {
  const double reach = (kSupport + 2 * kListSkin) * p.dx;
  const PointGrid grid(all, p.box, reach);
  Neighbors lists;
  lists.first.push_back(0);
  for (const std::uint32_t i : active) {
    grid.near(all[i], [&](std::uint32_t j) {
      if (j != i && p.box.between(all[i], all[j]).norm() < reach) lists.index.push_back(j);
    });
    lists.first.push_back(lists.index.size());
  }
  return lists;
}

// Returns sum W over the neighbourhood of a particle of a whole cubic lattice, itself included.
double lattice_sum() {
  double sum = 0;
  for (int c = 0; c < 343; ++c) {
    const Vector3d steps = lattice_steps(c, 3);
    sum += kKernel.W(steps.norm() / kSupport);
  }
  return sum;
}

// Moves the active particles down the gradient of sum V W. True when they have come to rest.
bool relax(const Packing& p, const std::vector<std::uint32_t>& active, const Neighbors& lists,
           const std::vector<double>& volume_ratio, std::vector<Vector3d>& x) {
  const double dx = p.dx, H = kSupport * dx;
  const double scale = kShiftCoefficient * dx * 21 / (2 * EIGEN_PI * std::pow(kSupport, 4));
  const double near = 0.2 / std::pow(kKernel.W(1 / kSupport), 4);
  const std::vector<Vector3d> start = x;
  std::vector<Vector3d> shift(active.size());
  for (int round = 0; round < kShiftsPerList; ++round) {
    double farthest = 0;
    for (std::size_t k = 0; k < active.size(); ++k) {
      shift[k].setZero();
      for (std::size_t e = lists.first[k]; e < lists.first[k + 1]; ++e) {
        const std::uint32_t j = lists.index[e];
        const Vector3d d = p.box.between(x[active[k]], x[j]) / H;
        const double q2 = d.squaredNorm();
        if (q2 >= 1) continue;
        const double q = std::sqrt(q2), W = kKernel.W(q);
        // Monaghan 2000: particles nearer than a spacing are pushed harder
        shift[k] += scale * volume_ratio[j] * (1 + near * W * W * W * W) * kKernel.F(q) * d;
      }
      shift[k] *= std::min(1.0, kMaxShift * dx / std::max(shift[k].norm(), 1e-300));
      farthest = std::max(farthest, shift[k].norm());
    }
    for (std::size_t k = 0; k < active.size(); ++k) {
      const std::uint32_t i = active[k];
      const Vector3d moved = p.box.between(x[i] + shift[k], start[i]);
      x[i] = p.box.wrapped(start[i] + moved * std::min(1.0, kListSkin * dx / std::max(moved.norm(), 1e-300)));
    }
    if (farthest < kConvergedShift * dx) return true;
  }
  return false;
}

bool some_too_near(const Packing& p, const std::vector<std::uint32_t>& active, const Neighbors& lists,
                   const std::vector<Vector3d>& x) {
  for (std::size_t k = 0; k < active.size(); ++k)
    for (std::size_t e = lists.first[k]; e < lists.first[k + 1]; ++e)
      if (p.box.between(x[active[k]], x[lists.index[e]]).norm() < kMinDistance * p.dx) return true;
  return false;
}

// Volumes that share the space out: V = V0 / sum V W, relative to what a lattice has for the sum.
void assign_volumes(const Packing& p, const std::vector<std::uint32_t>& active, const std::vector<Vector3d>& x,
                    std::vector<double>& volume_ratio) {
  const double H = kSupport * p.dx, full = lattice_sum();
  const Neighbors lists = list_neighbors(p, active, x);
  std::vector<double> next(active.size());
  for (int round = 0; round < 4; ++round) {
    for (std::size_t k = 0; k < active.size(); ++k) {
      double sum = volume_ratio[active[k]];
      for (std::size_t e = lists.first[k]; e < lists.first[k + 1]; ++e)
        sum += volume_ratio[lists.index[e]] * kKernel.W(p.box.between(x[active[k]], x[lists.index[e]]).norm() / H);
      next[k] = std::clamp(volume_ratio[active[k]] * full / sum, 1 - kMaxVolumeChange, 1 + kMaxVolumeChange);
    }
    for (std::size_t k = 0; k < active.size(); ++k) volume_ratio[active[k]] = next[k];
  }
}

}  // namespace

void pack_fluids(Scene& scene, const std::vector<std::optional<Solid>>& solids) {
  const double cell = std::pow(scene.spacing, 3);
  const Packing p{scene, solids, {scene.bounds_min, scene.bounds_max, scene.config.periodic}, scene.spacing};
  const std::vector<std::uint32_t> active = off_lattice_particles(p);
  if (active.empty()) return;
  std::vector<Vector3d> x = scene.position;
  std::vector<double> volume_ratio(x.size());  // volume over that of a cell
  for (std::size_t i = 0; i < x.size(); ++i) volume_ratio[i] = scene.volume[i] / cell;
  const std::vector<Vector3d> open = open_sites(p, active);
  x.insert(x.end(), open.begin(), open.end());
  volume_ratio.resize(x.size(), 1.0);
  for (int list = 0; list < kMaxLists; ++list) {
    const Neighbors lists = list_neighbors(p, active, x);
    if (list >= kMinLists && !some_too_near(p, active, lists, x)) break;
    if (relax(p, active, lists, volume_ratio, x)) break;
  }
  assign_volumes(p, active, x, volume_ratio);
  for (const std::uint32_t i : active) {
    scene.position[i] = x[i];
    scene.volume[i] = volume_ratio[i] * cell;
  }
}

}  // namespace palp
