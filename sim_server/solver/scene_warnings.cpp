#include "sim_server/solver/scene_warnings.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "config/error.h"
#include "sim_server/geometry/point_grid.h"
#include "sim_server/solver/fluid_room.h"
#include "sim_server/solver/fluid_watch.h"

namespace palp {
namespace {

// How much of a spacing's volume a wall of one layer must have to hold a fluid, at supports past 2.5 spacings and
// below. Measured with 20 to 60 cm of water, particles 2 cm apart, that stood for half a second in open boxes, or fell
// into them from 30 cm or 1 m. At H = 3 dx walls of 0.6 spacings let 12 of 2,000 particles through at rest and 80 of
// 640 after the fall, walls of one spacing none. At H = 2 dx walls of 0.51 spacings let 8 of 3,000 through at rest, of
// 0.6 16 of 1,280 after the fall, of 0.7 to 0.9 none. Walls below half a spacing are refused as they are sampled.
constexpr double kThinnestLong = 0.9, kThinnestShort = 0.7;
constexpr double kLongSupport = 2.5;  // [dx]

double thinnest(const Scene& scene, const Plan& plan) {
  return plan.support > kLongSupport * scene.spacing ? kThinnestLong : kThinnestShort;
}

// The factor by which the speed that a scene may reach may pass max_speed without a word, because it is a bound: in
// kitchen, where it does so by 1.4, the mean compression stays at 0.45 of what is promised; where a tray of fluid has a
// max_speed 1.8 and 2.5 times too low it is 0.8 and 1.65 (fluid_watch.h).
constexpr double kSpeedMargin = 1.5;

// Returns where a body of the scene is declared.
std::string where_is(const Scene& scene, std::size_t body) {
  if (body < scene.config.bodies.size() && !scene.config.bodies[body].where.empty())
    return scene.config.bodies[body].where;
  return scene.config.path;
}

// Returns true when some particle of a body is within reach of one of another.
bool within_reach(const Scene& scene, std::size_t a, std::size_t b, double reach) {
  const auto from = scene.position.begin() + scene.bodies[b].first;
  const std::vector<Eigen::Vector3d> points(from, from + scene.bodies[b].count);
  const PeriodicBox box = box_of(scene);
  const PointGrid grid(points, box, reach);
  bool any = false;
  for (std::uint32_t i = scene.bodies[a].first; i < scene.bodies[a].first + scene.bodies[a].count && !any; ++i)
    grid.near(scene.position[i],
              [&](std::uint32_t j) { any = any || box.between(points[j], scene.position[i]).norm() < reach; });
  return any;
}

// Refuses a body that holds on to another one but reaches none of its particles: it would fall without a word.
void check_bonds(const Scene& scene, const Plan& plan) {
  std::vector<std::string> faults;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    for (const std::uint32_t other : scene.bodies[b].bonded_to) {
      const double reach = 0.999 * (plan.changes[b] ? plan.change_support : plan.elastic_support);
      if (scene.bodies[b].count == 0 || within_reach(scene, b, other, reach)) continue;
      faults.push_back(
          fmt::format("{}: body '{}' is bonded_to '{}' but has no particle within {:.3g} m of it, expected that they "
                      "touch: move one "
                      "of them, or leave bonded_to out",
                      where_is(scene, b), scene.bodies[b].name, scene.bodies[other].name, reach));
    }
  if (!faults.empty()) throw ConfigError(faults);
}

// Returns a warning when the sound speed was chosen for less than the scene's own motion reaches.
std::string warn_of_speed(const Scene& scene, const Plan& plan) {
  const NumericsConfig& n = scene.config.numerics;
  if (!plan.fluid || plan.method != Method::accurate || !(n.max_speed || n.sound_speed)) return "";
  // what a body force drives is estimated from the whole domain, a multiple of what a channel within it reaches
  if (!scene.config.body_force.isZero()) return "";
  const double speed = expected_speed(scene), compression = std::pow(speed / plan.sound_speed, 2);
  const double promise = std::max(expected_compression(plan), kLeastPromise);
  if (compression <= kSpeedMargin * kSpeedMargin * promise) return "";
  return fmt::format(
      "{}: [numerics] {} is {:.3g} m/s, expected that the sound speed suits {:.2g} m/s, which a fall through the "
      "scene's depth, its start or a hand reaches: the fluid will be compressed by up to {:.2g} %, not {:.2g} %; raise "
      "it",
      n.where.empty() ? scene.config.path : n.where, n.sound_speed ? "sound_speed" : "max_speed",
      n.sound_speed.value_or(plan.max_speed), speed, 100 * compression, 100 * promise);
}

// Counts the particles of a fixed body that are the only layer of a wall, thinner than this share of a spacing.
std::size_t thin_particles(const Scene& scene, const Body& body, double share) {
  const double reach = 1.2 * scene.spacing, least = share * (1 - 1e-9) * std::pow(scene.spacing, 3);
  const PeriodicBox box = box_of(scene);
  const auto begin = scene.position.begin() + body.first;
  const std::vector<Eigen::Vector3d> points(begin, begin + body.count);
  const PointGrid grid(points, box, reach);
  std::size_t thin = 0;
  for (std::uint32_t i = 0; i < body.count; ++i) {
    if (scene.volume[body.first + i] >= least) continue;
    int neighbors = 0;
    grid.near(points[i], [&](std::uint32_t j) {
      neighbors += j != i && box.between(points[j], points[i]).norm() < reach ? 1 : 0;
    });
    // within a sheet there are four, in a second layer a fifth
    thin += neighbors <= 4 ? 1 : 0;
  }
  return thin;
}

void warn_of_walls(const Scene& scene, const Plan& plan, std::vector<std::string>& warnings) {
  if (!plan.fluid) return;
  const double share = thinnest(scene, plan);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    if (body.type == BodyKind::elastic || !is_wall_of_particles(scene, plan, b)) continue;
    const std::size_t thin = thin_particles(scene, body, share);
    if (thin * 10 < body.count || thin < 9) continue;
    warnings.push_back(fmt::format(
        "{}: walls of body '{}' are thinner than {:.3g} m at {} of its {} particles and may leak, expected a spacing "
        "({:g} m) or more: make them thicker, or the spacing finer",
        where_is(scene, b), body.name, share * scene.spacing, thin, body.count, scene.spacing));
  }
}

}  // namespace

std::vector<std::string> scene_warnings(const Scene& scene, const Plan& plan) {
  check_bonds(scene, plan);
  std::vector<std::string> warnings;
  if (const std::string speed = warn_of_speed(scene, plan); !speed.empty()) warnings.push_back(speed);
  warn_of_walls(scene, plan, warnings);
  return warnings;
}

}  // namespace palp
