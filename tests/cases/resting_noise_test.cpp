// The noise of the force on a hand that holds its tool still in a resting fluid.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/tolerance.h"

namespace palp::test::resting_noise_test {
namespace {

// The tray of the demo with its tool half under water, for ten seconds once the waves of the start are over: they lose
// half of their height in a second and are a millinewton after six. A tool that no hand holds is held where it is, so
// that the force on it is the fluid's alone.
TEST(RestingFluid, IsStillInTheHand) {
  SceneOverrides overrides;
  overrides.accuracy = Accuracy::fast;
  SceneConfig config = load_scene(PALP_SOURCE_DIR "/config/scenes/tray_fluid.toml", overrides);
  for (BodyConfig& body : config.bodies) {
    if (body.type == BodyKind::rigid) body.position.z() = 0.13;
    if (body.type != BodyKind::fluid) continue;
    ShapeConfig hole;
    hole.type = ShapeType::sphere;
    hole.radius = 0.05;
    hole.position.z() = 0.13 - body.position.z();
    hole.subtract = true;
    body.shapes.push_back(hole);
  }
  const Scene scene = sample_scene(config, 100000);
  const auto simulation = simulate(scene);
  std::vector<double> force;
  while (simulation->output().time < 16) {
    const StepOutput& out = simulation->step({});
    ASSERT_TRUE(out.health.ok) << out.health.cause;
    if (out.time > 6) force.push_back(out.proxies[0].contact_force.z());
  }
  double mean = 0, square = 0, least = 1e30, most = -1e30;
  for (const double f : force) mean += f / static_cast<double>(force.size());
  for (const double f : force) {
    square += (f - mean) * (f - mean) / static_cast<double>(force.size());
    least = std::min(least, f);
    most = std::max(most, f);
  }
  RecordProperty("mean", std::to_string(mean));
  RecordProperty("rms", std::to_string(std::sqrt(square)));
  RecordProperty("peak_to_peak", std::to_string(most - least));
  const double dry = 0.02, submerged = EIGEN_PI * (4.0 / 3 * std::pow(0.05, 3) - dry * dry * (0.05 - dry / 3));
  const double lift = 1000 * 9.81 * submerged;  // 3 cm of the ball's upper half are under water, too
  EXPECT_TRUE(within(mean / lift - 1, tol::kCoarseBuoyancy));
  EXPECT_TRUE(within(std::sqrt(square), tol::kRestingNoise));
}

}  // namespace
}  // namespace palp::test::resting_noise_test
