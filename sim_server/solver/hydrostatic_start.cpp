#include "sim_server/solver/hydrostatic_start.h"

#include <algorithm>
#include <cmath>

#include "sim_server/solver/body_bounds.h"

namespace palp {
namespace {

// Returns true when body b has a particle next to the one of body a that is farthest against gravity along the axis.
bool covers(const Scene& scene, const Body& b, const Body& a, int axis, double gravity) {
  Eigen::Vector3d top = scene.position[a.first];
  for (std::uint32_t i = a.first; i < a.first + a.count; ++i)
    if (gravity * scene.position[i][axis] < gravity * top[axis]) top = scene.position[i];
  for (std::uint32_t i = b.first; i < b.first + b.count; ++i)
    if ((scene.position[i] - top).norm() < 1.5 * scene.spacing && gravity * (scene.position[i] - top)[axis] < 0)
      return true;
  return false;
}

// The load of other fluid bodies on one along one axis.
struct Load {
  double pressure = 0;     // at the face that gravity points away from [Pa]
  double carrying = 1e30;  // density of the fluid around it, where that is below it, too [kg/m^3]
};

// Returns the load of the fluid bodies that lie on the whole of a body, or that it is immersed in.
Load load_on(const Scene& scene, const std::vector<Eigen::AlignedBox3d>& bounds, std::size_t body, int axis) {
  const double dx = scene.spacing, g = scene.config.gravity[axis];
  const Eigen::Vector3d &low = bounds[body].min(), &high = bounds[body].max();
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (b == body || scene.bodies[b].type != BodyKind::fluid || scene.bodies[b].count == 0) continue;
    const Eigen::Vector3d &other_low = bounds[b].min(), &other_high = bounds[b].max();
    const double below = low[axis] - other_low[axis], above = other_high[axis] - high[axis];
    const double distance = g < 0 ? other_low[axis] - high[axis] : low[axis] - other_high[axis];
    bool around = true;
    for (int a = 0; a < 3; ++a)
      around = around && (a == axis || (other_low[a] < low[a] + dx && other_high[a] > high[a] - dx));
    const bool on_top = around && distance > 0.5 * dx && distance < 1.5 * dx;
    const double rises = g < 0 ? above : below;
    const bool immersed =
        around && distance < 0 && rises > 0.5 * dx && covers(scene, scene.bodies[b], scene.bodies[body], axis, g);
    if (!on_top && !immersed) continue;
    const double density = scene.config.materials[scene.bodies[b].material].density;
    const double height = immersed ? rises : other_high[axis] - other_low[axis] + dx;
    const bool carries = immersed && (g < 0 ? below : above) > 0.5 * dx;
    return {density * std::abs(g) * height + load_on(scene, bounds, b, axis).pressure, carries ? density : 1e30};
  }
  return {};
}

// Sets the pressures of one fluid body. A drop in a lighter fluid falls: nothing carries its weight.
void press(const Scene& scene, const std::vector<Eigen::AlignedBox3d>& bounds, std::size_t index,
           std::vector<double>& pressure) {
  const Body& body = scene.bodies[index];
  const double density = scene.config.materials[body.material].density;
  for (int a = 0; a < 3; ++a) {
    const double g = scene.config.gravity[a];
    if (scene.config.periodic[a] || g == 0) continue;
    const double top =
        g < 0 ? bounds[index].max()[a] + 0.5 * scene.spacing : bounds[index].min()[a] - 0.5 * scene.spacing;
    const Load load = load_on(scene, bounds, index, a);
    const double carried = std::min(density, load.carrying);
    for (std::uint32_t i = body.first; i < body.first + body.count; ++i)
      pressure[i] += load.pressure + carried * g * (scene.position[i][a] - top);
  }
}

}  // namespace

std::vector<double> hydrostatic_start(const Scene& scene, const Plan& plan) {
  std::vector<double> pressure(scene.position.size(), 0.0);
  if (plan.method != Method::accurate || scene.config.gravity_ramp != 0) return pressure;
  std::vector<Eigen::AlignedBox3d> bounds;
  for (const Body& body : scene.bodies) bounds.push_back(body_bounds(scene, body));
  for (std::size_t b = 0; b < scene.bodies.size(); ++b)
    if (scene.bodies[b].type == BodyKind::fluid && scene.bodies[b].count > 0) press(scene, bounds, b, pressure);
  return pressure;
}

}  // namespace palp
