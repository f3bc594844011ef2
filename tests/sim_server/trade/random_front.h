// Tables of the trade for tests, drawn at random.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sim_server/trade/trade_table.h"
#include "tests/support/random.h"

namespace palp::test {

// Points of a few numerics at a few spacings each: cost and error go about as powers of the spacing, each with noise of
// its own, so that some points are dominated and some errors rise where they should fall.
inline std::vector<TradePoint> random_points(Random& random) {
  std::vector<TradePoint> points;
  const int families = std::uniform_int_distribution<int>(1, 4)(random);
  for (int family = 0; family < families; ++family) {
    const double cost = std::exp(uniform(random, -1, 1)) * 1e-4, error = std::exp(uniform(random, -1, 1)) * 0.1;
    const double order = uniform(random, 0.3, 2);
    const int count = std::uniform_int_distribution<int>(1, 6)(random);
    double spacing = 0.05;
    for (int k = 0; k < count; ++k) {
      TradePoint point;
      point.spacing = spacing;
      point.settings = {"numerics.safety=0." + std::to_string(family + 1)};
      point.step = cost * std::pow(spacing / 0.05, -4) * uniform(random, 0.9, 1.1);
      point.step_p99 = 1.5 * point.step;
      point.calm_step = 0.8 * point.step;
      point.error = error * std::pow(spacing / 0.05, order) * uniform(random, 0.7, 1.3);
      points.push_back(point);
      spacing *= uniform(random, 0.5, 0.9);
    }
  }
  std::sort(points.begin(), points.end(), [](const TradePoint& a, const TradePoint& b) { return a.step < b.step; });
  return points;
}

}  // namespace palp::test
