// Z-width (Colgate & Brown 1994): up to which stiffness a virtual wall is stable, for each damping of the coupling.
#pragma once

#include <functional>

#include "tools/haptic_bench/hands.h"
#include "tools/haptic_bench/results.h"
#include "tools/haptic_bench/system.h"

namespace palp::bench {

// The place where a metric is measured: hand, link, rate and what is rendered.
struct Cell {
  NamedHand hand;
  double rate_hz = 1000;
  LinkPair link;
  Variant variant = Variant::ours;
  std::uint64_t seed = 1;
  int seeds = 1;  // the worst of them counts
  DeviceProfile profile;
  bool controller = true;  // passivity control, and gains that follow the delay
};

// The figures of the last second of a press on a wall.
struct Press {
  bool stable = false;
  double rms = 0;         // of the place [m]
  double turn_rms = 0;    // [rad]
  double hz = 0;          // of the largest oscillation, by its zero crossings
  double peak_force = 0;  // [N]
  double share = 1;       // of the stiffness asked for, as the loop found right for the link
  double turn_share = 1;  // of the angular one
  double shortfall = 0;   // most energy drawn beyond what the simulation put in, over the whole press [J]
  double delay = 0;       // of what was rendered, mean of the last second [s]
  std::string why;        // not stable
};

inline constexpr double kStableRms = 0.05e-3;  // [m]
inline constexpr double kStableTurn = 1e-3;    // [rad]: the same at 5 cm from the handle

// Returns the run that press_wall makes.
RunSetup wall_press(const Scene& wall, const Cell& cell, double stiffness, double damping, std::uint64_t seed);
Press judge(const Trace& trace);
// Presses on the wall with the hand's intent 20 mm behind it, for four seconds.
Press press_wall(const Scene& wall, const Cell& cell, double stiffness, double damping, std::uint64_t seed);

struct ZWidth {
  double stiffness = 0;    // the largest that was rendered, with the worst seed; 0: none [N/m, N m/rad]
  double asked = 0;        // for that
  double delay = 0;        // of what was rendered [s]
  Press first_unstable;    // of the next one
  double unstable_at = 0;  // 0: none up to the largest
};
// Says where to look: upwards from `likely` if that is stable, else downwards, in steps of two that are then narrowed
// down.
struct Search {
  double least, likely, most;
  bool fine;  // down to 9 %, else to 20 %
  int seeds;  // the first narrows down, the others then have to bear what it found, or take it down
};
// Finds the largest stable stiffness. press: makes a press with a stiffness and the seed of that number.
ZWidth widest(const Search& search, const std::function<Press(double stiffness, int seed)>& press);
inline constexpr double kLeastStiffness = 250, kLikelyStiffness = 4000, kMostStiffness = 32000;  // [N/m]

ZWidth z_width(const Scene& wall, const Cell& cell, double damping, bool fine);

// Returns the width as a row of the table. scale: from N/m or N m/rad to the unit; wanted: at least, in that unit.
Row width_row(const Cell& cell, const ZWidth& z, double scale, const std::string& metric, const std::string& unit,
              const std::string& reference, double wanted);
// Returns the widths as rows of the table, one a damping.
std::vector<Row> z_width_rows(const Scene& wall, const Cell& cell, const std::vector<double>& dampings, bool fine);

}  // namespace palp::bench
