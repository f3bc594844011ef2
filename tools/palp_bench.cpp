// Measures what a sub-step costs against the number of particles: periodic cubes of fluid, at each support radius asked
// for, or scenes, their tools held still by a hand. JSON with the hardware named. Times are of whole haptic steps,
// waits included, divided by their sub-steps.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>

#include "config/command_line.h"
#include "config/json_file.h"
#include "config/number_between.h"
#include "sim_server/scene_options.h"
#include "sim_server/solver/plan.h"
#include "sim_server/threads/thread_team.h"
#include "sim_server/trade/calibration.h"

namespace {

struct Arguments {
  std::vector<std::size_t> particles;  // empty: the default ones of cubes, a scene's own
  std::vector<std::string> scenes;
  palp::SceneOverrides overrides;  // of scenes
  palp::ChoiceRequest choice;      // of scenes
  std::vector<double> supports{2.0, 2.6, 3.0};
  std::string out;
  palp::Backend backend = palp::Backend::automatic;
  double seconds = 1.0;
  std::optional<int> sub_steps;  // unset: 10 of cubes, a scene's own
};

// A periodic cube of fluid of about n particles, as published figures are: calm, its particles a little off their
// lattice, or stirred by a vortex of a twentieth of the sound speed, which leaves nothing of the lattice and tears at
// the fluid.
palp::Scene fluid_cube(std::size_t n, double support_over_spacing, int sub_steps, bool stirred) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> jitter(-0.1, 0.1);
  const int edge = std::max(4, static_cast<int>(std::lround(std::cbrt(static_cast<double>(n)))));
  palp::Scene scene;
  const double dx = scene.spacing = 0.01, length = edge * dx;
  palp::SceneConfig& config = scene.config;
  config.path = config.name = "palp-bench";
  config.gravity.setZero();
  config.periodic = {true, true, true};
  config.domain_min = scene.bounds_min = Eigen::Vector3d::Zero();
  config.domain_max = scene.bounds_max = Eigen::Vector3d::Constant(length);
  config.numerics.support_over_spacing = support_over_spacing;
  config.numerics.sound_speed = 10;
  config.numerics.max_speed = 1;
  config.numerics.sub_steps = sub_steps;
  config.rate_hz = 1.0 / (sub_steps * 0.4 * dx / 10);
  palp::MaterialConfig water;
  water.name = "water";
  config.materials.push_back(water);
  palp::Body body;
  body.name = "fluid";
  for (int k = 0; k < edge; ++k)
    for (int j = 0; j < edge; ++j)
      for (int i = 0; i < edge; ++i) {
        Eigen::Vector3d x(i + 0.5, j + 0.5, k + 0.5), v = Eigen::Vector3d::Zero();
        const double s = 2 * EIGEN_PI / edge;
        if (stirred)
          v = 0.5 * Eigen::Vector3d(std::sin(s * i) * std::cos(s * j), -std::cos(s * i) * std::sin(s * j), 0);
        else
          x += Eigen::Vector3d(jitter(random), jitter(random), jitter(random));
        scene.position.push_back(dx * x);
        scene.velocity.push_back(v);
      }
  body.count = static_cast<std::uint32_t>(scene.position.size());
  scene.volume.assign(body.count, dx * dx * dx);
  scene.body.assign(body.count, 0);
  scene.bodies.push_back(body);
  return scene;
}

std::string processor_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown";
}

struct Sample {
  std::string what;  // "calm" or "stirred", or the scene
  std::size_t particles;
  double support;  // [spacings]
  int sub_steps;   // of a haptic step
  // of a sub-step, on the mean over the haptic steps that fluids take at once
  double median_us, p10_us, p90_us, p99_us;
  int steps;
};

Sample measure(palp::Simulation& simulation, const std::string& what, const Arguments& a) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times;
  const palp::StepInput input = palp::still_hands(simulation.scene());
  const int sub_steps = simulation.sub_steps(), at_once = simulation.fluid_interval();
  for (int k = 0; k < 3 * at_once; ++k) simulation.step(input);
  const auto end = Clock::now() + std::chrono::duration<double>(a.seconds);
  while (Clock::now() < end || times.size() < 5) {
    const auto t0 = Clock::now();
    for (int k = 0; k < at_once; ++k) simulation.step(input);
    times.push_back(1e6 * std::chrono::duration<double>(Clock::now() - t0).count() / (sub_steps * at_once));
    const palp::Health& health = simulation.output().health;
    if (!health.ok) throw std::runtime_error("the benchmark diverged: " + health.cause);
  }
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  const palp::Scene& scene = simulation.scene();
  return {what,
          scene.position.size(),
          simulation.support_radius() / scene.spacing,
          sub_steps,
          at(0.5),
          at(0.1),
          at(0.9),
          at(0.99),
          at_once * static_cast<int>(times.size())};
}

