// The simulated arm under a force that is held from tick to tick: exact, so that springs which are rendered once a tick
// meet the bounds that theory gives.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "haptic_bridge/device/simulated.h"
#include "tests/haptic_bridge/device/poses.h"

namespace palp::test::held_force_test {
namespace {

using Vec3 = Eigen::Vector3d;

constexpr std::int64_t kTick = 1'000'000;

// Viscous friction and nothing else; angular_damping: a hundredth of it.
ArmModel viscous(double damping) {
  ArmModel arm;
  arm.damping = damping;
  arm.angular_damping = 0.01 * damping;
  arm.friction = arm.angular_friction = arm.resolution = arm.angular_resolution = arm.velocity_filter_hz = 0;
  return arm;
}

HandScript nobody() {
  HandScript script;
  script.hand = {0, 0, 0};
  return script;
}

// Small and large shares of the friction in a step.
TEST(HeldForce, MovesTheArmAlongTheExactCurve) {
  for (const double damping : {0.01, 1.0, 100.0}) {
    const ArmModel arm = viscous(damping);
    SimulatedDevice device(arm, nobody(), kOrigin, kOrigin);
    DeviceReading reading;
    device.write({{0, 1.2, 0}, {0.02, 0, 0}});
    for (int i = 0; i <= 100; ++i) EXPECT_TRUE(device.read(i * kTick, reading));
    const auto way = [](double push, double friction, double inertia) {
      const double time = inertia / friction, t = 0.1;
      return push / friction * (t + time * std::expm1(-t / time));
    };
    EXPECT_NEAR(reading.state.position.y() / way(1.2, damping, arm.mass), 1, 1e-9) << damping;
    const Vec3 turned = rotation_between(kOrigin.orientation, reading.state.orientation);
    EXPECT_NEAR(turned.x() / way(0.02, arm.angular_damping, arm.inertia), 1, 1e-9) << damping;
  }
}

// The amplitude of an arm that is kicked against a spring: its last swings over its first.
double growth(const ArmModel& arm, double stiffness, bool angular) {
  SimulatedDevice device(arm, nobody(), kOrigin, kOrigin);
  DeviceReading reading;
  const int ticks = 40000;
  double first = 0, last = 0;
  for (int i = 0; i < ticks; ++i) {
    EXPECT_TRUE(device.read((i + 1) * kTick, reading));
    const double place =
        angular ? rotation_between(kOrigin.orientation, reading.state.orientation).z() : reading.state.position.z();
    const double push = (i == 0 ? 1e-3 * stiffness : 0) - stiffness * place;
    device.write(angular ? Wrench<double>{Vec3::Zero(), {0, 0, push}} : Wrench<double>{{0, 0, push}, Vec3::Zero()});
    if (i < ticks / 10) first = std::max(first, std::abs(place));
    if (i >= ticks - ticks / 10) last = std::max(last, std::abs(place));
  }
  return last / first;
}

// b > K T / 2 (Colgate & Schenkel 1997) for a wall without damping; exact while b T is small against the mass.
TEST(HeldForce, AWallWithoutDampingIsStableUpToColgatesBound) {
  for (const double damping : {0.5, 2.0}) {
    const ArmModel arm = viscous(damping);
    const double bound = 2 * arm.damping / 1e-3, angular_bound = 2 * arm.angular_damping / 1e-3;
    EXPECT_LT(growth(arm, 0.97 * bound, false), 0.7) << damping;
    EXPECT_GT(growth(arm, 1.03 * bound, false), 1.4) << damping;
    EXPECT_LT(growth(arm, 0.97 * angular_bound, true), 0.7) << damping;
    EXPECT_GT(growth(arm, 1.03 * angular_bound, true), 1.4) << damping;
  }
}

}  // namespace
}  // namespace palp::test::held_force_test
