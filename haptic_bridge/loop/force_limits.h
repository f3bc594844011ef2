// The pure pieces of the chain of force limits: saturation, slew limit, power limit, thermal limit, ramps, low-pass.
// Every function here: no allocation, no lock, no throw. Nothing here knows of devices, clocks or samples.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "idl/convert.h"

namespace palp {

// v, shortened to the limit if it is longer. The direction is kept. limit >= 0; v finite, however large.
inline Eigen::Vector3d saturated(const Eigen::Vector3d& v, double limit) {
  const double length = v.stableNorm();
  if (length <= limit) return v;
  const double largest = v.cwiseAbs().maxCoeff();
  const Eigen::Vector3d scaled = v / largest;  // keeps the direction of a vector whose length overflows
  return scaled * (limit / scaled.norm());
}

// One step from previous towards wanted, at most max_step long.
inline Eigen::Vector3d slewed(const Eigen::Vector3d& previous, const Eigen::Vector3d& wanted, double max_step) {
  return previous + saturated(wanted - previous, max_step);
}

// One step of value towards target (both 0..1), at most up or down.
inline double ramped(double value, double target, double up, double down) {
  return std::clamp(target, value - down, value + up);
}

// Share of the new value in a first-order low-pass stepped every dt [s]. cutoff_hz <= 0: no filter.
inline double low_pass_share(double cutoff_hz, double dt) {
  return cutoff_hz <= 0 ? 1 : 1 - std::exp(-2 * M_PI * cutoff_hz * dt);
}

// Largest wrench that may be sent, and how fast it may change.
struct WrenchLimits {
  double force = 8;         // [N]
  double torque = 0.5;      // [N m]
  double force_slew = 300;  // [N/s]
  double torque_slew = 30;  // [N m/s]
  // of a single world axis, before the direction is kept [N], [N m]
  Eigen::Vector3d axis_force = Eigen::Vector3d::Constant(1e9);
  Eigen::Vector3d axis_torque = Eigen::Vector3d::Constant(1e9);
  // that the arm can hold for long: the mean square over ten seconds stays below this squared [N], [N m]
  double continuous_force = 1e9;
  double continuous_torque = 1e9;
  double power = 5;  // given to the hand [W]
};

inline Wrench<double> saturated(const Wrench<double>& w, const WrenchLimits& limits) {
  const auto cut = [](const Eigen::Vector3d& v, const Eigen::Vector3d& most) {
    return Eigen::Vector3d(v.cwiseMax(-most).cwiseMin(most));
  };
  return {saturated(cut(w.force, limits.axis_force), limits.force),
          saturated(cut(w.torque, limits.axis_torque), limits.torque)};
}

// A slope limit that turns when what it follows turns. A plain one lags the further the more is asked of it, and that
// delay feeds an oscillation; this one passes on how the wanted wrench changes, and what it could not follow it makes
// up for by and by (phase-compensated rate limiters: Rundqwist & Staahl-Gunnarsson 1996).
//   sent' = sent + cut(wanted' - wanted + leak (wanted - sent), slew dt)
// While the slope is within the limit, it sends what is wanted. What is wanted and hardly changes any more is no
// oscillation: then it follows as fast as it may.
class SlewLimit {
 public:
  // leak: share of the arrears that is made up for in a step, 0..1; 1: the plain limiter.
  explicit SlewLimit(double leak) : keep_(1 - leak) {}

  // One step of dt [s] from previous, what was sent last. wanted, and previous, must be within the limits; so is what
  // is returned.
  Wrench<double> step(const Wrench<double>& previous, const Wrench<double>& wanted, const WrenchLimits& limits,
                      double dt) {
    const bool calm = (wanted.force - last_.force).norm() <= kCalm * limits.force_slew * dt &&
                      (wanted.torque - last_.torque).norm() <= kCalm * limits.torque_slew * dt;
    calm_for_ = calm ? calm_for_ + dt : 0;
    last_ = wanted;
    if (calm_for_ > kCalmTime) forget();
    // rounded away, so that the arrears end and never become denormal
    const auto kept = [this](const Eigen::Vector3d& v) {
      return v.norm() < kNothing ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : Eigen::Vector3d(keep_ * v);
    };
    // two cuts: the place within the limits that is nearest is no further away, but for rounding
    const Wrench<double> toward =
        saturated({slewed(previous.force, wanted.force - kept(arrears_.force), limits.force_slew * dt),
                   slewed(previous.torque, wanted.torque - kept(arrears_.torque), limits.torque_slew * dt)},
                  limits);
    return {slewed(previous.force, toward.force, limits.force_slew * dt),
            slewed(previous.torque, toward.torque, limits.torque_slew * dt)};
  }
  // Remembers how far the wrench sent fell behind the wanted one in this step.
  void note(const Wrench<double>& wanted, const Wrench<double>& sent) {
    arrears_ = {wanted.force - sent.force, wanted.torque - sent.torque};
  }
  // Makes up for all arrears as fast as it may.
  void forget() { arrears_ = zero_wrench(); }

 private:
  static constexpr double kNothing = 1e-9;   // [N, N m]
  static constexpr double kCalm = 0.2;       // of the slope
  static constexpr double kCalmTime = 0.01;  // [s]
  double keep_;
  double calm_for_ = 0;                  // [s]
  Wrench<double> last_ = zero_wrench();  // that was wanted
  Wrench<double> arrears_ = zero_wrench();
};

// A wrench that gives the hand at most so much power [W], linear and angular together; state: of the device.
inline Wrench<double> power_limited(const Wrench<double>& w, const RigidState& state, double most) {
  const double power = w.force.dot(state.linear) + w.torque.dot(state.angular);
  if (power <= most) return w;
  const double share = most / power;
  return {share * w.force, share * w.torque};
}

// Keeps an arm's motors within what they stand: the mean square of a force over some seconds stays below the square of
// what they can hold for ever. The largest force allowed sinks from the peak to that while the mean comes near, early
// enough for a force that may only fall at a slope.
class ThermalLimit {
 public:
  // continuous: for ever [N, N m]. time: of the mean [s]. slope: at which the force can fall [N/s, N m/s].
  ThermalLimit(double continuous, double time, double slope) : continuous_(continuous), time_(time), slope_(slope) {}

  // Returns how much of a peak [N, N m] is allowed now.
  double allowed(double peak) const {
    if (peak <= continuous_) return peak;
    const double square = continuous_ * continuous_, left = std::max(0.0, square - mean_square_);
    const double fading = continuous_ + (peak - continuous_) * std::min(1.0, left / ((1 - kWarm) * square));
    // on its way down from F to the continuous force c it adds (F^3 - c^3) / (3 slope time) to the mean square
    const double last_moment = std::cbrt(square * continuous_ + 3 * kSure * slope_ * time_ * left);
    return std::min(fading, last_moment);
  }
  // Counts a force or torque of this size [N, N m], sent for dt [s].
  void note(double sent, double dt) { mean_square_ += dt / time_ * (sent * sent - mean_square_); }

 private:
  static constexpr double kWarm = 0.7;  // of the mean square allowed; from here on the largest force sinks
  static constexpr double kSure = 0.3;  // of the slope: late ticks, and forces that turn, fall more slowly
  double continuous_, time_, slope_;
  double mean_square_ = 0;
};

}  // namespace palp
