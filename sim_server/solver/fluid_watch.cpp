#include "sim_server/solver/fluid_watch.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace palp {
namespace {

constexpr double kWindow = 0.1;  // [s]

std::size_t steps_in_window(const Scene& scene) {
  return static_cast<std::size_t>(std::clamp(std::round(kWindow * scene.config.rate_hz), 1.0, 1e5));
}

// Returns what makes the compression this many times as small.
std::string remedy(const Scene& scene, const Plan& plan, double times) {
  const NumericsConfig& n = scene.config.numerics;
  const double factor = std::sqrt(std::max(1.0, times));  // compression falls with the square of the sound speed
  if (n.sound_speed) return fmt::format("raise numerics.sound_speed to {:.2g} m/s or more", factor * plan.sound_speed);
  return fmt::format("{} numerics.max_speed to {:.2g} m/s or more", n.max_speed ? "raise" : "set",
                     factor * plan.max_speed);
}

}  // namespace

void FluidWatch::Mean::reset() {
  std::fill(value_.begin(), value_.end(), 0.0);
  sum_ = 0;
  next_ = 0;
  full_ = false;
}

double FluidWatch::Mean::add(double value) {
  sum_ += value - value_[next_];
  value_[next_] = value;
  next_ = (next_ + 1) % value_.size();
  full_ = full_ || next_ == 0;
  return full_ ? sum_ / static_cast<double>(value_.size()) : 0;
}

FluidWatch::FluidWatch(const Scene& scene, const Plan& plan)
    : scene_(scene),
      plan_(plan),
      mean_compression_(steps_in_window(scene)),
      max_compression_(steps_in_window(scene)),
      max_speed_(steps_in_window(scene)) {}

void FluidWatch::reset() {
  mean_compression_.reset();
  max_compression_.reset();
  max_speed_.reset();
  doubt_.clear();
  notice_.clear();
}

void FluidWatch::judge(Health& health) {
  if (!plan_.fluid || plan_.method != Method::accurate) return;
  health.expected_speed = plan_.max_speed;
  health.expected_compression = expected_compression(plan_);
  const double promise = std::max(health.expected_compression, kLeastPromise);
  const double fastest = plan_.sound_speed * std::sqrt(promise);  // for which the sound speed is enough
  const double mean = mean_compression_.add(health.mean_compression),
               most = max_compression_.add(health.max_compression);
  const double speed = max_speed_.add(health.max_speed);
  // without a free surface the mean pressure is arbitrary
  if (doubt_.empty() && !plan_.tension && mean > kMeanOverPromise * promise)
    doubt_ = fmt::format(
        "the fluid is compressed by {:.2g} % on average, expected at most {:.2g} % at a sound speed of "
        "{:.3g} m/s: {}",
        100 * mean, 100 * promise, plan_.sound_speed, remedy(scene_, plan_, 2 * mean / promise));
  if (doubt_.empty() && most > kMostCompression)
    doubt_ = fmt::format(
        "fluid is compressed by {:.2g} % for a tenth of a second, expected at most {:.2g} % at a sound "
        "speed of {:.3g} m/s: {}, or press less on it",
        100 * most, 100 * promise, plan_.sound_speed, remedy(scene_, plan_, most / promise));
  if (notice_.empty() && speed > kMostOverMaxSpeed * fastest)
    notice_ = fmt::format(
        "speeds reach {:.3g} m/s, expected at most {:.3g} m/s, for which the sound speed was chosen: "
        "{}, or forces are less accurate than this level promises",
        speed, fastest, remedy(scene_, plan_, std::pow(speed / fastest, 2)));
  health.doubt = doubt_;
  health.notice = notice_;
}

}  // namespace palp
