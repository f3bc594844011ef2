// How long force lasts once something has failed, and whether it goes and comes without a jolt.
#include <fmt/format.h>

#include <cmath>

#include "tools/haptic_bench/bench_scenes.h"
#include "tools/haptic_bench/cells.h"

namespace palp::bench {

namespace {

constexpr double kAt = 3;         // [s]
constexpr double kNothing = 0.1;  // [N]

struct Fault {
  const char* name;
  Faults faults;
  double most;  // [ms]
};

std::vector<Fault> faults() {
  std::vector<Fault> list(5);
  list[0] = {"server killed, force gone after", {}, 100};
  list[0].faults.server_dies = kAt;
  list[1] = {"only NaN from the server, force gone after", {}, 100};
  list[1].faults.nan_samples = kAt;
  list[2] = {"NaN from the device, force gone after", {}, 1};
  list[2].faults.nan_readings = kAt;
  list[3] = {"hand lets go, force gone after", {}, 1};
  list[3].faults.hand_lets_go = kAt;
  list[4] = {"server stalls for 100 ms, force gone after", {}, 100};
  list[4].faults.server_stalls = kAt;
  list[4].faults.stall_for = 0.1;
  return list;
}

}  // namespace

std::vector<Row> fault_rows(const Scenes& scenes, const Cell& cell) {
  std::vector<Row> rows;
  for (const Fault& fault : faults()) {
    RunSetup s = setup_in(scenes.wall, cell, push(cell.hand.model, 0.9, 0.5, {0, 0, -kGap - 0.02}), 5);
    s.faults = fault.faults;
    const Trace trace = run(s);
    double gone = -1, largest = 0, before = 0, after = 0;
    for (std::size_t k = 1; k < trace.ticks.size(); ++k) {
      const Tick &t = trace.ticks[k], &last = trace.ticks[k - 1];
      if (t.t < kAt) before = t.force.norm();
      if (t.t >= kAt && gone < 0 && t.force.norm() < kNothing) gone = t.t - kAt;
      if (!t.cut) largest = std::max(largest, (t.force - last.force).norm());
      if (t.t >= kAt) after = std::max(after, t.force.norm());
    }
    Row r = row_in(cell, fault.name, 1e3 * gone, "ms", "30 ms to 2 s elsewhere", fmt::format("<= {:g}", fault.most));
    r.note = fmt::format("from {:.2g} N, up to {:.2g} N after; largest step {:.2g} N; in the end {}", before, after,
                         largest, palp::to_string(trace.ticks.back().state));
    const bool within_slew = largest <= 1e-3 * s.profile.loop.limits.force_slew + 1e-9;
    rows.push_back(judged(cell, r, gone >= 0 && 1e3 * gone <= fault.most + 1e-6 && within_slew, trace.trouble));
  }
  return rows;
}

}  // namespace palp::bench
