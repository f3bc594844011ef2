#include "tools/stability_map/books.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim_server/physics/walls.h"
#include "sim_server/probes/penetration.h"
#include "sim_server/solver/constants.h"
#include "sim_server/solver/rigid_motion.h"

namespace palp::stability {
namespace {

using Eigen::Vector3d;

// The share of the energy that was turned over which may appear: what the coarsest level creates where matter meets,
// and as much more as its fastest part moves in a sub-step, in spacings. Symplectic Euler keeps not the energy that is
// counted here, but one that differs by half a sub-step times the power: a block that flies through its own middle by
// half a spacing a sub-step seemed to gain 0.21, and with a quarter of the sub-step 0.05. At most kCreatedMost: where a
// simulation is unstable, the share comes close to 1.
constexpr double kCreated = 0.05, kCreatedMost = 0.3;
// Likewise of method "paper", whose pressure force (Eq. 2) is only nearly the gradient of an energy, and whose elastic
// force (Eq. 4) of none.
constexpr double kCreatedByPaper = 0.3;
// The share of the sum of all impulses that may be missing: single precision over the steps of a cell.
constexpr double kLost = 1e-3;
// The share of the sound speed at which matter may be agitated without a cause: fluids by their particles' settling, as
// a compression by one percent, which levels of accuracy allow by design; solids by their rounding.
constexpr double kFluidNoise = 0.01, kSolidNoise = 1e-4;
constexpr double kRounding = std::numeric_limits<float>::epsilon();

Vector3d vector_at(const std::vector<float>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

// Returns the place at which gravity's potential is counted for what is at x with velocity v: by symplectic Euler
// velocities belong to the middle of the sub-step that ended at x.
Vector3d before(const Vector3d& x, const Vector3d& v, double sub_step) { return x - sub_step / 2 * v; }

bool is_soft(const Body& body) { return body.type == BodyKind::fluid || body.type == BodyKind::elastic; }

}  // namespace

Books::Books(Simulation& simulation, const Plan& plan)
    : simulation_(simulation),
      scene_(simulation.scene()),
      sound_speed_(plan.sound_speed),
      tool_(scene_.bodies.size(), false) {
  for (const Proxy& proxy : scene_.proxies) tool_[proxy.body] = true;
  for (const Body& body : scene_.bodies)
    if (body.type == BodyKind::fixed && !scene_.proxies.empty()) closed_ = false;
  gone_.assign(scene_.position.size(), 0);
  simulation_.snapshot(snapshot_);
  sub_step_ = 1 / (scene_.config.rate_hz * simulation.sub_steps());
  fluid_step_ = simulation.fluid_interval() * sub_step_;
  weigh(plan.sound_speed);
  follow_waves(plan);
  if (scene_.config.method == Method::accurate) released_ += stored_by_guard();
  for (const Vector3d& v : scene_.velocity) fastest_ = std::max(fastest_, v.norm());
  start_ = last_ = sums(simulation_.output());
  if (snapshot_.temperature.empty()) return;
  const auto [low, high] = std::minmax_element(snapshot_.temperature.begin(), snapshot_.temperature.end());
  coldest_ = *low;
  hottest_ = *high;
  for (const Body& body : scene_.bodies) {  // those without particles, too
    coldest_ = std::min(coldest_, body.temperature.value_or(coldest_));
    hottest_ = std::max(hottest_, body.temperature.value_or(hottest_));
  }
}

void Books::weigh(double sound_speed) {
  mass_of_.assign(scene_.position.size(), 0);
  const double far = scene_.bounds_min.cwiseAbs().cwiseMax(scene_.bounds_max.cwiseAbs()).maxCoeff();
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const Body& body = scene_.bodies[b];
    const MaterialConfig& m = scene_.config.materials[body.material];
    const bool denser = body.type == BodyKind::fluid && scene_.config.method == Method::accurate;
    double volume = 0, mass = 0;
    for (std::size_t i = body.first; i < body.first + body.count; ++i) {
      volume += scene_.volume[i];
      mass += mass_of_[i] = scene_.volume[i] * (denser ? snapshot_.density[i] : m.density);
    }
    if (is_soft(body)) mass_ += mass;
    const double flowing = body.type == BodyKind::fluid ? kFluidNoise * sound_speed : 0;
    // what freezes is a solid, whatever it began as, and its bonds are as long as its places are apart, which tremble
    // by their rounding; elastic bodies have displacements
    double solid = is_soft(body) && m.young_modulus ? kSolidNoise * std::sqrt(*m.young_modulus / m.density) : 0;
    if (flowing > 0) solid += solid > 0 ? kRounding * far / sub_step_ : 0;
    const double c = std::max(flowing, solid);
    noise_ += mass / 2 * c * c;
    agitation_ += mass * c;
    // snapshots have places in single precision
    if (is_soft(body)) noise_ += mass * scene_.config.gravity.norm() * kRounding * far;
    if (body.type == BodyKind::rigid) noise_ += body.mass / 2 * std::pow(kRounding * far / sub_step_, 2);
    if (body.type == BodyKind::rigid && !tool_[b]) mass_ += body.mass;
    if (body.type != BodyKind::fluid) continue;
    // attraction can make a single drop of all particles, whose first surface is at most that of the body and of one
    // particle more
    const double tension = std::max(m.surface_tension, m.adhesion);
    released_ += 6 * tension * (std::pow(volume, 2.0 / 3) + scene_.spacing * scene_.spacing);
  }
}

// Sets how far waves go in a sub-step, in spacings. An implicit solve damps its waves, and needs no allowance.
void Books::follow_waves(const Plan& plan) {
  waves_.assign(scene_.bodies.size(), 0);
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const Body& body = scene_.bodies[b];
    const MaterialConfig& m = scene_.config.materials[body.material];
    double speed = 0;
    if (body.type == BodyKind::fluid) speed = sound_speed_in(scene_, plan, m);
    if (body.type == BodyKind::elastic && plan.elastic_rounds == 0) speed = pressure_wave_speed(m);
    waves_[b] = speed * (body.type == BodyKind::fluid ? fluid_step_ : sub_step_) / scene_.spacing;
  }
}

