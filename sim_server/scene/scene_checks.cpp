#include "sim_server/scene/scene_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "sim_server/geometry/contact_shape.h"
#include "sim_server/geometry/point_grid.h"

namespace palp {

namespace {

constexpr double kNearest = 0.5;      // of a spacing, between bodies
constexpr double kApart = 0.7;        // of a spacing, between elastic bodies: nearer ones would burst apart
constexpr double kCoincident = 1e-3;  // of a spacing, within a body
constexpr double kElastic = 0.5;      // of a spacing, within a soft solid: nearer ones are too stiff for a step
constexpr double kSurface = 1e-6;     // of a spacing, the rounding of a place on a surface
constexpr double kPressed = 0.3;      // of a spacing, of solids: the springs of contact would throw deeper ones apart

std::string place(const Eigen::Vector3d& p) { return fmt::format("({:.4g}, {:.4g}, {:.4g}) m", p.x(), p.y(), p.z()); }

// Says whether a body begins as a soft solid: it is elastic, or of matter that is frozen.
bool is_soft_solid(const Scene& scene, const Body& body) {
  if (body.type == BodyKind::elastic) return true;
  const MaterialConfig& m = scene.config.materials[body.material];
  if (body.type != BodyKind::fluid || body.count == 0 || !m.young_modulus || scene.temperature.empty()) return false;
  return m.melting_temperature && scene.temperature[body.first] <= *m.melting_temperature;
}

// Remembers which pairs of bodies were reported.
class Pairs {
 public:
  Pairs(const Scene& scene, std::vector<std::string>& faults) : scene_(scene), faults_(faults) {}
  void overlap(std::uint32_t a, std::uint32_t b, const Eigen::Vector3d& at) {
    if (!seen_.insert(std::minmax(a, b)).second) return;
    const auto& bodies = scene_.config.bodies;
    const std::uint32_t later = std::max(a, b);
    const std::string text =
        a == b
            ? crowded(a, at)
            : fmt::format("body '{}' overlaps body '{}' near {}; move one of them or subtract the one from the other",
                          bodies[later].name, bodies[std::min(a, b)].name, place(at));
    faults_.push_back(bodies[later].where + ": " + text);
  }

 private:
  std::string crowded(std::uint32_t b, const Eigen::Vector3d& at) const {
    const BodyConfig& body = scene_.config.bodies[b];
    const bool loose = body.shapes.front().type == ShapeType::particles;
    const auto& periodic = scene_.config.periodic;
    const bool wraps = std::find(periodic.begin(), periodic.end(), true) != periodic.end();
    return fmt::format("body '{}' has two particles {}, near {}{}{}", body.name,
                       is_soft_solid(scene_, scene_.bodies[b])
                           ? fmt::format("less than {:g} m (half a spacing) apart", kElastic * scene_.spacing)
                           : "in one place",
                       place(at), loose ? "; leave one of them out of " + body.shapes.front().file : "",
                       wraps ? "; a body in a periodic domain may not be longer than the period" : "");
  }
  const Scene& scene_;
  std::vector<std::string>& faults_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen_;
};

// Farther inside than rounding: a particle on the very surface belongs to the one side as well as to the other.
bool well_inside(const Solid& solid, const Eigen::Vector3d& p, double margin) {
  if (!solid.bounds.contains(p) || !solid.contains(p)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = margin * Eigen::Vector3d::Unit(axis);
    if (!solid.contains(p + step) || !solid.contains(p - step)) return false;
  }
  return true;
}

}  // namespace

void check_inside_domain(Scene& scene, std::vector<std::string>& faults) {
  const PeriodicBox box = box_of(scene);
  const double slack = 1e-9 * (box.max - box.min).maxCoeff();
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    std::size_t outside = 0;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    for (std::size_t i = body.first; i < body.first + body.count; ++i) {
      Eigen::Vector3d& p = scene.position[i];
      if (body.type == BodyKind::fluid) p = box.wrapped(p);
      const bool out = ((p.array() + slack) < box.min.array()).any() || ((p.array() - slack) > box.max.array()).any();
      if (out && outside++ == 0) first = p;
    }
    if (outside == 0) continue;
    faults.push_back(
        fmt::format("{}: body '{}' has {} of {} particles outside the domain, the first at {}; move it or "
                    "make the [domain] larger",
                    scene.config.bodies[b].where, body.name, outside, body.count, place(first)));
  }
}

// Returns what takes places of the world into the frame of a body's solid.
Eigen::Isometry3d into_solid(const Body& body, const Solid& solid) { return (pose_of(body) * solid.frame).inverse(); }

