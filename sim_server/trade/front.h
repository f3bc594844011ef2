// The front of a trade: which points are better than others, and the best one for what is asked. Between neighbouring
// spacings with the same settings the cost is a power law of the spacing, and the error about one: it strays with how a
// tool's surface lies to the particles, by a quarter where it was looked at. So a budget chooses between spacings, too,
// an error only what was measured.
#pragma once

#include <optional>
#include <vector>

#include "sim_server/trade/trade_table.h"

namespace palp {

// Returns whether a is at least as good as b in cost and in error, and better in one of them.
bool dominates(const TradePoint& a, const TradePoint& b);

// Returns the point at a spacing by the power laws through a and b, which have the same settings and other spacings;
// past their ends, too.
TradePoint along(const TradePoint& a, const TradePoint& b, double spacing);

// Returns the points of the same settings next to each other in the order of their spacings: each pair spans a stretch
// of the curve.
std::vector<std::pair<TradePoint, TradePoint>> stretches(const std::vector<TradePoint>& points);

// Returns the point on the curve `factor` times as coarse as one on it, or the end of its settings' stretches that lies
// before that; nothing from that end on.
std::optional<TradePoint> moved_along(const std::vector<TradePoint>& points, const TradePoint& from, double factor);

// Returns the point with the least error among those on the curve whose step takes at most `step` [s]; nothing where
// none is so cheap. Of equal errors the cheaper one is taken.
std::optional<TradePoint> least_error_within(const std::vector<TradePoint>& points, double step);

// Returns the cheapest of the points whose error is at most `error`; nothing where none is so accurate.
std::optional<TradePoint> cheapest_within(const std::vector<TradePoint>& points, double error);

}  // namespace palp
