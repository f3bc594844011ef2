// A simulation stepped without a bus: lowers the scene's tool and prints the force on it.
// Usage: step_simulation [SCENE [SECONDS]], a scene's file or bare name.
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "sim_server/scene/scene_files.h"
#include "sim_server/solver/simulation.h"

namespace {

void lower_tool(const std::string& name, double seconds) {
  palp::SceneOverrides overrides;
  overrides.accuracy = palp::Accuracy::fast;
  const palp::SceneConfig config = palp::load_scene(palp::find_scene_file(name), overrides);
  const auto simulation =
      palp::make_simulation(palp::sample_scene(config, palp::particles_in_memory()), palp::Backend::cpu);
  std::printf("%s\n", simulation->backend_name().c_str());
  if (simulation->output().proxies.empty()) throw std::runtime_error(name + " has no tool");

  palp::StepInput input;
  input[0].engaged = true;
  input[0].state = simulation->output().proxies[0].state;
  input[0].state.linear.z() = -0.02;                             // m/s
  const double period = 1 / simulation->scene().config.rate_hz;  // s
  for (int step = 0; step * period < seconds; ++step) {
    const palp::StepOutput& output = simulation->step(input);
    if (!output.health.ok) throw std::runtime_error(output.health.cause);
    input[0].state.position += period * input[0].state.linear;
    const palp::ProxyOutput& tool = output.proxies[0];
    if (step % 20 == 0)
      std::printf("%.3f s: height %.4f m, force %.3f N\n", output.time, tool.state.position.z(), tool.force.z());
  }
}

}  // namespace

int main(int argc, char** argv) try {
  lower_tool(argc > 1 ? argv[1] : "tray_fluid", argc > 2 ? std::atof(argv[2]) : 0.2);
} catch (const std::exception& error) {
  std::fprintf(stderr, "step_simulation: %s\n", error.what());
  return 1;
}
