#include "sim_server/trade/measured_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/error.h"
#include "config/quantity.h"
#include "sim_server/trade/front.h"

namespace palp {

namespace {

constexpr int kMostTrials = 4;
// Candidates aim a little below the budget, so that one that turns out 8 % dearer need not be made anew; one that uses
// four fifths of the budget serves: finer particles would gain less than the curve is sure of.
constexpr double kAim = 0.92, kEnough = 0.8;
constexpr double kSameSpacing = 0.01, kRounding = 1e-5;   // shares of a spacing
constexpr double kCoarser = 1.01, kFiner = 1 / kCoarser;  // steps along the curve from a candidate that cannot be had
constexpr int kMostSteps = 100;
constexpr double kMostSlope = 1.5;  // of the logarithm of the slowness over that of the spacing

// How much slower than the table this machine is, by spacing: a power law through the last two spacings that were
// timed. A GPU that is not filled, or a cache that no longer holds all, makes it depend on the number of particles.
class Slowness {
 public:
  double at(double spacing) const {
    return last_.spacing > 0 ? last_.ratio * std::pow(spacing / last_.spacing, slope_) : 1;
  }
  void add(double spacing, double ratio) {
    const double apart = std::log(spacing / last_.spacing);
    if (last_.spacing > 0 && std::abs(apart) > 5 * kSameSpacing)
      slope_ = std::clamp(std::log(ratio / last_.ratio) / apart, -kMostSlope, kMostSlope);
    last_ = {spacing, ratio};
  }

 private:
  struct {
    double spacing = 0;  // 0: nothing was timed yet
    double ratio = 1;
  } last_;
  double slope_ = 0;
};

TradePoint slower(TradePoint point, double ratio) {
  for (double* time : {&point.step, &point.step_p99, &point.calm_step}) *time *= ratio;
  return point;
}

const TradePoint& cheapest(const std::vector<TradePoint>& points) {
  return *std::min_element(points.begin(), points.end(),
                           [](const TradePoint& a, const TradePoint& b) { return a.step < b.step; });
}

const TradePoint& most_accurate(const std::vector<TradePoint>& points) {
  return *std::min_element(points.begin(), points.end(),
                           [](const TradePoint& a, const TradePoint& b) { return a.error < b.error; });
}

class Chooser {
 public:
  Chooser(std::vector<TradePoint> points, std::string scene, const TimeCandidate& time_candidate)
      : points_(std::move(points)), scene_(std::move(scene)), time_candidate_(time_candidate) {}

  MeasuredChoice within_budget(double budget, bool trusted) {
    std::optional<MeasuredChoice> best;
    const auto keep = [&](const MeasuredChoice& now) {
      if (now.point.step <= budget && (!best || now.point.error < best->point.error)) best = now;
    };
    if (!trusted) keep(time_first());
    for (int trial = 0; trial < kMostTrials; ++trial) {
      const TradePoint candidate = candidate_for(budget);
      if (was_timed(candidate) || (best && is_near(candidate, best->point, kSameSpacing))) break;
      const std::optional<MeasuredChoice> now = time_if_had(candidate);
      if (!now) break;
      keep(*now);
      const bool no_better = candidate.error <= most_accurate(points_).error * (1 + kSameSpacing);
      if (now->point.step <= budget && (now->point.step >= kEnough * budget || no_better)) break;
    }
    if (!best && !was_timed(cheapest(expected()))) keep(time_first());
    if (best) return *best;
    const TradePoint least = cheapest(expected());
    throw ConfigError(fmt::format(
        "{}: no numerics that were measured take a step of at most {} on this machine: the cheapest, a spacing of "
        "{:.4g} mm, takes {} at an error of {}; give a budget of that, or a smaller scene or a faster machine",
        scene_, duration_text(budget), 1e3 * least.spacing, duration_text(least.step), share_text(least.error)));
  }

