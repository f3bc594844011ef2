#include "sim_server/solver/sleep_plan.h"

#include <algorithm>

#include <fmt/format.h>

#include "config/error.h"
#include "sim_server/solver/body_bounds.h"

namespace palp {

void plan_sleep(const Scene& scene, Plan& plan) {
  const NumericsConfig& n = scene.config.numerics;
  plan.sleeps = plan.fluid && (n.sleep_speed || n.region_of_interest);
  if (!plan.sleeps) return;
  plan.sleep_interval = std::max(1, static_cast<int>(kSleepInterval * scene.config.rate_hz));
  if (!plan.heat && !plan.change) return;
  throw ConfigError(fmt::format(
      "{}: numerics.{} is set in a scene with heat, which fluid that sleeps would not conduct, expected a scene "
      "without: leave that key out, or the conductivity of the materials",
      scene.config.path, n.sleep_speed ? "sleep_speed" : "region_of_interest"));
}

std::string describe_sleep(const Plan& plan, const Scene& scene) {
  if (!plan.sleeps) return "";
  const NumericsConfig& n = scene.config.numerics;
  std::string text = n.sleep_speed ? fmt::format(", fluid slower than {:.3g} mm/s sleeps", 1e3 * *n.sleep_speed)
                                   : std::string(", fluid sleeps");
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

}  // namespace palp
