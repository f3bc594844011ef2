// The scenes in which matter melts and freezes, as their hands play them.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scene_files.h"

namespace palp::test::melting_scenes_test {
namespace {

using Eigen::Vector3d;

struct Matter {
  Vector3d center = Vector3d::Zero();
  double solid = 0, top = -1e30, fastest = 0;
};

Matter matter_of(Simulation& simulation, const Body& body) {
  Snapshot s;
  simulation.snapshot(s);
  Matter m;
  for (std::size_t i = body.first; i < body.first + body.count; ++i) {
    const Vector3d x = Eigen::Map<const Eigen::Vector3f>(&s.position[3 * i]).cast<double>();
    m.center += x / body.count;
    m.solid += static_cast<double>(s.solid[i]) / body.count;
    m.top = std::max(m.top, x.z());
    m.fastest = std::max(m.fastest, double(Eigen::Map<const Eigen::Vector3f>(&s.velocity[3 * i]).norm()));
  }
  return m;
}

TEST(Butter, MeltsRunsAndFreezesAsItLies) {
  const Scene scene = scene_file("butter");
  const Body& butter = body_named(scene, "butter");
  const auto simulation = simulate(scene);
  run_until(*simulation, 0.2);
  Matter m = matter_of(*simulation, butter);
  EXPECT_NEAR(m.solid, 1, 1e-9);
  EXPECT_NEAR(m.top, 0.055, 0.003);
  run_until(*simulation, 3);
  m = matter_of(*simulation, butter);
  EXPECT_LT(m.solid, 0.02);
  EXPECT_LT(m.top, 0.015);
  run_until(*simulation, 4.5);
  m = matter_of(*simulation, butter);
  EXPECT_NEAR(m.solid, 1, 1e-9);
  EXPECT_LT(m.fastest, 0.01);
}

// The lump goes with its stick until it is in the hot water for a while; then the stick comes out bare.
TEST(MeltingTool, LosesItsIce) {
  const Scene scene = scene_file("melting_tool");
  const Body &ice = body_named(scene, "ice"), &stick = scene.bodies[scene.proxies[0].body];
  const auto simulation = simulate(scene);
  const Vector3d start = stick.position + stick.orientation * scene.proxies[0].handle;
  StepInput input;
  input[0].engaged = true;
  input[0].gains = scene.proxies[0].limit;
  double most = 0;
  const auto play = [&](double until, auto&& path) {
    while (simulation->output().time < until - 1e-9) {
      input[0].state.position = start + path(simulation->output().time);
      const StepOutput& out = simulation->step(input);
      ASSERT_TRUE(out.health.ok) << out.health.cause << " at " << out.time << " s";
      most = std::max(most, out.proxies[0].contact_force.norm());
    }
  };
  play(0.8, [](double t) { return Vector3d(0, 0, -0.05 * std::min(1.0, t / 0.6)); });
  Matter m = matter_of(*simulation, ice);
  EXPECT_GT(m.solid, 0.99);
  EXPECT_NEAR(m.center.z(), ice.position.z() - 0.05, 0.01) << "the ice hangs on its stick";
  play(1.4, [](double t) { return Vector3d(0, 0, -0.05 - 0.1 * std::min(1.0, (t - 0.8) / 0.5)); });
  most = 0;
  // until it has lost its ice, for three seconds at most
  for (double until = 2.4; until <= 4.5 && m.solid >= 0.05; until += 0.3) {
    play(until, [](double t) {
      const double a = 2 * M_PI * (t - 1.4) / 1.5;
      return Vector3d(0.04 * (1 - std::cos(a)), 0.04 * std::sin(a), -0.15);
    });
    m = matter_of(*simulation, ice);
  }
  RecordProperty("most_N", std::to_string(most));
  RecordProperty("solid_left", std::to_string(m.solid));
  EXPECT_GT(most, 0.1) << "the hand feels the lump in the water";
  EXPECT_LT(most, 60);
  EXPECT_LT(m.solid, 0.05);
}

}  // namespace
}  // namespace palp::test::melting_scenes_test
