// The simulated arm: its mechanics, its motors and encoders, and the hand that holds it.
#include "haptic_bridge/device/simulated.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "config/error.h"
#include "tests/haptic_bridge/device/poses.h"
#include "tests/support/seed.h"

namespace palp::test::simulated_test {
namespace {

using Vec3 = Eigen::Vector3d;
using Quat = Eigen::Quaterniond;

constexpr std::int64_t kTick = 1'000'000;

HandScript free_hand() {
  HandScript script;
  script.hand.mass = script.hand.damping = script.hand.stiffness = 0;
  return script;
}

ArmModel frictionless() {
  ArmModel arm;
  arm.damping = arm.angular_damping = arm.friction = arm.angular_friction = 0;
  return arm;
}

RigidState after(SimulatedDevice& device, int ticks, std::int64_t& now) {
  DeviceReading reading;
  for (int i = 0; i < ticks; ++i) {
    EXPECT_TRUE(device.read(now, reading));
    now += kTick;
  }
  return reading.state;
}

TEST(SimulatedArm, AcceleratesAsItsMassAndInertiaSay) {
  SimulatedDevice device(frictionless(), free_hand(), kOrigin, kOrigin);
  std::int64_t now = 0;
  device.write({{1.2, 0, 0}, {0, 0, 0.02}});
  after(device, 101, now);
  EXPECT_NEAR(device.true_state().linear.x(), 1.2 / 0.6 * 0.1, 1e-9);
  EXPECT_NEAR(device.true_state().position.x(), 0.5 * 1.2 / 0.6 * 0.01, 1e-12);
  EXPECT_NEAR(device.true_state().angular.z(), 0.02 / 0.004 * 0.1, 1e-9);
}

TEST(SimulatedArm, FrictionHoldsItAtRestAndSlowsItInMotion) {
  ArmModel arm;
  SimulatedDevice device(arm, free_hand(), kOrigin, kOrigin);
  std::int64_t now = 0;
  device.write({{0, 0.05, 0}, {0.001, 0, 0}});
  after(device, 2000, now);
  const Vec3 held = device.true_state().position;
  EXPECT_LT(held.norm(), 25e-6);
  after(device, 5000, now);
  EXPECT_LT((device.true_state().position - held).norm(), 1e-9);  // it does not creep
  EXPECT_LT(rotation_between(Quat::Identity(), device.true_state().orientation).norm(), 5e-4);

  device.write({{0, 1.1, 0}, {0, 0, 0}});
  after(device, 5000, now);
  EXPECT_NEAR(device.true_state().linear.y(), (1.1 - arm.friction) / arm.damping, 1e-3);
}

TEST(SimulatedArm, ItsMotorsGetWarmAndCoolDown) {
  ArmModel arm = frictionless();
  arm.motors = {20, 2, 10, 1};
  HandScript script;
  script.hand = kFirmGrip;
  SimulatedDevice device(arm, script, kOrigin, kOrigin);
  std::int64_t now = 0;
  DeviceReading reading;
  const auto alarms_after = [&](const Vec3& force, const Vec3& torque, int ticks) {
    device.write({force, torque});
    for (int i = 0; i < ticks; ++i, now += kTick) EXPECT_TRUE(device.read(now, reading));
    return reading.alarms;
  };
  // the mean square of 16 N over ten seconds comes to that of 10 N after 10 s * ln(1 / (1 - 100 / 256)) = 4.95 s
  EXPECT_EQ(alarms_after({16, 0, 0}, Vec3::Zero(), 4900), 0u);
  EXPECT_EQ(alarms_after({16, 0, 0}, Vec3::Zero(), 100), kArmHot);
  EXPECT_TRUE(reading.strained);
  alarms_after({16, 0, 0}, Vec3::Zero(), 1500);
  EXPECT_NEAR(reading.state.position.x(), 8 / script.hand.stiffness, 1e-4);  // half of the force is left
  EXPECT_EQ(alarms_after(Vec3::Zero(), Vec3::Zero(), 6000), 0u);
  EXPECT_EQ(alarms_after({21, 0, 0}, Vec3::Zero(), 5), kArmSaturated);
  EXPECT_EQ(alarms_after(Vec3::Zero(), {0, 2.1, 0}, 5), kArmSaturated);
  EXPECT_EQ(alarms_after({20, 0, 0}, {0, 2, 0}, 5), 0u);
}

TEST(SimulatedArm, StopsAtTheEndsOfItsJoints) {
  ArmModel arm = frictionless();
  arm.workspace = {0.1, 0.2, 0.05};
  arm.turn = 0.5;
  const Vec3 home(1, 2, 3);
  for (const double side : {-1.0, 1.0})
    for (int axis = 0; axis < 3; ++axis) {
      SimulatedDevice device(arm, free_hand(), at_rest(home, Quat::Identity()), at_rest(home, Quat::Identity()));
      std::int64_t now = 0;
      const Vec3 along = side * Vec3::Unit(axis);
      double furthest = 0, most_turned = 0;
      DeviceReading reading;
      device.write({5 * along, 0.1 * along});
      for (int i = 0; i < 3000; ++i, now += kTick) {
        device.read(now, reading);
        furthest = std::max(furthest, along.dot(device.true_state().position - home));
        most_turned = std::max(most_turned, rotation_between(Quat::Identity(), device.true_state().orientation).norm());
      }
      EXPECT_GT(furthest, arm.workspace[axis]);
      EXPECT_LT(furthest, arm.workspace[axis] + 0.01);
      EXPECT_GT(most_turned, arm.turn);
      EXPECT_LT(most_turned, arm.turn + 0.05);
      EXPECT_EQ(reading.alarms, kArmAtStop);
      EXPECT_LT(device.true_state().linear.norm(), 0.02);  // it has come to rest there
      device.write({-5 * along, -0.1 * along});
      for (int i = 0; i < 200; ++i, now += kTick) device.read(now, reading);
      EXPECT_EQ(reading.alarms, 0u);  // and a stop does not hold on to it
      EXPECT_LT(along.dot(device.true_state().position - home), arm.workspace[axis] - 0.05);
    }
}

TEST(SimulatedArm, YieldsToAForceAsTheGripSays) {
  ArmModel arm = frictionless();
  for (const HandModel& grip : {kHandsOff, kLightGrip, kFirmGrip}) {
    HandScript script;
    script.hand = grip;
    SimulatedDevice device(arm, script, kOrigin, kOrigin);
    std::int64_t now = 0;
    device.write({{0, 0, -0.4}, {0, 0.01, 0}});
    after(device, 30000, now);
    EXPECT_NEAR(device.true_state().position.z(), -0.4 / grip.stiffness, 1e-6);
    EXPECT_NEAR(rotation_between(Quat::Identity(), device.true_state().orientation).y(),
                0.01 / (grip.stiffness * grip.lever * grip.lever), 1e-5);
  }
}

TEST(SimulatedArm, ShowsWhatItsEncodersResolve) {
  HandScript script;
  script.keyframes = {{0, {0, 0, 0}}, {1, {0.1, 0.02, 0}, turn(0.5, {0, 0, 1})}};
  SimulatedDevice device(ArmModel{}, script, kOrigin, kOrigin);
  DeviceReading reading;
  for (std::int64_t now = 0; now < 1500 * kTick; now += kTick) {
    ASSERT_TRUE(device.read(now, reading));
    const double steps = reading.state.position.x() / 5e-6;
    ASSERT_NEAR(steps, std::round(steps), 1e-6);
    ASSERT_LT((reading.state.position - device.true_state().position).norm(), 5e-6);
    ASSERT_LT(rotation_between(reading.state.orientation, device.true_state().orientation).norm(), 1e-4);
    ASSERT_LT((reading.state.linear - device.true_state().linear).norm(), 0.03);  // the low-pass lags by 2.7 ms
  }
  EXPECT_LT(reading.state.linear.norm(), 0.01);
}

TEST(SimulatedArm, NeverRendersMoreThanItsLimit) {
  SimulatedDevice device(frictionless(), free_hand(), kOrigin, kOrigin);
  std::int64_t now = 0;
  EXPECT_TRUE(device.write({{1e6, 0, 0}, {0, 0, 0}}));
  after(device, 11, now);
  EXPECT_NEAR(device.true_state().linear.x(), 35 / 0.6 * 0.01, 1e-9);
  EXPECT_FALSE(device.write({{std::nan(""), 0, 0}, {0, 0, 0}}));
}

TEST(SimulatedArm, GoesToItsScriptUnhurriedFromWhereverItStarts) {
  const RigidState start = at_rest({0.2, 0, 0.1}, turn(2.4, {0, 1, 0}));
  HandScript script;
  script.keyframes = {{0, {0, 0, 0}}, {1, {0, 0, 0.1}}};
  SimulatedDevice device(ArmModel{}, script, kOrigin, start);
  std::int64_t now = 0;
  EXPECT_LT((after(device, 1, now).position - start.position).norm(), 1e-5);
  double fastest = 0;
  for (int i = 0; i < 8000; ++i) fastest = std::max(fastest, after(device, 1, now).linear.norm());
  EXPECT_LT(fastest, 0.3);
  EXPECT_LT((device.true_state().position - Vec3(0, 0, 0.1)).norm(), 1e-3);
}

TEST(SimulatedArm, StandsStillWhileTheLoopDoes) {
  HandScript script;
  script.keyframes = {{0, {0, 0, 0}}, {1, {0.1, 0, 0}}};
  SimulatedDevice device(ArmModel{}, script, kOrigin, kOrigin);
  std::int64_t now = 0;
  after(device, 500, now);
  const Vec3 before = device.true_state().position;
  now += 60'000'000'000;
  after(device, 1, now);
  EXPECT_LT((device.true_state().position - before).norm(), 0.03);
}

TEST(SimulatedArm, StaysBoundedUnderAnyWrench) {
  const unsigned seed = drawn_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::normal_distribution<double> n;
  for (const HandModel& grip : {kHandsOff, kLightGrip, kFirmGrip}) {
    HandScript script;
    script.hand = grip;
    script.hand.noise = 0.5;
    SimulatedDevice device(ArmModel{}, script, kOrigin, kOrigin);
    DeviceReading reading;
    std::int64_t now = 0;
    for (int i = 0; i < 5000; ++i) {
      now += static_cast<std::int64_t>(std::abs(n(random)) * kTick);
      ASSERT_TRUE(device.read(now, reading));
      ASSERT_TRUE(is_finite(reading.state) && is_unit(reading.state.orientation));
      ASSERT_LT(reading.state.position.norm(), 35 / 20.0 * 2);
      device.write({100 * Vec3(n(random), n(random), n(random)), Vec3(n(random), n(random), n(random))});
    }
  }
}

TEST(SimulatedArm, TremorHasItsForceAndRepeatsWithItsSeed) {
  // a handle held so stiffly that it resonates far above 10 Hz shows the force as force / stiffness
  HandScript script;
  const double stiffness = 4e6;
  script.hand = {20, 4000, stiffness, 0.1, 0.8, 5};
  SimulatedDevice one(frictionless(), script, kOrigin, kOrigin), two(frictionless(), script, kOrigin, kOrigin);
  script.hand.seed = 6;
  SimulatedDevice other(frictionless(), script, kOrigin, kOrigin);
  std::int64_t now = 0, now2 = 0, now3 = 0;
  double sum2 = 0;
  const int ticks = 60000;
  for (int i = 0; i < ticks; ++i) {
    after(one, 1, now);
    sum2 += one.true_state().position.squaredNorm() / 3;
  }
  after(two, ticks, now2);
  after(other, ticks, now3);
  EXPECT_EQ(one.true_state().position, two.true_state().position);
  EXPECT_NE(one.true_state().position, other.true_state().position);
  EXPECT_NEAR(std::sqrt(sum2 / ticks) * stiffness, 0.8, 0.1);
}

TEST(SimulatedArm, RefusesAModelThatItsTimeStepCannotCarry) {
  HandScript script;
  script.hand.mass = 0;
  script.hand.stiffness = 1e9;
  EXPECT_THROW(SimulatedDevice(ArmModel{}, script, kOrigin, kOrigin), ConfigError);
}

}  // namespace
}  // namespace palp::test::simulated_test
