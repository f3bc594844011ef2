#include "sim_server/trade/front.h"

#include <algorithm>
#include <cmath>

namespace palp {

namespace {

constexpr double kLeastError = 1e-9;  // stands for an error of nothing, which no power law reaches

// Returns the spacing at which a power law that is y0 at x0 and y1 at x1 has the value y.
double spacing_at(double x0, double y0, double x1, double y1, double y) {
  return x0 * std::pow(x1 / x0, std::log(y / y0) / std::log(y1 / y0));
}

bool is_between(double y, double a, double b) { return y > std::min(a, b) && y < std::max(a, b); }

bool is_better_in_error(const TradePoint& a, const TradePoint& b) {
  return a.error < b.error || (a.error == b.error && a.step < b.step);
}
bool is_cheaper(const TradePoint& a, const TradePoint& b) {
  return a.step < b.step || (a.step == b.step && a.error < b.error);
}

void keep_better(std::optional<TradePoint>& best, const TradePoint& point,
                 bool (*better)(const TradePoint&, const TradePoint&)) {
  if (!best || better(point, *best)) best = point;
}

}  // namespace

bool dominates(const TradePoint& a, const TradePoint& b) {
  return a.step <= b.step && a.error <= b.error && (a.step < b.step || a.error < b.error);
}

TradePoint along(const TradePoint& a, const TradePoint& b, double spacing) {
  const double share = std::log(spacing / a.spacing) / std::log(b.spacing / a.spacing);
  const auto law = [&](double from, double to) { return from * std::pow(to / from, share); };
  TradePoint point = a;
  point.spacing = spacing;
  point.step = law(a.step, b.step);
  point.step_p99 = law(a.step_p99, b.step_p99);
  point.calm_step = law(a.calm_step, b.calm_step);
  point.error = law(std::max(a.error, kLeastError), std::max(b.error, kLeastError));
  return point;
}

std::vector<std::pair<TradePoint, TradePoint>> stretches(const std::vector<TradePoint>& points) {
  std::vector<TradePoint> sorted = points;
  std::sort(sorted.begin(), sorted.end(), [](const TradePoint& a, const TradePoint& b) {
    return a.settings != b.settings ? a.settings < b.settings : a.spacing < b.spacing;
  });
  std::vector<std::pair<TradePoint, TradePoint>> pairs;
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    const TradePoint &a = sorted[k - 1], &b = sorted[k];
    if (a.settings == b.settings && a.spacing < b.spacing) pairs.emplace_back(a, b);
  }
  return pairs;
}

std::optional<TradePoint> moved_along(const std::vector<TradePoint>& points, const TradePoint& from, double factor) {
  const double wanted = from.spacing * factor;
  std::optional<TradePoint> reached;
  for (const auto& [fine, coarse] : stretches(points)) {
    if (fine.settings != from.settings) continue;
    const double spacing = std::clamp(wanted, fine.spacing, coarse.spacing);
    const bool onward = factor > 1 ? spacing > from.spacing * (1 + 1e-6) : spacing < from.spacing * (1 - 1e-6);
    const bool nearer = !reached || std::abs(spacing - wanted) < std::abs(reached->spacing - wanted);
    if (onward && nearer) reached = along(fine, coarse, spacing);
  }
  return reached;
}

// On a stretch cost and error only rise or only fall, so the best that fits lies at one of its ends or where the limit
// cuts it.
std::optional<TradePoint> least_error_within(const std::vector<TradePoint>& points, double step) {
  std::optional<TradePoint> best;
  for (const TradePoint& point : points)
    if (point.step <= step) keep_better(best, point, is_better_in_error);
  for (const auto& [a, b] : stretches(points)) {
    if (!is_between(step, a.step, b.step)) continue;
    TradePoint cut = along(a, b, spacing_at(a.spacing, a.step, b.spacing, b.step, step));
    cut.step = step;  // but for rounding it is
    keep_better(best, cut, is_better_in_error);
  }
  return best;
}

std::optional<TradePoint> cheapest_within(const std::vector<TradePoint>& points, double error) {
  std::optional<TradePoint> best;
  for (const TradePoint& point : points)
    if (point.error <= error) keep_better(best, point, is_cheaper);
  return best;
}

}  // namespace palp
