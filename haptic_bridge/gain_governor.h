// The coupling's gains for the link there is. A delayed spring of stiffness K gives energy like a damper of -K t, t
// its delay; so K t stays below what hand, arm and passivity controller take up (K < b / (T/2 + t): Diolaiti, Niemeyer,
// Barbagli & Salisbury 2006). The local model holds most of the stiffness on this side of the link, so the bound is
// well above the damping of any arm; palp_haptic_bench shows where it lies. The proposal goes to the server with each
// device sample and comes back with each proxy sample, so both ends always use the same gains.
// No allocation, no lock, no throw.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "idl/messages.h"

namespace palp {

struct GovernorConfig {
  double budget = 45;            // most K (T/2 + t): palp_haptic_bench found more stable on all links [N s/m]
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
  // Once a tick.
  void update() {
    delay_ -= period_ / config_.memory * delay_;
    const double t = 0.5 * period_ + delay_;
    linear_ = toward(linear_, config_.budget, most_.stiffness * t);
    angular_ = toward(angular_, config_.angular_budget, most_.angular_stiffness * t);
  }
  CouplingGains gains() const {
    return {linear_ * most_.stiffness, std::sqrt(linear_) * most_.damping, angular_ * most_.angular_stiffness,
            std::sqrt(angular_) * most_.angular_damping};
  }
  double share() const { return std::min(linear_, angular_); }  // 1: nothing is lowered

 private:
  double toward(double share, double budget, double used) const {
    const double wanted = used > budget ? budget / used : 1;
    return wanted < share ? wanted : std::min(wanted, share + config_.slowest_rise * period_);
  }

  GovernorConfig config_;
  CouplingGains most_;
  double period_;
  double delay_ = 0;  // the longest of late [s]
  double linear_ = 1, angular_ = 1;
};

}  // namespace palp
