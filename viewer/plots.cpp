#include "viewer/plots.h"

#include <algorithm>

namespace palp {

void Plots::add(const FeedView& view, const HudData& figures, std::int64_t now_ns) {
  const double now = 1e-9 * static_cast<double>(now_ns);
  for (std::size_t device = 0; device < hands.size(); ++device) {
    const auto& proxy = view.proxies[device];
    if (!proxy) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      hands[device].force[k].add(now, proxy->wrench.force[k]);
      hands[device].torque[k].add(now, proxy->wrench.torque[k]);
    }
  }
  // the age at this moment, not that of the figures, which stand still for a while
  if (view.frame) frame_age.add(now, std::max(0.0, 1e-9 * static_cast<double>(now_ns - view.frame_time_ns)));
  if (figures.bridge_data_age) bridge_age.add(now, *figures.bridge_data_age);
  if (figures.step_time) step_time.add(now, *figures.step_time);
  if (figures.paused || figures.real_time_factor)
    real_time_factor.add(now, figures.paused ? 0 : *figures.real_time_factor);
  if (figures.kinetic_energy) kinetic_energy.add(now, *figures.kinetic_energy);
}

}  // namespace palp
