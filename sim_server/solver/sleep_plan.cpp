#include "sim_server/solver/sleep_plan.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "config/error.h"
#include "sim_server/solver/body_bounds.h"
#include "sim_server/solver/sub_steps.h"

namespace palp {

void plan_sleep(const Scene& scene, Plan& plan) {
  const NumericsConfig& n = scene.config.numerics;
  plan.sleeps = (plan.fluid || plan.elastic) && (n.sleep_speed || n.region_of_interest);
  if (!plan.sleeps) return;
  plan.sleep_interval = steps_between(kSleepInterval, scene, plan);
  if (n.region_of_interest && !n.sleep_speed && scene.proxies.empty())
    throw ConfigError(fmt::format(
        "{}: numerics.region_of_interest is set in a scene without tools, where everything would stand still, expected "
        "a [[proxy]]: leave that key out, or set sleep_speed, too",
        scene.config.path));
  if (!plan.heat && !plan.change) return;
  throw ConfigError(fmt::format(
      "{}: numerics.{} is set in a scene with heat, which fluid that sleeps would not conduct, expected a scene "
      "without: leave that key out, or the conductivity of the materials",
      scene.config.path, n.sleep_speed ? "sleep_speed" : "region_of_interest"));
}

std::string describe_sleep(const Plan& plan, const Scene& scene) {
  if (!plan.sleeps) return "";
  const NumericsConfig& n = scene.config.numerics;
  std::string text = n.sleep_speed ? fmt::format(", what is slower than {:.3g} mm/s sleeps", 1e3 * *n.sleep_speed)
                                   : std::string(", all sleeps");
  if (n.region_of_interest) text += fmt::format(" farther than {:.3g} m from tools", *n.region_of_interest);
  return text;
}

std::vector<SleepBox> sleep_boxes(const Scene& scene, const Plan& plan) {
  std::vector<SleepBox> boxes;
  for (const std::uint32_t b : plan.rigid) {
    const Body& body = scene.bodies[b];
    const Eigen::AlignedBox3d box = own_bounds(scene, body);
    const Eigen::Vector3d middle = body.orientation.conjugate() * body.position + body.center;
    const Eigen::Vector3d half = 0.5 * box.sizes().array() + 0.5 * scene.spacing;
    const bool tool =
        std::any_of(scene.proxies.begin(), scene.proxies.end(), [b](const Proxy& proxy) { return proxy.body == b; });
    boxes.push_back({(box.center() - middle).cast<real>(), half.cast<real>(), tool});
  }
  return boxes;
}

SleepUnits sleep_units(const Scene& scene, const ElasticStore& store) {
  SleepUnits units;
  const auto count = static_cast<std::uint32_t>(store.tag.size());
  // bodies that share bonded particles get the least of their indices
  std::vector<std::uint32_t> root(scene.bodies.size());
  std::iota(root.begin(), root.end(), 0u);
  // an elastic body that strains the particle: its own one, and of bonded particles that of a neighbour; twice, for
  // what is strained pulls at neighbours that are not
  std::vector<std::uint32_t> held_by(count, kNone);
  for (std::uint32_t k = 0; k < count; ++k)
    if (store.tag[k].kind() == BodyKind::elastic) held_by[k] = store.tag[k].body();
  for (int round = 0; round < 2; ++round) {
    const std::vector<std::uint32_t> known = held_by;
    for (std::uint32_t k = 0; k < count; ++k)
      for (std::uint32_t e = store.first[k]; known[k] == kNone && e < store.first[k + 1]; ++e) {
        const std::uint32_t other = known[ElasticBond{store.neighbor[e]}.j()];
        if (other == kNone) continue;
        if (held_by[k] == kNone) held_by[k] = other;
        const std::uint32_t a = root[held_by[k]], b = root[other];
        std::replace(root.begin(), root.end(), std::max(a, b), std::min(a, b));
      }
  }
  std::vector<std::vector<std::uint32_t>> members(scene.bodies.size());
  std::vector<bool> moves(scene.bodies.size(), false);
  for (std::uint32_t k = 0; k < count; ++k) {
    if (held_by[k] == kNone) continue;
    members[root[held_by[k]]].push_back(k);
    if (store.tag[k].kind() == BodyKind::rigid) moves[root[held_by[k]]] = true;
  }
  for (std::size_t b = 0; b < members.size(); ++b) {
    if (members[b].empty() || moves[b]) continue;
    const Vec3 nowhere(0, 0, 0);  // until it is judged
    units.unit.push_back({static_cast<std::uint32_t>(units.member.size()),
                          static_cast<std::uint32_t>(members[b].size()), 0, nowhere, nowhere});
    units.member.insert(units.member.end(), members[b].begin(), members[b].end());
  }
  return units;
}

}  // namespace palp
