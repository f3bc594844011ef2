// Two-port passivity in the time domain, for force or for torque: coupling and network may give the hand what the
// simulation put into the coupling, and no more (time-domain passivity: Hannaford & Ryu 2002; both ports: Ryu, Artigas
// & Preusche 2010). The simulation's share is why a current still moves the hand: with one port its work would be taken
// for the coupling's and damped away.
//   E' = E - W . dx + dW_E + b |v|^2 dt, at most a cap;   E < 0: W -= al v, al = -E / (dt max(|v|^2, v0^2))
// What the coupling's spring holds counts beside the cap: a hand that is pushed back out of a wall gets its own work
// back. No allocation, no lock, no throw.
#pragma once

#include <algorithm>

#include <Eigen/Core>

namespace palp {

// Returns the energy [J] of a spring of this stiffness [N/m, N m/rad] that pulls with so much [N, N m].
inline double spring_energy(const Eigen::Vector3d& pull, double stiffness) {
  return stiffness > 0 ? pull.squaredNorm() / (2 * stiffness) : 0;
}

struct PassivityConfig {
  double start = 8e-3;           // energy that the coupling begins with [J]
  double most = 50e-3;           // surplus past this and the spring's is forgotten; it holds what is in flight [J]
  double device_damping = 0;     // of the arm, as identified, never more: a credit [N s/m, N m s/rad]
  double slowest = 0.01;         // v0: below this speed the damping does not grow further [m/s, rad/s]
  double most_damping = 10;      // that this arm can render [N s/m, N m s/rad]
  double settling_time = 0.005;  // of the damping [s]
};

class PassivityController {
 public:
  explicit PassivityController(const PassivityConfig& config) : config_(config), energy_(config.start) {}

  // Begins anew, when force has ended or comes back.
  void reset() {
    energy_ = config_.start;
    damping_ = 0;
  }
  // One tick of dt [s] has passed. sent: the wrench on the hand meanwhile; moved: what the device did [m, rad];
  // v: its velocity; received: work of the simulation on the coupling that became known [J]; stored: in the coupling's
  // spring, at most [J].
  void observe(const Eigen::Vector3d& sent, const Eigen::Vector3d& moved, const Eigen::Vector3d& v, double received,
               double stored, double dt) {
    energy_ += received - sent.dot(moved) + config_.device_damping * v.squaredNorm() * dt;
    energy_ = std::min(energy_, config_.most + stored);
    const double v2 = std::max(v.squaredNorm(), config_.slowest * config_.slowest);
    const double wanted = energy_ < 0 ? std::min(-energy_ / (dt * v2), config_.most_damping) : 0;
    damping_ += std::min(1.0, dt / config_.settling_time) * (wanted - damping_);
    if (wanted == 0 && damping_ < kNothing) damping_ = 0;
  }
  double energy() const { return energy_; }    // [J]
  double damping() const { return damping_; }  // to be added to the wrench, times -v

 private:
  static constexpr double kNothing = 1e-6;  // a damping that nobody feels
  PassivityConfig config_;
  double energy_;
  double damping_ = 0;
};

}  // namespace palp
