// Rigid bodies on their own: free fall, torque-free rotation, contact.
#include <gtest/gtest.h>

#include "tests/support/backend.h"
#include "tests/support/scenes.h"
#include "tests/support/tolerance.h"

namespace palp::test::rigid_test {
namespace {

// One free rigid body of a few particles, away from everything.
class LoneBody : public ::testing::TestWithParam<Method> {};

Scene lone_body(double rate_hz, Method method) {
  Scene scene = empty_scene(0.1, {-5, -5, -20}, {5, 5, 5});
  scene.config.method = method;
  scene.config.rate_hz = rate_hz;
  const auto wood = add_material(scene, 500, 0);
  add_body(scene, "box", BodyKind::rigid, wood, {-0.2, -0.1, -0.1}, {0.2, 0.1, 0.1});
  return scene;
}

TEST_P(LoneBody, FallsFreely) {
  Scene scene = lone_body(1000, GetParam());
  scene.bodies[0].velocity = {0.3, 0, 1};
  for (Eigen::Vector3d& v : scene.velocity) v = scene.bodies[0].velocity;
  const auto simulation = simulate(scene);
  const StepOutput* out = nullptr;
  constexpr int n = 1000;
  for (int k = 0; k < n; ++k) out = &simulation->step({});
  ASSERT_TRUE(out->health.ok) << out->health.cause;
  const double t = n * 1e-3, dt = 1e-3;
  const RigidState& state = out->bodies[0].state;
  // symplectic Euler: x = v0 t + g t (t + dt) / 2
  EXPECT_TRUE(within((state.linear - Eigen::Vector3d(0.3, 0, 1 - 9.81 * t)).norm() / 9.81, tol::kFreeFall));
  const Eigen::Vector3d fallen(0.3 * t, 0, t - 9.81 * t * (t + dt) / 2);
  EXPECT_TRUE(within((state.position - fallen).norm() / 9.81, tol::kFreeFall,
                     {"D15 free fall of a rigid body for 1 s", "g t (t + dt) / 2, " + quantity(-fallen.z(), "m"),
                      quantity(1e6 * (state.position - fallen).norm(), "um off"), GetParam()}));
  EXPECT_LT(state.orientation.angularDistance(Eigen::Quaterniond::Identity()), 1e-6);
  // the particles are where the body is
  Snapshot s;
  simulation->snapshot(s);
  for (std::size_t i = 0; i < scene.position.size(); ++i)
    EXPECT_NEAR(s.position[3 * i + 2], scene.position[i].z() + fallen.z(), 1e-5);
}

// Dzhanibekov's top: I = (1, 2, 3), spun about the middle axis with a small error, flips every 11.578 s (elliptic
// integrals). Its energy and angular momentum stay.
TEST_P(LoneBody, TorqueFreeTopKeepsEnergyAndFlipsInTime) {
  Scene scene = lone_body(1000, GetParam());
  scene.config.gravity.setZero();
  Body& body = scene.bodies[0];
  body.inertia = Eigen::Vector3d(1, 2, 3).asDiagonal();
  body.angular_velocity = {0.01, 2, 0};
  const auto simulation = simulate(scene);
  const auto energy = [&](const RigidState& s) {
    const Eigen::Vector3d w = s.orientation.conjugate() * s.angular;
    return 0.5 * w.dot(body.inertia * w);
  };
  const auto momentum = [&](const RigidState& s) {
    return Eigen::Vector3d(s.orientation * (body.inertia * (s.orientation.conjugate() * s.angular)));
  };
  const Eigen::Vector3d L(0.01, 4, 0);
  const double E = 0.5 * (1e-4 + 8);
  double worst_energy = 0, worst_momentum = 0, before = 1;
  std::vector<double> flips;
  for (int k = 1; k <= 60000; ++k) {
    const RigidState& s = simulation->step({}).bodies[0].state;
    worst_energy = std::max(worst_energy, std::abs(energy(s) / E - 1));
    worst_momentum = std::max(worst_momentum, (momentum(s) - L).norm() / L.norm());
    const double about_middle = (s.orientation.conjugate() * s.angular).y();
    if (about_middle * before < 0) flips.push_back(k * 1e-3);
    before = about_middle;
  }
  // angular velocity and orientation are half a step apart: |w| dt / 2 of the part that turns
  EXPECT_LT(worst_momentum, 3e-3);
  EXPECT_TRUE(within(worst_energy, tol::kTopEnergy,
                     {"D15 torque-free top, I = (1, 2, 3): energy over 60 s", "no change of " + quantity(E, "J"),
                      quantity(1e3 * worst_energy * E, "mJ at most"), GetParam()}));
  RecordProperty("energy_error", std::to_string(worst_energy));
  ASSERT_GE(flips.size(), 5u);
  // the time between flips grows with the logarithm of the distance from the unstable axis, an energy of 1e-5: what
  // round-off in float does to it shows after some flips
  for (std::size_t k = 1; k < (sizeof(real) == sizeof(double) ? flips.size() : 2); ++k)
    EXPECT_TRUE(within(flips[k] - flips[k - 1] - 11.578, tol::kTopFlip,
                       {"D15 torque-free top, I = (1, 2, 3): time between flips", "11.578 s (elliptic integrals)",
                        quantity(flips[k] - flips[k - 1], "s"), GetParam()}));
  // what the integrator itself keeps, L.w / 2 with both from mid-step
  const double kinetic = simulation->step({}).health.kinetic_energy;
  EXPECT_TRUE(within(kinetic / E - 1, tol::kTopEnergy));
}

INSTANTIATE_TEST_SUITE_P(Methods, LoneBody, ::testing::Values(Method::accurate, Method::paper),
                         [](const auto& param) { return to_string(param.param); });

// A block dropped flat on a floor: a whole face of contacts at once. It comes to rest on the floor.
double resting_height(int across, double drop, double& kinetic_energy, bool& ok) {
  constexpr double dx = 0.01;
  const double half = 0.5 * across * dx, reach = half + 0.02;
  Scene scene = empty_scene(dx, {-reach, -reach, -0.05}, {reach, reach, 0.5});
  const auto wood = add_material(scene, 500, 0);
  add_body(scene, "floor", BodyKind::fixed, wood, {-reach, -reach, -0.03}, {reach, reach, 0});
  const auto block = add_body(scene, "block", BodyKind::rigid, wood, {-half, -half, drop}, {half, half, drop + 0.04});
  const auto simulation = simulate(scene);
  const StepOutput* out = nullptr;
  for (int k = 0; k < 800; ++k) out = &simulation->step({});
  ok = out->health.ok;
  kinetic_energy = out->health.kinetic_energy / (scene.bodies[block].mass * 9.81 * dx);
  return (out->bodies[block].state.position.z() - 0.02) / dx;
}

TEST(Rigid, BlockComesToRestOnAFloor) {
  for (int across : {3, 8, 20}) {
    SCOPED_TRACE(std::to_string(across) + " particles across");
    double energy = 0;
    bool ok = false;
    // 0: faces touch; particles' centres then are a spacing apart
    const double height = resting_height(across, 0.005, energy, ok);
    EXPECT_TRUE(ok);
    EXPECT_NEAR(height, 0, 0.3) << "in spacings";
    EXPECT_LT(energy, 0.05) << "relative to the weight times a spacing";
  }
}

}  // namespace
}  // namespace palp::test::rigid_test