  MeasuredChoice within_error(double error) {
    if (const std::optional<TradePoint> found = cheapest_within(points_, error))
      return time_near(rounded(*found), kFiner);
    const TradePoint& best = most_accurate(points_);
    throw ConfigError(fmt::format(
        "{}: no numerics that were measured err by at most {}: the most accurate, a spacing of {:.4g} mm, is expected "
        "to err by {} of the force; ask for that, or measure finer ones with tools/tradeoff",
        scene_, share_text(error), 1e3 * best.spacing, share_text(best.error)));
  }

 private:
  // Returns the curve with the times that are expected on this machine by now.
  std::vector<TradePoint> expected() const {
    std::vector<TradePoint> result;
    result.reserve(points_.size());
    for (const TradePoint& point : points_) result.push_back(slower(point, slowness_.at(point.spacing)));
    return result;
  }

  TradePoint candidate_for(double budget) const {
    const std::vector<TradePoint> curve = expected();
    if (const auto found = least_error_within(curve, kAim * budget)) return rounded(*found);
    if (const auto found = least_error_within(curve, budget)) return rounded(*found);
    return cheapest(curve);
  }

  // To six digits, so that what is printed gives the same particles.
  static TradePoint rounded(TradePoint point) {
    point.spacing = std::stod(fmt::format("{:.6g}", point.spacing));
    return point;
  }

  static bool is_near(const TradePoint& a, const TradePoint& b, double within) {
    return a.settings == b.settings && std::abs(a.spacing / b.spacing - 1) < within;
  }

  bool was_timed(const TradePoint& candidate) const {
    return std::any_of(timed_.begin(), timed_.end(),
                       [&](const TradePoint& point) { return is_near(point, candidate, kRounding); });
  }

  // Times a candidate of expected(), and learns from it.
  MeasuredChoice time(const TradePoint& candidate) {
    const double ratio = time_candidate_(candidate) / candidate.calm_step;
    const double slowness = slowness_.at(candidate.spacing) * ratio;
    slowness_.add(candidate.spacing, slowness);
    timed_.push_back(candidate);
    return {slower(candidate, ratio), 1 / slowness};
  }

  // Times a candidate, or the first one along the curve that the scene can be had with.
  MeasuredChoice time_near(TradePoint candidate, double factor) {
    for (int step = 0;; ++step) {
      try {
        return time(candidate);
      } catch (const ConfigError&) {
        const std::optional<TradePoint> next = moved_along(expected(), candidate, factor);
        if (!next || step == kMostSteps) throw;
        candidate = rounded(*next);
      }
    }
  }

  // Likewise, but gives nothing where the scene cannot be had with any of them.
  std::optional<MeasuredChoice> time_if_had(const TradePoint& candidate) {
    try {
      return time_near(candidate, kCoarser);
    } catch (const ConfigError&) {
      return std::nullopt;
    }
  }

  // Times the cheapest point that the scene can be had with; what is coarser with its settings is off the curve then.
  MeasuredChoice time_first() {
    const MeasuredChoice first = time_near(cheapest(expected()), kFiner);
    const TradePoint timed = timed_.back();
    const auto coarser = [&](const TradePoint& point) {
      return point.settings == timed.settings && point.spacing >= timed.spacing * (1 - 1e-6);
    };
    points_.erase(std::remove_if(points_.begin(), points_.end(), coarser), points_.end());
    points_.push_back(slower(first.point, first.speed));
    return first;
  }

  std::vector<TradePoint> points_;
  std::string scene_;
  const TimeCandidate& time_candidate_;
  Slowness slowness_;
  std::vector<TradePoint> timed_;
};

}  // namespace

MeasuredChoice choose_measured(const std::vector<TradePoint>& points, const ChoiceRequest& request, bool trusted,
                               const std::string& scene, const TimeCandidate& time_candidate) {
  Chooser chooser(points, scene, time_candidate);
  return request.budget ? chooser.within_budget(*request.budget, trusted) : chooser.within_error(request.error.value());
}

}  // namespace palp
