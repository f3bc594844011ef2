// The coupling's gains for the link there is. A delayed spring of stiffness K gives energy like a damper of -K t, t
// its delay; so K t stays below what hand, arm and passivity controller take up (K < b / (T/2 + t): Diolaiti, Niemeyer,
// Barbagli & Salisbury 2006). The local model holds most of the stiffness on this side of the link, so the bound is
// well above the damping of any arm; palp-haptic-bench shows where it lies. The proposal goes to the server with each
// device sample and comes back with each proxy sample, so both ends always use the same gains.
//
// A delay feeds a swing of the hand only while it lasts: of a gap that is over before the swing has turned, what counts
// is its mean over a part of the swing. And a spring that becomes stiffer while it is bent gives the hand energy, as
// one that becomes softer takes it; so gains fall at once, and rise fast only while the coupling carries next to
// nothing.
// No allocation, no lock, no throw.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "idl/messages.h"

namespace palp {

struct GovernorConfig {
  double budget = 45;            // most K (T/2 + t): palp-haptic-bench found more stable on all links [N s/m]
  double angular_budget = 0.45;  // [N m s/rad]
  double memory = 2;             // a long delay counts for so long [s]
  double slowest_rise = 0.5;     // of the gains' share in a second
};

class GainGovernor {
 public:
  // gains: the most that is ever proposed. period: of the loop [s].
  GainGovernor(const GovernorConfig& config, const CouplingGains& gains, double period)
      : config_(config), most_(gains), period_(period) {}

  // A sample came in use whose device state is so old.
  void note_delay(std::int64_t delay_ns) { delay_ = std::max(delay_, 1e-9 * static_cast<double>(delay_ns)); }
  // Once a tick. delay: age of the device state that is rendered from; force, torque: of the coupling on the scene's
  // side [N, N m].
  void update(std::int64_t delay_ns, double force, double torque) {
    const double forgotten = period_ / config_.memory;
    delay_ -= forgotten * delay_;
    recent_ += std::min(1.0, period_ / kPartOfSwing) * (1e-9 * static_cast<double>(delay_ns) - recent_);
    lasting_ = std::max(lasting_ - forgotten * lasting_, recent_);
    const double t = 0.5 * period_ + std::min(delay_, kAboveMean * lasting_);
    linear_ = toward(linear_, config_.budget, most_.stiffness * t, force > kLightForce);
    angular_ = toward(angular_, config_.angular_budget, most_.angular_stiffness * t, torque > kLightTorque);
  }
  CouplingGains gains() const {
    return {linear_ * most_.stiffness, std::sqrt(linear_) * most_.damping, angular_ * most_.angular_stiffness,
            std::sqrt(angular_) * most_.angular_damping};
  }
  double share() const { return std::min(linear_, angular_); }  // 1: nothing is lowered

 private:
  double toward(double share, double budget, double used, bool bent) const {
    const double wanted = used > budget ? budget / used : 1;
    const double rise = bent ? kRiseWhileBent * share : config_.slowest_rise;
    return wanted < share ? wanted : std::min(wanted, share + rise * period_);
  }

  static constexpr double kPartOfSwing = 0.1;     // hands swing against a wall at 2 to 10 Hz [s]
  static constexpr double kAboveMean = 1.5;       // a delay that jitters about its mean counts fully
  static constexpr double kRiseWhileBent = 0.02;  // of the gains' share in a second, in proportion
  static constexpr double kLightForce = 0.5;      // more than a light tool takes to be moved about [N]
  static constexpr double kLightTorque = 0.05;    // [N m]

  GovernorConfig config_;
  CouplingGains most_;
  double period_;
  double delay_ = 0;                 // the longest of late [s]
  double recent_ = 0, lasting_ = 0;  // its mean over a part of a swing, and the largest of late [s]
  double linear_ = 1, angular_ = 1;
};

}  // namespace palp
