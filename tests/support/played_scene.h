// A scene of config/scenes played by hands of config/hands: device k follows its hand's path from where its tool
// starts, as an arm would that nothing holds back.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "haptic_bridge/device/hand_script.h"

#include "tests/support/backend.h"
#include "tests/support/scene_files.h"

namespace palp::test {

class PlayedScene {
 public:
  // hands: names, by index of the scene's proxies.
  PlayedScene(const std::string& name, const std::vector<std::string>& hands)
      : scene(scene_file(name)), simulation(simulate(scene)) {
    for (std::size_t k = 0; k < hands.size(); ++k) {
      const HandScript script = read_hand_script(PALP_SOURCE_DIR "/config/hands/" + hands[k] + ".toml");
      paths_.emplace_back(script.keyframes, script.interpolation, script.loop);
      const Proxy& proxy = scene.proxies[k];
      const Body& tool = scene.bodies[proxy.body];
      home_.push_back({tool.position + tool.orientation * proxy.handle, tool.orientation});
      input_[k].engaged = true;
      input_[k].gains = proxy.limit;
    }
  }

  // Plays on to a time [s]; after each step `look` sees what came out. False when the simulation turned unhealthy,
  // which is a failure of the test.
  bool play(
      double until, const std::function<void(const StepOutput&)>& look = [](const StepOutput&) {}) {
    while (simulation->output().time < until - 1e-9) {
      for (std::size_t k = 0; k < paths_.size(); ++k) {
        const RigidState want = paths_[k].at(simulation->output().time);
        input_[k].state = {home_[k].position + want.position, want.orientation * home_[k].orientation, want.linear,
                           want.angular};
      }
      const StepOutput& out = simulation->step(input_);
      if (!out.health.ok) {
        ADD_FAILURE() << out.health.cause << " at " << out.time << " s";
        return false;
      }
      look(out);
    }
    simulation->snapshot(snapshot);
    return true;
  }

  Eigen::Vector3d place(std::size_t particle) const {
    return Eigen::Map<const Eigen::Vector3f>(&snapshot.position[3 * particle]).cast<double>();
  }
  double speed(std::size_t particle) const {
    return Eigen::Map<const Eigen::Vector3f>(&snapshot.velocity[3 * particle]).norm();
  }

  Scene scene;
  std::unique_ptr<Simulation> simulation;
  Snapshot snapshot;  // after the last play()

 private:
  struct Pose {
    Eigen::Vector3d position;
    Eigen::Quaterniond orientation;
  };
  std::vector<Trajectory> paths_;
  std::vector<Pose> home_;
  StepInput input_;
};

}  // namespace palp::test
