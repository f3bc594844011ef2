#include "sim_server/messages_from_state.h"

#include <span>

#include "idl/convert.h"
#include "sim_server/scene/scene_heat.h"

namespace palp {
namespace {

// Particles of an elastic body up to which it is drawn by a surface that they carry along: beyond, its description
// would be many megabytes.
constexpr std::uint32_t kMostSkinned = 100'000;

// Appends where each place is shown.
void append(std::span<const Eigen::Vector3d> places, std::vector<float>& to, const Eigen::Isometry3d& shown) {
  to.reserve(3 * places.size());
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Vector3f x = (shown * place).cast<float>();
    to.insert(to.end(), {x.x(), x.y(), x.z()});
  }
}

BodyDescription describe_body(const Scene& scene, const Body& body) {
  BodyDescription out;
  out.name = body.name;
  out.kind = body.type;
  out.first = body.first;
  out.count = body.count;
  out.density = scene.config.materials[body.material].density;
  out.color = body.color;
  out.look = body.look;
  out.changed_color = body.changed_color;
  out.changed_look = body.changed_look;
  const bool soft = body.type == BodyKind::elastic && body.count <= kMostSkinned && !changes_state(scene, body);
  const SurfaceMesh& surface = soft ? body.skin : body.surface;
  // fixed and elastic bodies have no pose on the bus: their surface is given where it is
  const bool posed = body.type == BodyKind::rigid;
  Eigen::Isometry3d shown = Eigen::Isometry3d::Identity();
  if (!posed) shown.translate(body.position).rotate(body.orientation);
  append(surface.vertices, out.vertices, shown);
  out.triangles.reserve(3 * surface.triangles.size());
  for (const auto& t : surface.triangles) out.triangles.insert(out.triangles.end(), t.begin(), t.end());
  if (soft && !surface.triangles.empty())
    append(std::span(scene.position).subspan(body.first, body.count), out.rest, Eigen::Isometry3d::Identity());
  return out;
}

}  // namespace

SceneDescription describe_scene(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  SceneDescription out;
  out.name = scene.config.name;
  out.method = to_string(scene.config.method);
  out.numerics = simulation.numerics();
  out.scene_hash = scene.config.hash;
  out.particle_count = static_cast<std::uint32_t>(scene.position.size());
  out.spacing = scene.spacing;
  out.support_radius = simulation.support_radius();
  out.haptic_rate_hz = scene.config.rate_hz;
  out.bounds_min = to_array(scene.bounds_min);
  out.bounds_max = to_array(scene.bounds_max);
  out.gravity = to_array(scene.config.gravity);
  for (const Body& body : scene.bodies) out.bodies.push_back(describe_body(scene, body));
  for (const Proxy& proxy : scene.proxies) {
    const Body& body = scene.bodies[proxy.body];
    const RigidState handle = at_rest(body.position + body.orientation * proxy.handle, body.orientation);
    out.proxies.push_back({proxy.device, proxy.body, to_pose(handle)});
  }
  return out;
}

BodyPoses body_poses(const Scene& scene, const StepOutput& output) {
  BodyPoses out;
  out.sim_time = output.time;
  for (std::uint32_t b = 0; b < scene.bodies.size(); ++b) {
    if (scene.bodies[b].type != BodyKind::rigid) continue;
    out.body.push_back(b);
    out.pose.push_back(to_pose(output.bodies[b].state));
  }
  return out;
}

ProxySample make_proxy_sample(const ProxyOutput& proxy, std::uint32_t device_number, const DeviceSample& device,
                              bool engaged, ServerState state, double sim_time) {
  const bool running = state == ServerState::running;
  ProxySample s;
  s.device = device_number;
  s.flags = (state != ServerState::fault ? kHealthy : 0u) | (state == ServerState::paused ? kPaused : 0u) |
            (engaged && running ? kEngaged : 0u);
  s.sim_time = sim_time;
  s.device_session = device.header.session;
  s.device_sequence = device.header.sequence;
  s.t_device_ns = device.t_device_ns;
  s.device_pose = to_pose(proxy.device);
  s.device_twist = to_twist(proxy.device);
  s.proxy_pose = to_pose(proxy.state);
  s.proxy_twist = to_twist(proxy.state);
  if (running) {
    s.wrench = {to_array(proxy.force), to_array(proxy.torque)};
    s.blend = proxy.blend;
  }
  // of a proxy without a hand: none, so that no bridge finds them beyond those it asked for
  if (engaged) s.gains = proxy.gains;
  s.energy = proxy.energy;
  return s;
}

bool repeat(ProxySample& sample, int times) {
  if (!(sample.flags & kEngaged) || times >= kMostRepeats) return false;
  sample.flags |= kRepeated;
  return true;
}

}  // namespace palp