// Where a solid's surface can touch another first, the contact points included: their balls lie a little inside, so
// they also tell of a solid that is flush with the one that it is pressed into, whose corners are on its very sides.
std::vector<ContactPoint> touching_points(const Body& body) {
  std::vector<ContactPoint> all;
  if (body.contact != nullptr) all = body.contact->points;
  for (const Eigen::Vector3d& corner : body.surface.vertices) all.push_back({corner, 0});
  return all;
}

// Finds rigid bodies and their obstacles that begin inside one another.
void check_pressed(const Scene& scene, const std::vector<std::optional<Solid>>& solids, Pairs& pairs) {
  const auto solid = [](const Body& body) { return body.type == BodyKind::rigid || body.type == BodyKind::fixed; };
  for (std::uint32_t a = 0; a < scene.bodies.size(); ++a) {
    const Body& one = scene.bodies[a];
    if (!solid(one)) continue;
    const std::vector<ContactPoint> points = touching_points(one);
    for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
      const Body& other = scene.bodies[b];
      if (a == b || !solids[b] || !solid(other)) continue;
      if (one.type == BodyKind::fixed && other.type == BodyKind::fixed) continue;
      const Eigen::Isometry3d to_solid = into_solid(other, *solids[b]);
      for (const ContactPoint& point : points) {
        const Eigen::Vector3d at = one.position + one.orientation * point.position;
        const double margin = kPressed * scene.spacing - point.radius;
        if (margin > 0 && well_inside(*solids[b], to_solid * at, margin)) pairs.overlap(a, b, at);
      }
    }
  }
}

void check_apart(const Scene& scene, const std::vector<std::optional<Solid>>& solids, ThreadTeam& team,
                 std::vector<std::string>& faults) {
  Pairs pairs(scene, faults);
  std::vector<std::uint8_t> inside(scene.position.size());
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    if (!solids[b]) continue;
    const Eigen::Isometry3d to_solid = into_solid(scene.bodies[b], *solids[b]);
    team.for_each(scene.position.size(), kParticlesAtOnce, [&](std::size_t i) {
      inside[i] = scene.body[i] != b && well_inside(*solids[b], to_solid * scene.position[i], kSurface * scene.spacing);
    });
    for (std::uint32_t i = 0; i < scene.position.size(); ++i)
      if (inside[i] != 0) pairs.overlap(scene.body[i], b, scene.position[i]);
  }
  check_pressed(scene, solids, pairs);
}

void check_distances(const Scene& scene, ThreadTeam& team, std::vector<std::string>& faults) {
  Pairs pairs(scene, faults);
  const PeriodicBox box = box_of(scene);
  const auto elastic_bodies = std::count_if(scene.bodies.begin(), scene.bodies.end(),
                                            [](const Body& body) { return body.type == BodyKind::elastic; });
  const PointGrid grid(scene.position, box, (elastic_bodies > 1 ? kApart : kNearest) * scene.spacing);
  const auto least_between = [&](std::uint32_t a, std::uint32_t b) {
    if (a == b) return is_soft_solid(scene, scene.bodies[a]) ? kElastic : kCoincident;
    return scene.bodies[a].type == BodyKind::elastic && scene.bodies[b].type == BodyKind::elastic ? kApart : kNearest;
  };
  // fluids and solids meet a solid that acts by its geometry at its surface, wherever its particles are
  const auto meet_at_surface = [&](const Body& one, const Body& other) {
    const bool solid = one.type == BodyKind::rigid || one.type == BodyKind::fixed;
    return other.contact != nullptr && (one.type == BodyKind::fluid || (solid && one.contact != nullptr));
  };
  // calls found(j) for each particle j > i that is too near
  const auto look = [&](std::uint32_t i, auto found) {
    grid.near(scene.position[i], [&](std::uint32_t j) {
      const Body &one = scene.bodies[scene.body[i]], &other = scene.bodies[scene.body[j]];
      if (j <= i || meet_at_surface(one, other) || meet_at_surface(other, one)) return;
      const double least = least_between(scene.body[i], scene.body[j]) * scene.spacing * (1 - 1e-6);
      if (box.between(scene.position[i], scene.position[j]).squaredNorm() < least * least) found(j);
    });
  };
  std::vector<std::uint8_t> near(scene.position.size(), 0);
  team.for_each(scene.position.size(), kParticlesAtOnce,
                [&](std::size_t i) { look(static_cast<std::uint32_t>(i), [&](std::uint32_t) { near[i] = 1; }); });
  for (std::uint32_t i = 0; i < scene.position.size(); ++i)
    if (near[i] != 0) look(i, [&](std::uint32_t j) { pairs.overlap(scene.body[i], scene.body[j], scene.position[i]); });
}

}  // namespace palp
