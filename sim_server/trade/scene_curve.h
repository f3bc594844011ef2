// The curve by which a scene's numerics are chosen: its own, where it was measured, else that of its medium.
#pragma once

#include <string>
#include <vector>

#include "config/scene_config.h"
#include "sim_server/trade/trade_table.h"

namespace palp {

struct SceneCurve {
  std::vector<TradePoint> points;  // with the spacings of the scene, and only settings that it may be given
  std::string measured_with;       // the name of the scene that was measured
  std::string date, commit;        // of that measurement
  bool own = false;                // that is this scene, as it is
  double uncertainty = 0;          // of the reference
};

// Returns the curve of the scene in a file. Of a scene that was not measured: that of the table's scene of its medium,
// the error going by how many particles are as long as the tool (resolved_length); as far as the scene's own coarsest
// spacing, which its walls are made for, and with the numerics that its file states. What --set gave is kept, and of
// the measured points those that agree with it are left. Throws ConfigError when no point is left, or overrides leave
// nothing to choose.
SceneCurve curve_of(const TradeTable& table, const std::string& scene_file, const SceneOverrides& overrides);

}  // namespace palp