palp::Json json_of(const std::vector<Sample>& samples, const std::string& backend, bool scenes) {
  const auto to_hundredths = [](double us) { return 0.01 * std::round(100 * us); };
  palp::Json results = palp::Json::array();
  for (const Sample& s : samples) {
    results.push_back({{scenes ? "scene" : "flow", s.what},
                       {"support_over_spacing", 0.01 * std::round(100 * s.support)},
                       {"sub_steps_per_step", s.sub_steps},
                       {"particles", s.particles},
                       {"median_us", to_hundredths(s.median_us)},
                       {"p10_us", to_hundredths(s.p10_us)},
                       {"p90_us", to_hundredths(s.p90_us)},
                       {"calm_step_s", 1e-6 * to_hundredths(s.median_us * s.sub_steps)},
                       {"p99_us", to_hundredths(s.p99_us)},
                       {"steps", s.steps}});
  }
  return {{"benchmark", scenes ? "sub-step of scenes" : "fluid sub-step, periodic cube, accurate"},
          {"backend", backend},
          {"processor", processor_name()},
          {"cores", palp::usable_processors()},
          {"results", results}};
}

struct Bench {
  const Arguments& a;
  std::vector<Sample> samples;
  std::string backend;

  void add(const palp::Scene& scene, const std::string& what) {
    if (scene.config.choice) fmt::print(stderr, "{}\n", palp::told(*scene.config.choice));
    const auto simulation = palp::make_simulation(scene, a.backend);
    backend = simulation->backend_name();
    samples.push_back(measure(*simulation, what, a));
    const Sample& s = samples.back();
    fmt::print(stderr,
               "{}, H = {:.2g} dx, {:8} particles: {:9.1f} us a sub-step ({:.1f} .. {:.1f}) of {}, {:.1f} M "
               "particle-steps/s\n",
               s.what, s.support, s.particles, s.median_us, s.p10_us, s.p90_us, s.sub_steps,
               static_cast<double>(s.particles) / s.median_us);
  }
};

void add_cubes(const Arguments& a, Bench& bench) {
  const std::vector<std::size_t> counts =
      a.particles.empty() ? std::vector<std::size_t>{1000, 10000, 30000, 100000, 1000000} : a.particles;
  for (const bool stirred : {false, true})
    for (const double support : a.supports)
      for (const std::size_t n : counts)
        bench.add(fluid_cube(n, support, a.sub_steps.value_or(10), stirred), stirred ? "stirred" : "calm");
}

// The scene with this many sub-steps in each haptic step, as long as they are.
palp::Scene with_sub_steps(palp::Scene scene, std::optional<int> sub_steps) {
  if (!sub_steps) return scene;
  scene.config.rate_hz *= static_cast<double>(palp::make_plan(scene).sub_steps) / *sub_steps;
  scene.config.numerics.sub_steps = sub_steps;
  return scene;
}

void add_scenes(const Arguments& a, Bench& bench) {
  for (const std::string& name : a.scenes) {
    palp::SceneOptions options;
    options.scene = name;
    options.overrides = a.overrides;
    options.choice = a.choice;
    options.backend = a.backend;
    if (a.particles.empty()) bench.add(with_sub_steps(palp::open_scene(options), a.sub_steps), name);
    for (const std::size_t n : a.particles) {
      options.particles = n;
      bench.add(with_sub_steps(palp::open_scene(options), a.sub_steps), name);
    }
  }
}

int run(const Arguments& a) {
  Bench bench{a, {}, {}};
  if (a.scenes.empty())
    add_cubes(a, bench);
  else
    add_scenes(a, bench);
  const palp::Json json = json_of(bench.samples, bench.backend, !a.scenes.empty());
  if (a.out.empty()) {
    fmt::print("{}", palp::json_text(json));
  } else {
    palp::write_json(a.out, json);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Measures the cost of a sub-step against the number of particles.");
  Arguments a;
  palp::add_backend_option(app, a.backend);
  app.add_option("--scene", a.scenes, "Scenes instead of cubes of fluid: files, or names of those in config/scenes")
      ->delimiter(',');
  CLI::Option* accuracy = palp::add_accuracy_option(app, a.overrides.accuracy);
  CLI::Option* spacing =
      app.add_option("--spacing", a.overrides.spacing, "Particle spacing of scenes in metres, instead of theirs");
  CLI::Option* particles =
      app.add_option("--particles", a.particles, "Numbers of particles, rounded to cubes; of a scene, of its matter")
          ->delimiter(',')
          ->check(CLI::Range(64, 20000000))
          ->excludes(spacing);
  palp::add_choice_options(app, a.choice, {accuracy, spacing, particles});
  palp::add_set_option(app, a.overrides);
  app.add_option("--support", a.supports, "Support radii in spacings, of cubes")
      ->delimiter(',')
      ->check(palp::number_between(1.8, 4.0));
  app.add_option("--seconds", a.seconds, "Time to measure each case for")->check(palp::number_between(0.01, 600.0));
  app.add_option("--sub-steps", a.sub_steps, "Sub-steps in a haptic step (10 of cubes, a scene's own)")
      ->check(CLI::Range(1, 100));
  app.add_option("--out", a.out, "JSON file (default: standard output)");
  return palp::run_program("palp-bench", app, argc, argv, [&] { return run(a); });
}
