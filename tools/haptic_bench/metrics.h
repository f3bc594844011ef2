// The metrics of a cell but the Z-width, as rows of the table. Gains are the defaults of a device's profile.
#pragma once

#include <memory>
#include <optional>

#include "tools/haptic_bench/results.h"
#include "tools/haptic_bench/z_width.h"

namespace palp::bench {

// Sampled once, used by all runs.
struct Scenes {
  Scene wall, elastic, current, tank, vise;
};

// Force that free motion of 50 mm at 1 Hz takes.
std::vector<Row> drag_rows(const Scenes& scenes, const Cell& cell);
// Spring and damper that the hand feels at a wall, against those commanded; press on an elastic block, against the
// solver's own static force.
std::vector<Row> rendering_rows(const Scenes& scenes, const Cell& cell);
// How far a current moves a hand that follows, against the same without delays.
std::vector<Row> current_rows(const Scenes& scenes, const Cell& cell);
// Force and place while the hand rests on a wall, and in a tank.
std::vector<Row> buzz_rows(const Scenes& scenes, const Cell& cell);
// A minute of pressing, tapping, sliding and free motion on jelly and stone: energy, steps, activity.
std::vector<Row> minute_rows(const Scenes& scenes, const Cell& cell, double seconds);
// Age of what is rendered.
std::vector<Row> delay_rows(const Scenes& scenes, const Cell& cell);
// Z-width, spring, damper and free motion in rotation. dampings: of the ways; at the lever of 0.1 m that makes of 1
// kN/m 10 N m/rad, as section 6 of the haptics reference has it, they are a hundredth of that.
std::vector<Row> torsion_rows(const Scenes& scenes, const Cell& cell, const std::vector<double>& dampings, bool fine);
// The motion of the paper's figure 4 in three states of matter, both methods. accuracy: instead of the scenes' own.
// series_dir: where to write what was felt, one CSV file each, unless empty.
std::vector<Row> figure4_rows(const Cell& cell, std::optional<Accuracy> accuracy, const std::string& series_dir);
// How long force lasts after a fault.
std::vector<Row> fault_rows(const Scenes& scenes, const Cell& cell);

}  // namespace palp::bench
