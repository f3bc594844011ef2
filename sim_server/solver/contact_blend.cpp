#include "sim_server/solver/contact_blend.h"

#include <algorithm>
#include <cmath>

namespace palp {
namespace {

constexpr double kSlowTime = 0.02;   // time constant of the means that changes are measured from [s]
constexpr double kBlendTime = 0.01;  // time constant of the mean over changes [s]

}  // namespace

double ContactBlend::share_of_slow_mean(double step) { return 1 - std::exp(-step / kSlowTime); }

double ContactBlend::update(const Eigen::Vector3d& force, const Eigen::Vector3d& demand, const Eigen::Vector3d& held,
                            double min_demand, double step) {
  if (force.isZero(0)) {
    *this = {};
    before_ = demand - held;
    return 0;
  }
  const double slow = share_of_slow_mean(step), share = 1 - std::exp(-step / kBlendTime);
  // a slow mean forgets a motion that has ended by the same share in each step
  before_ -= slow * before_;
  slow_force_ += slow * (force - slow_force_);
  const Eigen::Vector3d asked = demand - before_;
  answered_ += share * (-(force - slow_force_).dot(asked) - answered_);
  asked_ += share * (asked.squaredNorm() - asked_);
  // a hand that rests tells nothing new
  if (asked_ > min_demand * min_demand) value_ = std::clamp(answered_ / asked_, 0.0, 1.0);
  return value_;
}

}  // namespace palp
