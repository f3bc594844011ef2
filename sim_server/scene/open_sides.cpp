#include "sim_server/scene/open_sides.h"

#include <algorithm>

#include "sim_server/geometry/point_grid.h"

namespace palp {
namespace {

using Eigen::Vector3d;

// Lengths in spacings. A place is empty when no particle is within kEmpty of it; a side is open when places at kNear
// and at kFar are empty and no solid is on the way there. On a lattice that is so in front of the first row alone.
constexpr double kEmpty = 0.9, kNear = 1.2, kFar = 2;
constexpr int kSteps = 400;       // on the way, so that no wall of 0.005 spacings is passed by
constexpr double kShallow = 2;    // what lies deeper below the highest particle of its body weighs enough to run off
constexpr double kBeside = 1.6;   // to neighbours on the same side, of which there are
constexpr int kFewest = 3;        // or more
constexpr double kUpwards = 0.7;  // cosine of the steepest direction that counts as above

class Surroundings {
 public:
  Surroundings(const Scene& scene, const std::vector<std::optional<Solid>>& solids)
      : scene_(scene), box_(box_of(scene)), grid_(scene.position, box_, kEmpty * scene.spacing) {
    for (std::size_t b = 0; b < solids.size(); ++b) {
      if (!solids[b] || scene.bodies[b].type == BodyKind::fluid) continue;
      const Eigen::Isometry3d pose = pose_of(scene.bodies[b]) * solids[b]->frame;
      obstacles_.push_back({&*solids[b], pose.inverse(), pose * solids[b]->bounds.center()});
    }
  }

  // Returns whether there is nothing to a side of a place or beneath. up: away from gravity.
  bool is_open(const Vector3d& place, const Vector3d& up) const {
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0}) {
        const Vector3d way = sign * scene_.spacing * Vector3d::Unit(axis);
        if (sign * up[axis] <= kUpwards && is_empty(place + kNear * way) && is_empty(place + kFar * way) &&
            is_free(place, kFar * way))
          return true;
      }
    return false;
  }

 private:
  struct Obstacle {
    const Solid* solid;
    Eigen::Isometry3d into_solid;
    Vector3d middle;  // its image that is nearest counts where the domain is periodic
  };
  bool is_empty(const Vector3d& at) const {
    const Vector3d place = box_.wrapped(at);
    const double reach = kEmpty * scene_.spacing;
    bool empty = true;
    grid_.near(place, [&](std::uint32_t j) {
      empty = empty && box_.between(scene_.position[j], place).squaredNorm() > reach * reach;
    });
    return empty;
  }
  bool is_free(const Vector3d& from, const Vector3d& way) const {
    return std::none_of(obstacles_.begin(), obstacles_.end(), [&](const Obstacle& o) {
      const Vector3d begin = o.into_solid * (o.middle + box_.between(from, o.middle));
      const Vector3d whole = o.into_solid.linear() * way;
      if (!o.solid->bounds.intersects(Eigen::AlignedBox3d(begin).extend(begin + whole))) return false;
      for (int k = 1; k <= kSteps; ++k)
        if (o.solid->contains(begin + static_cast<double>(k) / kSteps * whole)) return true;
      return false;
    });
  }

  const Scene& scene_;
  PeriodicBox box_;
  PointGrid grid_;
  std::vector<Obstacle> obstacles_;
};

// Returns the places of fluid that enough fluid lies above to run off. up: away from gravity.
std::vector<Vector3d> weighed_down(const Scene& scene, const Vector3d& up) {
  std::vector<Vector3d> out;
  for (const Body& body : scene.bodies) {
    if (body.type != BodyKind::fluid) continue;
    double top = -1e30;
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i) top = std::max(top, up.dot(scene.position[i]));
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
      if (top - up.dot(scene.position[i]) > kShallow * scene.spacing) out.push_back(scene.position[i]);
  }
  return out;
}

}  // namespace

bool runs_off(const Scene& scene, const std::vector<std::optional<Solid>>& solids, ThreadTeam& team) {
  if (scene.config.gravity.isZero()) return false;
  const Vector3d up = -scene.config.gravity.normalized();
  const std::vector<Vector3d> candidate = weighed_down(scene, up);
  if (candidate.empty()) return false;
  const Surroundings around(scene, solids);
  std::vector<std::uint8_t> open(candidate.size(), 0);
  team.for_each(candidate.size(), kParticlesAtOnce, [&](std::size_t i) { open[i] = around.is_open(candidate[i], up); });
  std::vector<Vector3d> side;
  for (std::size_t i = 0; i < candidate.size(); ++i)
    if (open[i] != 0) side.push_back(candidate[i]);
  const double reach = kBeside * scene.spacing;
  const PeriodicBox box = box_of(scene);
  const PointGrid grid(side, box, reach);
  return std::any_of(side.begin(), side.end(), [&](const Vector3d& x) {
    int beside = -1;  // itself
    grid.near(x, [&](std::uint32_t k) { beside += box.between(side[k], x).squaredNorm() < reach * reach ? 1 : 0; });
    return beside >= kFewest;
  });
}

}  // namespace palp
