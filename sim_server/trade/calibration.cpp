#include "sim_server/trade/calibration.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <vector>

namespace palp {

double typical_step(const std::function<double()>& timed_step, const Timing& timing) {
  constexpr std::size_t kFewest = 3;
  double spent = 0;
  for (int k = 0; k < timing.least_warm_up || (spent < timing.warm_up && k < 1000); ++k) spent += timed_step();
  std::vector<double> times;
  const auto least = static_cast<std::size_t>(std::max(timing.least_steps, 1));
  for (spent = 0; spent < timing.seconds || times.size() < least;) {
    if (spent > timing.most_seconds && times.size() >= kFewest) break;
    times.push_back(timed_step());
    spent += times.back();
  }
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

StepInput still_hands(const Scene& scene) {
  StepInput input{};
  for (std::size_t p = 0; p < scene.proxies.size(); ++p) {
    const Body& tool = scene.bodies[scene.proxies[p].body];
    input[p].engaged = true;
    input[p].state.position = tool.position + tool.orientation * scene.proxies[p].handle;
    input[p].state.orientation = tool.orientation;
    input[p].gains = scene.proxies[p].limit;
  }
  return input;
}

double calm_step(Simulation& simulation, const Timing& timing) {
  using Clock = std::chrono::steady_clock;
  const StepInput input = still_hands(simulation.scene());
  const int at_once = simulation.fluid_interval();
  const auto timed_steps = [&] {
    const Clock::time_point begin = Clock::now();
    for (int k = 0; k < at_once; ++k) simulation.step(input);
    const double took = std::chrono::duration<double>(Clock::now() - begin).count();
    const Health& health = simulation.output().health;
    if (!health.ok) throw std::runtime_error("the scene diverged while its steps were timed: " + health.cause);
    return took;
  };
  return typical_step(timed_steps, timing) / at_once;
}

}  // namespace palp
