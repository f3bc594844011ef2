// The trade between speed and accuracy as it was measured on one class of machines: config/trade/CLASS.json, which
// tools/tradeoff writes. It is read strictly, because numerics are chosen by it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace palp {

// One setting of a scene, what it costs and how far it errs.
struct TradePoint {
  double spacing = 0;                     // [m]
  std::vector<std::string> settings;      // TABLE.KEY=VALUE as in SceneOverrides, in the order of their keys
  double step = 0;                        // mean of the haptic steps while the hand moves [s]
  double step_p99 = 0;                    // [s]
  double calm_step = 0;                   // median while each hand holds still, as calibration.h measures it [s]
  double error = 0;                       // rms of the force's error over the rms of the force
  std::optional<double> rest_drift = {};  // of the particle that goes farthest in two seconds without a hand [spacings]
};

// The measured front of a scene.
struct TradeScene {
  std::string name;                // of the scene's file, without folder and ending
  std::string medium;              // "fluid", "elastic", "rigid", "changing", "mixed"
  std::string date, commit;        // of the measurement; the table's where its own are not given
  std::string rule;                // by which the levels were chosen
  double uncertainty = 0;          // of the reference that errors are measured against, as a share of the force
  std::vector<TradePoint> points;  // in the order of their cost
  std::map<std::string, TradePoint> levels;  // by name: what "fast", "balanced" and "accurate" are in this scene
};

struct TradeTable {
  std::string file;
  std::string machine_class;  // "cpu-2": two processors; "h200": a GPU
  std::string hardware;
  std::string date, commit;  // of its latest scene
  std::vector<TradeScene> scenes;
};

// Reads a table. Throws ConfigError with one sentence that names the file and the entry: no JSON, a missing or wrong
// field, a number that is not finite or out of its range, no points, points out of order, a class that is not the
// file's name.
TradeTable read_trade_table(const std::string& path);

// Returns the key and the value of a setting TABLE.KEY=VALUE.
std::string key_of(const std::string& setting);
std::string value_of(const std::string& setting);

}  // namespace palp
