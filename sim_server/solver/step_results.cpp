#include "sim_server/solver/step_results.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "idl/convert.h"
#include "sim_server/solver/heat_plan.h"
#include "sim_server/solver/rigid_motion.h"

namespace palp {
namespace {

CouplingGains clipped(const CouplingGains& asked, const CouplingGains& limit) {
  return {std::clamp(asked.stiffness, 0.0, limit.stiffness), std::clamp(asked.damping, 0.0, limit.damping),
          std::clamp(asked.angular_stiffness, 0.0, limit.angular_stiffness),
          std::clamp(asked.angular_damping, 0.0, limit.angular_damping)};
}

// Returns true for an input that is finite and small enough to stay so in single precision, and has a rotation.
bool is_sane(const DeviceInput& in) {
  constexpr double kLimit = 1e6;
  const RigidState& s = in.state;
  for (const Eigen::Vector3d& v : {s.position, s.linear, s.angular})
    if (!(v.cwiseAbs().maxCoeff() < kLimit) || !v.allFinite()) return false;
  const double turn = s.orientation.norm();
  return turn > 0.5 && turn < 2 && is_finite(in.gains);
}

bool is_finite(const BodyState& b) {
  return b.x.allFinite() && b.q.coeffs().allFinite() && b.v.allFinite() && b.w.allFinite() && b.L.allFinite() &&
         b.force_sum.allFinite() && b.torque_sum.allFinite() && b.coupling_sum.allFinite();
}

// Returns the largest speed of the corners of the box around a body's particles that were left out [m/s].
double fastest_corner(const Body& body, const BodyState& b) {
  double speed = 0;
  for (int c = 0; c < 8; ++c) {
    const auto which = static_cast<Eigen::AlignedBox3d::CornerType>(c);
    const Eigen::Vector3d at = body.extent.corner(which) - body.orientation.conjugate() * body.position - body.center;
    const Vec3 r = b.q * at.cast<real>();
    speed = std::max(speed, static_cast<double>((b.v + b.w.cross(r)).norm()));
  }
  return speed;
}

// The share of the sound speed that a tool's points keep below where there is fluid: that of an accuracy level is at
// least seven times the speed of a hand, 1 m/s, so that only jumps are held back. At this share fluid that a tool
// throws in front of it stays below the sound speed.
constexpr double kFastestTool = 0.3;

// Returns the largest speed of a tool's points that what is around it can take [m/s]. Contact with matter that deforms
// stores energy by the depth of its particles. Where a leap over several of them makes that depth, no force has done
// the work: a tool that leapt some five spacings a sub-step was thrown out at 3700 m/s. A spacing a sub-step is at
// least plan.max_speed (limit_by_contact() in sub_steps.cpp).
double fastest_tool(const Scene& scene, const Plan& plan) {
  const double in_fluid = plan.fluid ? kFastestTool * plan.sound_speed : 1e30;
  const bool deforms = plan.fields && (plan.elastic || plan.change);
  return std::min(in_fluid, deforms ? scene.spacing / plan.dt : 1e30);
}

// The noise of encoders with a hand at rest, which tells the blend nothing.
constexpr double kNoiseDistance = 1e-5;  // [m]
constexpr double kNoiseSpeed = 1e-3;     // [m/s]
constexpr double kNoiseAngle = 1e-4;     // [rad]
constexpr double kNoiseSpin = 0.02;      // [rad/s]

}  // namespace

StepResults::StepResults(const Scene& scene, const Plan& plan)
    : scene_(scene),
      plan_(plan),
      step_(1.0 / scene.config.rate_hz),
      watch_(scene, plan),
      memory_(scene.proxies.size()) {}

void StepResults::reset(const std::vector<BodyState>& bodies, StepOutput& out) {
  memory_.assign(scene_.proxies.size(), {});
  watch_.reset();
  out = StepOutput{};
  out.proxies.resize(scene_.proxies.size());
  out.bodies.resize(scene_.bodies.size());
  for (std::uint32_t b = 0; b < bodies.size(); ++b)
    if (scene_.bodies[b].type != BodyKind::fluid && !plan_.changes[b]) read_body(b, bodies[b], out.bodies[b]);
  for (std::size_t p = 0; p < scene_.proxies.size(); ++p)
    read_proxy(p, DeviceInput{}, bodies[scene_.proxies[p].body], out.proxies[p]);
  memory_.assign(scene_.proxies.size(), {});
}

void StepResults::fill(const StepInput& input, double time, StepBlock& block) {
  const SceneConfig& config = scene_.config;
  // gravity grows smoothly, so that a column of fluid settles instead of ringing
  const double ramp = config.gravity_ramp > 0 && time < config.gravity_ramp
                          ? 0.5 * (1 - std::cos(EIGEN_PI * time / config.gravity_ramp))
                          : 1.0;
  const Eigen::Vector3d gravity = ramp * config.gravity;
  Eigen::Vector3d level = gravity;
  for (int a = 0; a < 3; ++a)
    if (config.periodic[a]) level[a] = 0;
  if (gravity_ != gravity + config.body_force) disturb();
  const bool changed = changed_for_ > 0;
  changed_for_ -= changed ? 1 : 0;
  gravity_ = gravity + config.body_force;
  block.forcing = {gravity.cast<real>(), level.cast<real>(), config.body_force.cast<real>(), changed};
  block.heat_zones = heat_zones_on(config, time + 0.5 * step_);
  for (std::size_t p = 0; p < scene_.proxies.size(); ++p) {
    // a device that sends nonsense counts as let go
    const DeviceInput in = input_[p] = is_sane(input[p]) ? input[p] : DeviceInput{};
    block.proxy[p].engaged = in.engaged;
    block.proxy[p].gains = clipped(in.gains, scene_.proxies[p].limit).cast<real>();
    block.proxy[p].fastest = static_cast<real>(fastest_tool(scene_, plan_));
    RigidState device = in.state;
    device.orientation.normalize();
    block.proxy[p].device = device.cast<real>();
  }
}

void StepResults::read(const BodyState* bodies, const HealthSums& sums, std::uint32_t neighbor_overflow,
                       StepOutput& out) {
  judge(sums, neighbor_overflow, out.health);
  if (bodies == nullptr || !plan_.wrench) return;
  for (std::uint32_t b : plan_.reactive) {
    // forces on fixed bodies that elastic ones are bonded to are complete only where a probe asks for them
    if (scene_.bodies[b].type == BodyKind::fixed && !plan_.probed[b]) continue;
    if (is_finite(bodies[b])) read_body(b, bodies[b], out.bodies[b]);
  }
  for (std::size_t p = 0; p < scene_.proxies.size(); ++p) {
    const BodyState& state = bodies[scene_.proxies[p].body];
    if (is_finite(state)) read_proxy(p, input_[p], state, out.proxies[p]);
  }
  for (std::uint32_t b : plan_.rigid) {
    const BodyState& state = bodies[b];
    if (is_finite(state)) {
      out.health.kinetic_energy += 0.5 * state.mass * state.v.squaredNorm() + 0.5 * state.L.dot(state.w);
      if (scene_.bodies[b].count < scene_.bodies[b].sites)
        out.health.max_speed = std::max(out.health.max_speed, fastest_corner(scene_.bodies[b], state));
      continue;
    }
    out.health.ok = false;
    out.health.cause =
        fmt::format("body '{}' has a non-finite state: its contact or coupling is unstable", scene_.bodies[b].name);
  }
}

void StepResults::read_body(std::uint32_t index, const BodyState& b, BodyOutput& out) const {
  const Body& body = scene_.bodies[index];
  out.state.orientation = b.q.cast<double>();
  if (body.type == BodyKind::elastic) out.state.orientation = out.state.orientation * body.orientation;
  const Eigen::Vector3d r = out.state.orientation * -body.center;
  out.state.angular = b.w.cast<double>();
  out.state.position = b.x.cast<double>() + r;
  out.state.linear = b.v.cast<double>() + out.state.angular.cross(r);
  out.force = b.force_sum.cast<double>() / plan_.sub_steps;
  out.torque = b.torque_sum.cast<double>() / plan_.sub_steps;
}

void StepResults::read_proxy(std::size_t index, const DeviceInput& input, const BodyState& b, ProxyOutput& out) {
  const RigidState proxy = out.state = handle_of(b).cast<double>();
  out.gains = clipped(input.gains, scene_.proxies[index].limit);
  const Eigen::Vector3d r = (b.q * b.handle).cast<double>();
  out.contact_force = b.force_sum.cast<double>() / plan_.sub_steps;
  out.contact_torque = b.torque_sum.cast<double>() / plan_.sub_steps - r.cross(out.contact_force);
  ProxyMemory& m = memory_[index];
  if (!input.engaged) {
    out.device = input.state;
    out.force.setZero();
    out.torque.setZero();
    out.blend = {};
    m = {};
    return;
  }
  out.device = extrapolate(input.state, step_);
  const CouplingGains& gains = out.gains;
  const Wrench<double> wrench = coupling_wrench(gains, out.device, proxy);
  out.force = wrench.force;
  out.torque = wrench.torque;
  out.energy[0] += b.work[0];
  out.energy[1] += b.work[1];
  if (!m.known) m.slow = out.device;
  m.known = true;
  const double share = ContactBlend::share_of_slow_mean(step_);
  m.slow.position += share * (out.device.position - m.slow.position);
  m.slow.linear += share * (out.device.linear - m.slow.linear);
  m.slow.orientation = m.slow.orientation.slerp(share, out.device.orientation);
  m.slow.angular += share * (out.device.angular - m.slow.angular);
  const RigidState stopped = at_rest(proxy.position, proxy.orientation);
  const Eigen::Vector3d weight = b.mass * gravity_;
  const Wrench<double> demand = coupling_wrench(gains, m.slow, out.device);
  const Wrench<double> held = coupling_wrench(gains, stopped, out.device);
  // the part of a contact's force that stops the proxy's own mass is no answer to the device
  const Eigen::Vector3d force = clamp_norm(out.contact_force, (out.force - weight).norm());
  const Eigen::Vector3d torque = clamp_norm(out.contact_torque, (out.torque + r.cross(weight)).norm());
  out.blend[0] = m.linear.update(force, demand.force, held.force + weight,
                                 gains.stiffness * kNoiseDistance + gains.damping * kNoiseSpeed, step_);
  out.blend[1] = m.angular.update(torque, demand.torque, held.torque - r.cross(weight),
                                  gains.angular_stiffness * kNoiseAngle + gains.angular_damping * kNoiseSpin, step_);
  // a bridge holds this force until the next step, so it is the mean that moved the proxy in this one; at the step's
  // end the coupling has mostly caught up with the device and pulls less
  const Eigen::Vector3d mean = -b.coupling_sum.cast<double>() / plan_.sub_steps;
  out.force += (1 - out.blend[0]) * (mean - wrench.force);
}

void StepResults::judge(const HealthSums& sums, std::uint32_t neighbor_overflow, Health& health) {
  health.ok = true;
  health.cause.clear();
  health.non_finite = sums.non_finite;
  health.outside = sums.outside;
  health.inactive = sums.inactive;
  health.asleep = sums.asleep;
  health.inactive_mass = sums.inactive_mass;
  health.max_speed = sums.max_speed;
  health.max_compression = sums.max_compression;
  health.mean_compression = sums.fluid_mass > 0 ? sums.compressed_mass / sums.fluid_mass : 0;
  health.kinetic_energy = sums.kinetic_energy;
  health.solves = plan_.elastic_rounds > 0;
  health.unsolved = sums.unsolved;
  watch_.judge(health);
  if (sums.non_finite > 0) {
    health.ok = false;
    health.cause = fmt::format("{} particles have a non-finite state: the simulation has diverged", sums.non_finite);
  } else if (neighbor_overflow > 0) {
    health.ok = false;
    health.cause = "particles have crowded to more than twice their density: the simulation has diverged";
  } else if (plan_.fluid && plan_.method == Method::accurate && sums.max_mach > 1) {
    health.ok = false;
    health.cause = fmt::format(
        "a particle moves at {:.3g} m/s, faster than the sound speed {:.3g} m/s: the simulation has diverged, or "
        "numerics.max_speed is too low for this scene",
        sums.max_speed, sums.max_speed / sums.max_mach);
  } else if (plan_.fluid && plan_.method == Method::accurate && sums.max_compression > 0.5) {
    health.ok = false;
    health.cause = fmt::format(
        "a particle is compressed by {:.0f} %: the simulation has diverged, or something squeezes the fluid: press "
        "less, or raise numerics.max_speed",
        100 * sums.max_compression);
  }
}

}  // namespace palp
