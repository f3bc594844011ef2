#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <utility>

#include <gtest/gtest.h>
#include <unistd.h>

#include "config/error.h"
#include "haptic_bridge/device/profile.h"
#include "haptic_bridge/device/replay.h"
#include "haptic_bridge/device/simulated.h"
#include "haptic_bridge/device/virtuose/session.h"
#include "haptic_bridge/loop/local_model.h"
#include "tests/support/seed.h"

namespace palp {
namespace {

using Vec3 = Eigen::Vector3d;
using Quat = Eigen::Quaterniond;

constexpr std::int64_t kTick = 1'000'000;
const RigidState kOrigin = at_rest(Vec3::Zero(), Quat::Identity());

Quat turn(double angle, const Vec3& axis) { return Quat(Eigen::AngleAxisd(angle, axis.normalized())); }

// ---- paths

std::vector<Keyframe> some_path() {
  return {{0, {0, 0, 0}, Quat::Identity()},
          {0.5, {0.1, 0, 0.05}, turn(1.0, {1, 2, 0})},
          {0.8, {0.1, 0.2, 0}, turn(-0.7, {0, 1, 1})},
          {2.0, {0, 0.1, -0.1}, turn(1.2, {1, 0, 3})},
          {2.5, {0, 0, 0}, Quat::Identity()}};
}

TEST(Trajectory, TwistIsTheDerivativeOfThePose) {
  const double h = 1e-6, kTolerance = 1e-4;  // central difference of a cubic near unit speed
  for (const Interpolation kind : {Interpolation::catmull_rom, Interpolation::minimum_jerk}) {
    const Trajectory path(some_path(), kind, true);
    for (double t = 0.013; t < 6; t += 0.0371) {
      const RigidState now = path.at(t), ahead = path.at(t + h), behind = path.at(t - h);
      EXPECT_LT((now.linear - (ahead.position - behind.position) / (2 * h)).norm(), kTolerance) << t;
      EXPECT_LT((now.angular - rotation_between(behind.orientation, ahead.orientation) / (2 * h)).norm(), kTolerance)
          << t;
      EXPECT_NEAR(now.orientation.norm(), 1, 1e-12);
    }
  }
}

TEST(Trajectory, PassesThroughItsKeyframesWithoutAJumpInTwist) {
  const Trajectory path(some_path(), Interpolation::catmull_rom, true);
  const double h = 1e-9;
  for (const Keyframe& k : path.keyframes()) {
    const RigidState before = path.at(2.5 + k.time - h), after = path.at(2.5 + k.time + h);
    EXPECT_LT((before.position - k.x).norm(), 1e-8);
    EXPECT_LT(rotation_between(before.orientation, k.q).norm(), 1e-7);
    EXPECT_LT((before.linear - after.linear).norm(), 1e-6);
    EXPECT_LT((before.angular - after.angular).norm(), 1e-5);
  }
}

TEST(Trajectory, RestsBeforeItsBeginAndAfterItsEnd) {
  std::vector<Keyframe> keys = some_path();
  keys.back().x.x() = 0.5;
  const Trajectory path(keys, Interpolation::minimum_jerk, false);
  EXPECT_EQ(path.at(-1).position, keys.front().x);
  EXPECT_EQ(path.at(100).position, keys.back().x);
  EXPECT_EQ(path.at(100).linear.norm(), 0);
}

TEST(Trajectory, RefusesWhatIsNoPath) {
  const auto refused = [](std::vector<Keyframe> k, bool loop) {
    EXPECT_THROW(Trajectory(std::move(k), Interpolation::catmull_rom, loop), std::invalid_argument);
  };
  refused({}, false);
  refused({{0, {0, 0, 0}}, {0, {1, 0, 0}}}, false);
  refused({{0, {0, 0, 0}}, {1, {1, 0, 0}}}, true);
  refused({{0, {0, 0, 0}}, {1, {0, 0, 0}, turn(3, {0, 0, 1})}}, false);
  refused({{0, {0, 0, 0}}}, true);
}

// ---- the arm

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
  const unsigned seed = test::drawn_seed();
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

// ---- files

class Files : public ::testing::Test {
 protected:
  std::string write(const std::string& text) {
    path_ = (std::filesystem::temp_directory_path() / ("palp_device_test_" + std::to_string(getpid()))).string();
    std::ofstream(path_) << text;
    return path_;
  }
  void TearDown() override { std::filesystem::remove(path_); }
  std::string path_;
};

template <class F>
std::string fault_of(F&& f) {
  try {
    f();
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "no fault";
}

using Replay = Files;
const std::string kHead = "time,x,y,z,qx,qy,qz,qw\n";

TEST_F(Replay, PlaysThePathAndHoldsItsEnd) {
  ReplayDevice device(write(kHead + "5,0,0,0,0,0,0,1\n6,0.1,0,0,0,0,0,1\n7,0.2,0,0,0,0,0.70710678,0.70710678\n"),
                      false);
  DeviceReading reading;
  ASSERT_TRUE(device.read(123, reading));
  EXPECT_EQ(reading.state.position.x(), 0);
  ASSERT_TRUE(device.read(123 + 1'000'000'000, reading));
  EXPECT_NEAR(reading.state.position.x(), 0.1, 1e-12);
  EXPECT_NEAR(reading.state.linear.x(), 0.1, 1e-12);
  ASSERT_TRUE(device.read(123 + 9'000'000'000, reading));
  EXPECT_NEAR(reading.state.position.x(), 0.2, 1e-12);
  EXPECT_EQ(reading.state.linear.norm(), 0);
  EXPECT_NEAR(rotation_between(Quat::Identity(), reading.state.orientation).z(), M_PI / 2, 1e-7);
}

TEST_F(Replay, NamesTheLineOfEachFault) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "no poses"},
      {"t,x,y,z\n", ":1: the header is"},
      {kHead, "no poses"},
      {kHead + "0,0,0,0,0,0,0\n", ":2: expected 8 cells"},
      {kHead + "0,0,0,0,0,0,0,1,9\n", ":2: expected 8 cells"},
      {kHead + "0,0,0,0,0,0,0,1\n1,a,0,0,0,0,0,1\n", ":3: 'a' is no number"},
      {kHead + "0,0,0,nan,0,0,0,1\n", ":2: 'nan' is no number"},
      {kHead + "0,0,0,0,0,0,0,0.9\n", ":2: the quaternion"},
      {kHead + "0,0,0,0,0,0,0,1\n0,0,0,0,0,0,0,1\n", ":3: time is 0, expected more"},
      {kHead + "0,0,0,0,0,0,0,1\n1,0,0,0,1,0,0,0\n", ":3: it turns by more than 143 degrees"},
  };
  for (const auto& [text, expected] : cases) {
    const std::string file = write(text);
    const std::string fault = fault_of([&] { ReplayDevice device(file, false); });
    EXPECT_NE(fault.find(expected), std::string::npos) << fault;
    EXPECT_EQ(fault.find(file), 0u) << fault;
  }
  EXPECT_NE(fault_of([] { ReplayDevice d("/nowhere/path.csv", false); }).find("no such file"), std::string::npos);
  const std::string open_path = write(kHead + "0,0,0,0,0,0,0,1\n1,1,0,0,0,0,0,1\n");
  EXPECT_NE(fault_of([&] { ReplayDevice d(open_path, true); }).find("must end in the pose"), std::string::npos);
}

using Profiles = Files;

TEST_F(Profiles, TheShippedFilesAreReadAndSayWhatTheyShould) {
  const std::string config = PALP_SOURCE_DIR "/config/";
  const DeviceProfile profile = read_device_profile(config + "devices/simulated.toml");
  EXPECT_EQ(profile.loop.limits.force, 35);
  EXPECT_EQ(profile.loop.limits.torque, 3);
  EXPECT_EQ(profile.loop.gains, DeviceProfile{}.loop.gains);
  EXPECT_EQ(profile.setup<ArmModel>().mass, ArmModel{}.mass);
  EXPECT_EQ(profile.setup<ArmModel>().resolution, ArmModel{}.resolution);
  for (const char* name : {"still", "stir", "press"}) {
    const HandScript script = read_hand_script(config + "hands/" + name + ".toml");
    EXPECT_EQ(script.keyframes.front().x.norm(), 0) << name;
    SimulatedDevice device(profile.setup<ArmModel>(), script, kOrigin, kOrigin);
    double fastest = 0;
    for (double t = 0; t < 12; t += 1e-3) fastest = std::max(fastest, device.intent(t).linear.norm());
    EXPECT_LT(fastest, 0.5) << name;
  }
}

TEST_F(Profiles, TheShippedVirtuosesAskForTheirArmAndForNoMoreThanItHolds) {
  const std::string folder = PALP_SOURCE_DIR "/config/devices/virtuose_";
  for (const auto& [name, type, force, torque] :
       {std::tuple{"6d", 3, 10.0, 1.0}, {"6d_desktop", 4, 3.0, 0.2}, {"6d_tao", 0, 30.0, 1.5}, {"sim", 3, 10.0, 1.0}}) {
    SCOPED_TRACE(name);
    const DeviceProfile profile = read_device_profile(folder + name + ".toml");
    EXPECT_TRUE(profile.setup<VirtuoseSetup>().in_profile);
    EXPECT_EQ(profile.setup<VirtuoseSetup>().device_type.value_or(0), type);
    EXPECT_EQ(profile.loop.limits.force, force);
    EXPECT_EQ(profile.loop.limits.torque, torque);
    EXPECT_EQ(profile.setup<VirtuoseSetup>().mode, VirtuoseMode::impedance);
    EXPECT_EQ(profile.setup<VirtuoseSetup>().axes, default_arm_axes());
    EXPECT_EQ(profile.setup<VirtuoseSetup>().relay_time, 3);
    EXPECT_TRUE(profile.loop.workspace.relative);
  }
  EXPECT_FALSE(read_device_profile(PALP_SOURCE_DIR "/config/devices/simulated.toml").setup<VirtuoseSetup>().in_profile);
}

TEST_F(Profiles, AxesAreARotationThatMayBeTurned) {
  const std::string head = "name = \"x\"\n[limits]\n[axes]\n";
  const DeviceProfile turned = read_device_profile(write(head + "x = \"-y\"\ny = \"+x\"\nz = \"+z\"\nturn_deg = 90\n"));
  EXPECT_LT((turned.setup<VirtuoseSetup>().axes - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  const std::vector<std::pair<std::string, std::string>> cases{
      {"x = \"+x\"\ny = \"+x\"\nz = \"+z\"\n", ":3: "},
      {"x = \"+y\"\ny = \"+x\"\nz = \"+z\"\n", "right-handed"},
      {"x = \"up\"\ny = \"+x\"\nz = \"+z\"\n", ":4: "},
      {"x = \"-y\"\ny = \"+x\"\n", "z"},
      {"x = \"-y\"\ny = \"+x\"\nz = \"+z\"\nturn_deg = 900\n", ":7: "},
      {"x = \"-y\"\ny = \"+x\"\nz = \"+z\"\n[virtuose]\nmode = \"admittance\"\n", ":8: "},
      {"x = \"-y\"\ny = \"+x\"\nz = \"+z\"\n[virtuose]\ndevice = 3\n", ":8: "},
      {"x = \"-y\"\ny = \"+x\"\nz = \"+z\"\n[virtuose]\nrelay_time = -1\n", ":8: "},
  };
  for (const auto& [text, expected] : cases) {
    const std::string file = write(head + text);
    const std::string fault = fault_of([&] { read_device_profile(file); });
    EXPECT_NE(fault.find(expected), std::string::npos) << fault;
    EXPECT_EQ(fault.find(file), 0u) << fault;
  }
}

TEST_F(Profiles, DocumentsEveryKeyAndNoOther) {
  for (const auto& [readme, toml] :
       {std::pair{"devices/README.md", "devices/simulated.toml"}, {"devices/README.md", "devices/virtuose_6d.toml"}}) {
    std::ifstream in(std::string(PALP_SOURCE_DIR "/config/") + readme),
        example(std::string(PALP_SOURCE_DIR "/config/") + toml);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    std::string section;
    for (std::string line; std::getline(example, line);) {
      if (line.starts_with('[')) section = line.substr(1, line.find(']') - 1) + ".";
      const auto equals = line.find(" = ");
      if (line.starts_with('#') || equals == std::string::npos) continue;
      EXPECT_NE(text.find("`" + section + line.substr(0, equals) + "`"), std::string::npos) << section << line;
    }
  }
}

TEST_F(Profiles, RefusesWhatIsWrongAllAtOnceWithFileAndLine) {
  const std::string file = write(
      "name = \"x\"\n[limits]\nforce = 0\ntorque = \"much\"\n[arm]\nmass = -1\nmas = 2\n[coupling]\nstiffness = nan\n");
  const std::string fault = fault_of([&] { read_device_profile(file); });
  for (const char* line : {":3: ", ":4: ", ":6: ", ":7: ", ":9: "})
    EXPECT_NE(fault.find(file + line), std::string::npos) << fault;
}

TEST_F(Profiles, RefusesWhatIsNoHandScript) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"grip = \"firm\"\n", "keyframe"},
      {"grip = \"strong\"\n[[keyframe]]\ntime = 0\n", ":1: "},
      {"[[keyframe]]\nposition = [0, 0, 0]\n", "time is missing"},
      {"[[keyframe]]\ntime = 1\n[[keyframe]]\ntime = 1\n", ":4: "},
      {"[[keyframe]]\ntime = 0\nrotation_deg = [0, 0]\n", ":3: "},
      {"[[keyframe]]\ntime = 0\nrotation_deg = [170, 170, 0]\n", ":3: "},
      {"[[keyframe]]\ntime = 0\n[[keyframe]]\ntime = 1\nrotation_deg = [150, 0, 0]\n", ":5: "},
      {"loop = true\n[[keyframe]]\ntime = 0\n[[keyframe]]\ntime = 1\nposition = [1, 0, 0]\n", "must end in the pose"},
      {"[grip]\nmass = -1\n[[keyframe]]\ntime = 0\n", ":2: "},
      {"[tremor]\nforce = 50\n[[keyframe]]\ntime = 0\n", ":2: "},
  };
  for (const auto& [text, expected] : cases) {
    const std::string file = write(text);
    const std::string fault = fault_of([&] { read_hand_script(file); });
    EXPECT_NE(fault.find(expected), std::string::npos) << fault << "\nof\n" << text;
  }
}

}  // namespace
}  // namespace palp
