// The motors of a simulated arm render the wrench that they are told to, but no more than they can, and half of it
// while they are too warm. They warm with the mean square of their load over ten seconds, and are cool again at four
// fifths of what they can hold for ever. No allocation, no lock, no throw.
#pragma once

#include <algorithm>
#include <cmath>

#include "haptic_bridge/loop/force_limits.h"

namespace palp {

struct MotorRating {
  double force_limit = 35, torque_limit = 3;               // at most [N], [N m]
  double continuous_force = 1e9, continuous_torque = 1e9;  // for ever [N], [N m]
};

class Motors {
 public:
  // Returns the wrench that the motors render for the next dt [s], and lets them warm from it.
  Wrench<double> render(const Wrench<double>& wanted, const MotorRating& rating, double dt) {
    constexpr double kRounding = 1 + 1e-6;
    overloaded_ =
        wanted.force.norm() > kRounding * rating.force_limit || wanted.torque.norm() > kRounding * rating.torque_limit;
    const double share = hot_ ? kHotShare : 1;
    Wrench<double> w{share * saturated(wanted.force, rating.force_limit),
                     share * saturated(wanted.torque, rating.torque_limit)};
    force_heat_ += dt / kThermalTime * (w.force.squaredNorm() - force_heat_);
    torque_heat_ += dt / kThermalTime * (w.torque.squaredNorm() - torque_heat_);
    const double load =
        std::max(std::sqrt(force_heat_) / rating.continuous_force, std::sqrt(torque_heat_) / rating.continuous_torque);
    hot_ = hot_ ? load > kCoolShare : load > 1;
    return w;
  }
  bool hot() const { return hot_; }
  bool overloaded() const { return overloaded_; }  // more was wanted than they can

 private:
  static constexpr double kThermalTime = 10;  // [s]
  static constexpr double kCoolShare = 0.8, kHotShare = 0.5;
  double force_heat_ = 0, torque_heat_ = 0;  // mean squares [N^2], [N^2 m^2]
  bool hot_ = false, overloaded_ = false;
};

}  // namespace palp