// Returns the energy with which solids push fluid away that begins at their surface or within them
// (physics/walls.h) [J].
double Books::stored_by_guard() const {
  double stored = 0;
  const double reach = kGuardReach * scene_.spacing;
  const double stiffness = kGuardStiffness * sound_speed_ * sound_speed_ / (reach * scene_.spacing);
  PenetrationMeter(scene_).each_near(reach, snapshot_, simulation_.output(), [&](std::size_t i, double distance) {
    const bool flows = scene_.bodies[scene_.body[i]].type == BodyKind::fluid;
    stored += flows ? mass_of_[i] * stiffness / 2 * (reach - distance) * (reach - distance) : 0;
  });
  return stored;
}

// Returns the energy that a fluid particle has stored by compression, the integral of p / rho^2 by rho [J/kg].
double Books::compression(std::size_t i, double density) const {
  const double ratio = snapshot_.density[i] / density;
  if (!(ratio > 1 + 1e-6) || !(snapshot_.pressure[i] > 0)) return 0;
  const double c2 = snapshot_.pressure[i] / (snapshot_.density[i] - density);
  double share = 1;
  if (scene_.config.method == Method::paper) {
    // as Eq. 2 has half of the pressure's gradient, and bonds leave this much of it (physics/bonded.h)
    const double liquid = snapshot_.solid.empty() ? 1 : 1 - snapshot_.solid[i];
    share = 0.5 * liquid * liquid;
  }
  return share * c2 * (std::log(ratio) + 1 / ratio - 1);
}

// Returns the energy of the pressure that the particles of a solid have by method "paper", with which
// they push like those of a fluid, half of p^2 / (2 rho c^2) by volume [J].
double Books::stored_by_pushing(std::size_t b) const {
  const Body& body = scene_.bodies[b];
  const double modulus = scene_.config.materials[body.material].density * sound_speed_ * sound_speed_;
  double stored = 0;
  for (std::size_t i = body.first; i < body.first + body.count; ++i) {
    const double p = std::max(0.0f, snapshot_.pressure[i]);
    stored += modulus > 0 ? scene_.volume[i] * p * p / (4 * modulus) : 0;
  }
  return stored;
}

