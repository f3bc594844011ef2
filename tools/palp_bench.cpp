// Measures what a sub-step costs against the number of particles: fluid cuboids in a tray, at each support radius asked
// for. JSON with the hardware named. Times are of whole haptic steps, waits included, divided by their sub-steps.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <thread>

#include "config/error.h"
#include "sim_server/simulation.h"

namespace {

using palp::BodyType;

struct Arguments {
  std::vector<std::size_t> particles{1000, 10000, 30000, 100000, 1000000};
  std::vector<double> supports{2.0, 2.6, 3.0};
  std::string out;
  palp::Backend backend = palp::Backend::automatic;
  double seconds = 1.0;
  int sub_steps = 10;
};

// A cube of fluid of about n particles. tray: on a floor between walls of two layers, as a scene has them; else alone
// in a closed periodic box, as published figures are.
palp::Scene fluid_cube(std::size_t n, double support_over_spacing, int sub_steps) {
  const int edge = std::max(4, static_cast<int>(std::lround(std::cbrt(static_cast<double>(n)))));
  palp::Scene scene;
  const double dx = scene.spacing = 0.01, length = edge * dx;
  palp::SceneConfig& config = scene.config;
  config.path = config.name = "palp_bench";
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
        scene.position.emplace_back((i + 0.5) * dx, (j + 0.5) * dx, (k + 0.5) * dx);
        // a gentle vortex, so that the particles do not stay on their lattice
        const double s = 2 * EIGEN_PI / length;
        scene.velocity.emplace_back(0.5 * std::sin(s * i * dx) * std::cos(s * j * dx),
                                    -0.5 * std::cos(s * i * dx) * std::sin(s * j * dx), 0);
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
  std::size_t particles;
  double support, median_us, p10_us, p90_us;
  int steps;
};

Sample measure(palp::Simulation& simulation, double support, const Arguments& a) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times;
  const palp::StepInput input{};
  for (int k = 0; k < 3; ++k) simulation.step(input);
  const auto end = Clock::now() + std::chrono::duration<double>(a.seconds);
  while (Clock::now() < end || times.size() < 5) {
    const auto t0 = Clock::now();
    const palp::StepOutput& out = simulation.step(input);
    times.push_back(1e6 * std::chrono::duration<double>(Clock::now() - t0).count() / a.sub_steps);
    if (!out.health.ok) throw std::runtime_error("the benchmark's fluid diverged: " + out.health.cause);
  }
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  return {simulation.scene().position.size(), support, at(0.5), at(0.1), at(0.9), static_cast<int>(times.size())};
}

int run(const Arguments& a) {
  std::vector<Sample> samples;
  std::string name;
  for (double support : a.supports)
    for (std::size_t n : a.particles) {
      const palp::Scene scene = fluid_cube(n, support, a.sub_steps);
      const auto simulation = palp::make_simulation(scene, a.backend);
      name = simulation->backend_name();
      samples.push_back(measure(*simulation, support, a));
      const Sample& s = samples.back();
      fmt::print(
          stderr, "H = {} dx, {:8} particles: {:9.1f} us a sub-step ({:.1f} .. {:.1f}), {:.1f} M particle-steps/s\n",
          s.support, s.particles, s.median_us, s.p10_us, s.p90_us, static_cast<double>(s.particles) / s.median_us);
    }
  std::string json = fmt::format(
      "{{\n  \"benchmark\": \"fluid sub-step, periodic cube, accurate\",\n  \"backend\": \"{}\",\n  \"processor\": "
      "\"{}\",\n  \"cores\": {},\n"
      "  \"sub_steps_per_step\": {},\n  \"results\": [\n",
      name, processor_name(), std::thread::hardware_concurrency(), a.sub_steps);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Sample& s = samples[k];
    json += fmt::format(
        "    {{\"support_over_spacing\": {}, \"particles\": {}, \"median_us\": {:.2f}, \"p10_us\": {:.2f}, \"p90_us\": "
        "{:.2f}, \"steps\": {}}}{}\n",
        s.support, s.particles, s.median_us, s.p10_us, s.p90_us, s.steps, k + 1 < samples.size() ? "," : "");
  }
  json += "  ]\n}\n";
  if (a.out.empty()) {
    fmt::print("{}", json);
    return 0;
  }
  std::ofstream out(a.out);
  out << json;
  out.close();
  if (!out) throw std::runtime_error(a.out + ": could not be written; expected a writable file");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Measures the cost of a fluid sub-step against the number of particles.");
  Arguments a;
  static const std::map<std::string, palp::Backend> backends{
      {"auto", palp::Backend::automatic}, {"cpu", palp::Backend::cpu}, {"cuda", palp::Backend::cuda}};
  app.add_option("--backend", a.backend, "auto, cpu or cuda (default: auto)")
      ->transform(CLI::CheckedTransformer(backends));
  app.add_option("--particles", a.particles, "Numbers of particles, rounded to cubes")
      ->delimiter(',')
      ->check(CLI::Range(64, 20000000));
  app.add_option("--support", a.supports, "Support radii in spacings")->delimiter(',')->check(CLI::Range(1.8, 4.0));
  app.add_option("--seconds", a.seconds, "Time to measure each case for")->check(CLI::Range(0.01, 600.0));
  app.add_option("--sub-steps", a.sub_steps, "Sub-steps in a haptic step")->check(CLI::Range(1, 100));
  app.add_option("--out", a.out, "JSON file (default: standard output)");
  CLI11_PARSE(app, argc, argv);
  try {
    return run(a);
  } catch (const std::exception& error) {
    fmt::print(stderr, "palp_bench: {}\n", error.what());
    return 1;
  }
}