void Books::add_particles(std::size_t b, Sums& out) {
  const Body& body = scene_.bodies[b];
  const double density = scene_.config.materials[body.material].density;
  const double step = body.type == BodyKind::fluid ? fluid_step_ : sub_step_;
  double moving = 0, strained = 0;  // kinetic energy, and what it swings with
  for (std::size_t i = body.first; i < body.first + body.count; ++i) {
    if (!snapshot_.inactive.empty() && snapshot_.inactive[i] != 0) {
      out.potential += gone_[i];
      continue;
    }
    const double m = mass_of_[i];
    const Vector3d v = vector_at(snapshot_.velocity, i);
    const double kinetic = m / 2 * v.squaredNorm();
    const double potential = -m * scene_.config.gravity.dot(before(vector_at(snapshot_.position, i), v, step));
    const double stored = (snapshot_.stored.empty() ? 0.0 : snapshot_.stored[i]) +
                          (body.type == BodyKind::fluid ? m * compression(i, density) : 0.0);
    gone_[i] = kinetic + potential + stored;
    out.kinetic += kinetic;
    out.potential += potential;
    out.stored += stored;
    moving += kinetic;
    strained += stored;
    out.momentum += m * v;
    out.momenta += m * v.norm();
  }
  // contact may hold less than none
  out.swing += waves_[b] * std::sqrt(moving * std::max(strained, 0.0));
}

Books::Sums Books::sums(const StepOutput& output) {
  Sums out;
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
    const Body& body = scene_.bodies[b];
    if (scene_.config.method == Method::paper && !is_soft(body)) out.stored += stored_by_pushing(b);
    if (body.type == BodyKind::fixed) continue;
    if (is_soft(body)) {
      add_particles(b, out);
      continue;
    }
    const RigidMomenta whole = momenta_of(body, output.bodies[b].state);
    out.kinetic += whole.kinetic;
    const Vector3d v = whole.momentum / body.mass;
    const Vector3d at = tool_[b] ? whole.center : before(whole.center, v, sub_step_);  // tools are moved implicitly
    out.potential -= body.mass * scene_.config.gravity.dot(at);
    if (tool_[b]) continue;
    out.momentum += whole.momentum;
    out.momenta += whole.momentum.norm();
  }
  return out;
}

void Books::note(const StepOutput& output) {
  const double step = output.time - time_;
  time_ = output.time;
  const auto act = [&](const Vector3d& force) {
    impulse_ += step * force;
    impulses_ += step * force.norm();
  };
  act(mass_ * scene_.config.gravity);
  for (std::size_t b = 0; b < scene_.bodies.size(); ++b)
    if (scene_.bodies[b].type == BodyKind::fixed) act(-output.bodies[b].force);
  double work = 0;
  for (const ProxyOutput& proxy : output.proxies) {
    act(-proxy.contact_force);
    work -= proxy.energy[0] + proxy.energy[1];
  }
  work_absolute_ += std::abs(work - last_work_);
  work_ = last_work_ = work;
  closed_ = closed_ && output.health.outside == 0;
  fastest_ = std::max(fastest_, output.health.max_speed);
}

void Books::check(const StepOutput& output) {
  simulation_.snapshot(snapshot_);
  const Sums now = sums(output);
  // method "paper" knows its density from the first step on
  if (output.step == 1 && scene_.config.method == Method::paper) {
    start_.stored = now.stored;
    // elastic particles that begin among others are pushed out; later their pressure is mostly that of their own body,
    // which does not push
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b)
      if (scene_.bodies[b].type == BodyKind::elastic) released_ += stored_by_pushing(b);
  }
  turned_over_ += std::abs(now.potential - last_.potential);
  last_ = now;
  const double before = start_.kinetic + start_.potential + start_.stored,
               after = now.kinetic + now.potential + now.stored;
  const double moved = fastest_ * fluid_step_ / scene_.spacing;
  const double share =
      std::max(std::min(kCreated + moved, kCreatedMost), scene_.config.method == Method::paper ? kCreatedByPaper : 0);
  const double created = after - before - work_ - released_;
  const double scale =
      start_.kinetic + start_.stored + now.kinetic + now.stored + turned_over_ + work_absolute_ + released_;
  balance_.energy = std::max(balance_.energy, created / (share * scale + now.swing + noise_ + 1e-30));
  if (closed_) {
    const double missing = (now.momentum - start_.momentum - impulse_).norm();
    balance_.momentum = std::max(balance_.momentum,
                                 missing / (kLost * (impulses_ + start_.momenta + now.momenta + agitation_) + 1e-30));
  }
  check_heat();
}

void Books::check_heat() {
  for (const float T : snapshot_.temperature) {
    const double past = std::max(T - hottest_, coldest_ - T);
    balance_.heat = std::max(balance_.heat, past / (1e-4 * hottest_));
  }
}

}  // namespace palp::stability
