// The driver of the Virtuose, call by call, before the simulated arm.
#include <cmath>
#include <limits>

#include "config/error.h"
#include "haptic_bridge/profile.h"
#include "tests/bridge/count_allocations.h"
#include "tests/bridge/virtuose_bench.h"
#include "tests/support/random.h"

namespace palp::test {
namespace {

using Vec3 = Eigen::Vector3d;
using Quat = Eigen::Quaterniond;

constexpr double kInFloat = 1e-6;  // of metres and radians below one, as float keeps them

Quat turn(double angle, const Vec3& axis) { return Quat(Eigen::AngleAxisd(angle, axis.normalized())); }

// ---- frames

const HandleState<double> kOrigin = at_rest(Vec3::Zero(), Quat::Identity());
const float kHalf = static_cast<float>(std::sqrt(0.5));

TEST(ArmFrame, TheOperatorsAxesBecomeTheWorlds) {
  ArmFrame frame(default_arm_axes(), kOrigin);
  // 3 cm towards the operator, 2 cm to the right, 1 cm up, a quarter turn about the arm's X
  const HandleState<double> h = frame.to_world({0.03F, 0.02F, 0.01F, kHalf, 0, 0, kHalf}, {3, 2, 1, 0.3F, 0.2F, 0.1F});
  EXPECT_LT((h.x - Vec3(0.02, -0.03, 0.01)).norm(), kInFloat);
  EXPECT_LT((h.v - Vec3(2, -3, 1)).norm(), kInFloat);
  EXPECT_LT((h.w - Vec3(0.2, -0.3, 0.1)).norm(), kInFloat);
  EXPECT_LT((rotation_between(Quat::Identity(), h.q) - Vec3(0, -M_PI / 2, 0)).norm(), kInFloat);
}

TEST(ArmFrame, AWrenchOfTheWorldBecomesTheOperators) {
  const ArmFrame frame(default_arm_axes(), kOrigin);
  const ArmVector w = frame.to_arm(Vec3(1, 2, 3), Vec3(0.1, 0.2, 0.3));
  const ArmVector expected{-2, 1, 3, -0.2F, 0.1F, 0.3F};
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(w[i], expected[i], kInFloat) << i;
}

TEST(ArmFrame, TheToolBeginsAtTheStartWhereverTheHandleIs) {
  const HandleState<double> start = at_rest({1, 2, 3}, turn(0.7, {1, 0, 2}));
  ArmFrame frame(default_arm_axes(), start);
  const ArmPose here{0.4F, -0.1F, 0.2F, 0, kHalf, 0, kHalf};
  frame.place(here);
  const HandleState<double> h = frame.to_world(here, {});
  EXPECT_LT((h.x - start.x).norm(), kInFloat);
  EXPECT_LT(rotation_between(start.q, h.q).norm(), kInFloat);
  // turned by a quarter about the world's z from there, whatever the handle's own orientation
  const Quat before = ArmFrame::orientation(here), after = turn(M_PI / 2, {0, 0, 1}) * before;
  const HandleState<double> turned =
      frame.to_world({0.4F, -0.1F, 0.2F, static_cast<float>(after.x()), static_cast<float>(after.y()),
                      static_cast<float>(after.z()), static_cast<float>(after.w())},
                     {});
  EXPECT_LT((rotation_between(start.q, turned.q) - Vec3(0, 0, M_PI / 2)).norm(), kInFloat);
}

class AnyFrame : public testing::RandomCase {};

TEST_F(AnyFrame, BackAndForthIsTheSamePoseAndPowerIsTheSameInBothFrames) {
  for (int i = 0; i < 200; ++i) {
    const Quat axes = testing::random_rotation(random_);
    ArmFrame frame(axes.toRotationMatrix(), at_rest(vector(1), testing::random_rotation(random_)));
    const auto pose = [&] {
      const Vec3 x = vector(0.5);
      const Quat q = testing::random_rotation(random_);
      return ArmPose{static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z()),
                     static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
                     static_cast<float>(q.w())};
    };
    frame.place(pose());
    const ArmPose there = pose();
    ArmVector speed;
    for (float& s : speed) s = static_cast<float>(between(-1, 1));
    const HandleState<double> h = frame.to_world(there, speed);
    const ArmPose back = frame.to_arm(h.x, h.q);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(back[k], there[k], kInFloat);
    EXPECT_LT(rotation_between(ArmFrame::orientation(there), ArmFrame::orientation(back)).norm(), 1e-5);
    const Wrench<double> w{vector(10), vector(1)};
    const ArmVector f = frame.to_arm(w.force, w.torque);
    double power = 0;
    for (int k = 0; k < 6; ++k) power += static_cast<double>(f[k]) * static_cast<double>(speed[k]);
    EXPECT_NEAR(power, w.force.dot(h.v) + w.torque.dot(h.w), 1e-5);
  }
}

// ---- the library

class Virtuose : public VirtuoseBench {
 protected:
  template <class Error>
  std::string refusal(const VirtuoseSetup& s) {
    try {
      open(s);
    } catch (const Error& error) {
      return error.what();
    } catch (const std::exception& error) {
      return std::string("another kind of error: ") + error.what();
    }
    return "no error";
  }
  static void expect_sentence(const std::string& text, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }
};

TEST_F(Virtuose, AMissingFileIsSaidToBeMissing) {
  VirtuoseSetup s = setup();
  s.library = (folder_ / "none.so").string();
  expect_sentence(refusal<ConfigError>(s), {"none.so", "no such file", "--library"});
  s.library = "libpalp_there_is_no_such_library.so";
  expect_sentence(refusal<ConfigError>(s), {"libpalp_there_is_no_such_library.so", "cannot be loaded", "--library"});
}

TEST_F(Virtuose, AFileThatIsNoLibraryIsRefused) {
  VirtuoseSetup s = setup();
  s.library = (folder_ / "text.so").string();
  std::ofstream(s.library) << std::string(5000, 'x');
  expect_sentence(refusal<ConfigError>(s), {"text.so", "cannot be loaded", "--library"});
}

TEST_F(Virtuose, ALibraryThatLacksAFunctionIsRefusedByItsName) {
  VirtuoseSetup s = setup();
  s.library = PALP_LIB_DIR "/libincomplete_virtuose.so";
  expect_sentence(refusal<ConfigError>(s), {"libincomplete_virtuose.so", "no function virt", "--library"});
}

TEST_F(Virtuose, AnotherVersionIsRefused) {
  const std::string file = (folder_ / "old.toml").string();
  std::ofstream(file) << "major_version = 3\nminor_version = 98\n";
  setenv("PALP_FAKE_VIRTUOSE", file.c_str(), 1);
  expect_sentence(refusal<ConfigError>(setup()), {"version 3.98", "expected version 4", "--library"});
}

TEST_F(Virtuose, TheFakeExportsTheCInterfaceOnly) {
  const VirtuoseApi api(kFakeLibrary);
  EXPECT_EQ(api.version(), "4.4");
  const ArmPose before = kArmOrigin;
  ArmPose pose = before;
  EXPECT_NE(api.get_avatar.function(nullptr, pose.data()), 0);
  EXPECT_EQ(api.error_code(nullptr), kVirtInvalidContext);
  EXPECT_EQ(pose, before);
}

TEST_F(Virtuose, AProfileOfAnotherArmIsRefused) {
  VirtuoseSetup s = setup("device_type = 4\n");
  s.device_type = 3;
  expect_sentence(refusal<ConfigError>(s), {"6D Desktop (type 4)", "Virtuose 6D (type 3)", "--profile"});
  EXPECT_EQ(names(calls()).back(), "virtClose");
}

// ---- opening and closing

const std::vector<std::string> kOpening{"virtGetControlerVersion",
                                        "virtGetDeviceID",
                                        "virtSetTimeoutValue",
                                        "virtSetIndexingMode",
                                        "virtSetForceFactor",
                                        "virtSetSpeedFactor",
                                        "virtSetTimeStep",
                                        "virtSetBaseFrame",
                                        "virtSetObservationFrame",
                                        "virtSetObservationFrameSpeed",
                                        "virtSetCommandType",
                                        "virtSaturateTorque",
                                        "virtEnableForceFeedback",
                                        "virtSetPowerOn",
                                        "virtSetForce"};

TEST_F(Virtuose, OpensAndClosesInTheOrderOfTheManual) {
  open();
  const std::vector<LoggedCall> all = calls();
  std::vector<std::string> expected = kOpening;
  expected.insert(expected.end(), 3, "virtGetButton");
  expected.insert(expected.end(), {"virtSetForce", "virtSetPowerOn", "virtClose"});
  EXPECT_EQ(names(all), expected);
  for (const LoggedCall& c : all) EXPECT_EQ(c.code, 0) << c.name;
  EXPECT_EQ(all[4].arguments, " 1.000000 = 0");             // force factor
  EXPECT_EQ(all[5].arguments, " 1.000000 = 0");             // speed factor
  EXPECT_EQ(all[6].arguments, " 0.001000 = 0");             // time step
  EXPECT_EQ(all[10].arguments, " 3 = 0");                   // impedance
  EXPECT_EQ(all[11].arguments, " 10.000000 1.000000 = 0");  // the limits
  EXPECT_EQ(all[all.size() - 2].arguments, " 0 = 0");       // power off
}

TEST_F(Virtuose, MechanismModeAttachesWithItsGainsRotationFirst) {
  VirtuoseSetup s = setup();
  s.mode = VirtuoseMode::mechanism;
  s.gains = {800, 10, 8, 0.1};
  open(s);
  const std::vector<LoggedCall> all = calls();
  const std::vector<std::string> found = names(all);
  std::vector<std::string> expected(kOpening.begin(), kOpening.end() - 2);
  expected.insert(expected.end(), {"virtGetAvatarPosition", "virtSetPosition", "virtSetSpeed", "virtAttachQSVO",
                                   "virtSetPowerOn", "virtGetButton", "virtGetButton", "virtGetButton",
                                   "virtEnableForceFeedback", "virtSetPowerOn", "virtDetachVO", "virtClose"});
  EXPECT_EQ(found, expected);
  EXPECT_EQ(all[10].arguments, " 5 = 0");
  EXPECT_EQ(all[12].arguments, " 0 = 0");  // the loop switches the coupling on
  const auto attach = std::find(found.begin(), found.end(), "virtAttachQSVO") - found.begin();
  EXPECT_EQ(all[static_cast<std::size_t>(attach)].arguments.substr(0, 60),
            " 8.000000 8.000000 8.000000 800.000000 800.000000 800.000000");
}

TEST_F(Virtuose, MechanismModeWithoutASpringIsRefused) {
  VirtuoseSetup s = setup();
  s.mode = VirtuoseMode::mechanism;
  s.gains.stiffness = 0;
  expect_sentence(refusal<ConfigError>(s), {"coupling.stiffness", "virtmech"});
}

TEST_F(Virtuose, EveryErrorOfEveryOpeningCallIsToldAndLeavesTheArmOff) {
  for (const std::string& call : kOpening) {
    for (const int code : {1, 2, 3, 6, 7, 8, 9, 11, 12, 14, 17, 19, 20, 22, 99}) {
      SCOPED_TRACE(call + " " + std::to_string(code));
      const std::string text = refusal<std::runtime_error>(
          setup(event("error", 0, 0, "call = \"" + call + "\"\nvalue = " + std::to_string(code))));
      expect_sentence(text, {call + " failed", "(error " + std::to_string(code) + ")"});
      const std::vector<LoggedCall> all = calls();
      ASSERT_GE(all.size(), 3u);
      EXPECT_EQ(all.back().name, "virtClose");
      EXPECT_EQ(all[all.size() - 2].name + all[all.size() - 2].arguments.substr(0, 2), "virtSetPowerOn 0");
    }
  }
}

TEST_F(Virtuose, AnArmThatIsNotThereIsToldWithTheLibrarysWords) {
  expect_sentence(refusal<std::runtime_error>(setup(event("error", 0, 0, "call = \"virtOpen\"\nvalue = 2"))),
                  {"no connection", "the controller does not answer (error 2)", "--address"});
}

// ---- ticks

TEST_F(Virtuose, ATickMakesFewCalls) {
  open();
  ticks(7);
  const std::vector<std::string> all = names(calls());
  const std::vector<std::string> in_turn{"virtGetEmergencyStop", "virtIsInBounds", "virtGetAlarm", "virtGetFailure",
                                         "virtGetButton",        "virtGetButton",  "virtGetButton"};
  std::vector<std::string> expected;
  for (const std::string& slow : in_turn)
    for (const char* name : {"virtGetAvatarPosition", "virtGetSpeed", "virtGetDeadMan", "virtGetPowerOn",
                             "virtIsInShiftPosition", slow.c_str(), "virtSetForce"})
      expected.emplace_back(name);
  const std::vector<std::string> found(all.begin() + 18, all.begin() + 18 + static_cast<long>(expected.size()));
  EXPECT_EQ(found, expected);
}

TEST_F(Virtuose, ATickAllocatesNothing) {
  for (const VirtuoseMode mode : {VirtuoseMode::impedance, VirtuoseMode::mechanism}) {
    VirtuoseSetup s = setup();
    s.library = PALP_LIB_DIR "/libquiet_virtuose.so";
    s.mode = mode;
    open(s);
    DeviceReading reading;
    int good = 0;
    start_counting_allocations();
    for (int i = 0; i < 100; ++i) {
      now_ += kTickNs;
      device_->show(i < 50 ? LoopState::idle : LoopState::engaged);
      good += device_->read(now_, reading) && device_->write({{1, 2, 3}, {0.1, 0.2, 0.3}});
    }
    EXPECT_EQ(stop_counting_allocations(), 0u);
    EXPECT_EQ(good, 100);
    EXPECT_TRUE(reading.dead_man && reading.powered);
  }
}

TEST_F(Virtuose, FollowsTheHandAlongTheWorldsAxes) {
  std::ofstream(folder_ / "hand.toml") << "grip = \"firm\"\n[[keyframe]]\ntime = 0\n[[keyframe]]\ntime = 1\n"
                                          "position = [0.1, 0.02, 0.05]\nrotation_deg = [0, 0, 40]\n";
  open("grip_at = 0\nhand = \"hand.toml\"\n");
  DeviceReading before = ticks(1), reading;
  EXPECT_LT((before.state.x - kStart.x).norm(), kInFloat);
  Vec3 way = Vec3::Zero();
  for (int i = 0; i < 3000; ++i) {
    ASSERT_TRUE(tick(reading));
    way += 1e-3 * reading.state.v;
  }
  EXPECT_LT((reading.state.x - kStart.x - Vec3(0.1, 0.02, 0.05)).norm(), 1e-3);  // the arm's friction
  EXPECT_LT((rotation_between(kStart.q, reading.state.q) - Vec3(0, 0, 40 * M_PI / 180)).norm(), 0.02);
  EXPECT_LT((way - Vec3(0.1, 0.02, 0.05)).norm(), 2e-3);  // the speed is the pose's
}

TEST_F(Virtuose, AForceOfTheWorldMovesTheHandleThatWay) {
  for (int axis = 0; axis < 3; ++axis) {
    open("grip_at = 0\nrelay_delay = 0\n");
    ticks(100);
    Wrench<double> push = zero_wrench();
    push.force[axis] = 5;
    const DeviceReading moved = ticks(2000, push);
    const Vec3 expected = 5.0 / 500 * Vec3::Unit(axis);  // the hand's spring
    EXPECT_LT((moved.state.x - kStart.x - expected).norm(), 0.03 * expected.norm());

    open("grip_at = 0\nrelay_delay = 0\n");
    ticks(100);
    push = zero_wrench();
    push.torque[axis] = 0.5;
    const Vec3 turned = rotation_between(kStart.q, ticks(2000, push).state.q);
    EXPECT_LT((turned - 0.5 / (500 * 0.01) * Vec3::Unit(axis)).norm(), 0.005);
  }
}

TEST_F(Virtuose, PowerCountsOnceTheRelaysHaveHadTheirTime) {
  VirtuoseSetup s = setup("grip_at = 0\n");
  s.relay_time = 3;
  open(s);
  EXPECT_FALSE(ticks(3000).powered);
  EXPECT_TRUE(ticks(2).powered);
}

TEST_F(Virtuose, SwitchesAreSeenInTheirTick) {
  open("grip_at = 0\nrelay_delay = 0\n" + event("dead_man_up", 0.2995, 0.1) + event("shift", 0.4995, 0.1) +
       event("emergency_stop", 0.6995, 0.1));
  EXPECT_TRUE(ticks(299).engaged());
  EXPECT_FALSE(ticks(1).dead_man);
  EXPECT_TRUE(ticks(199).engaged());
  DeviceReading r = ticks(1);
  EXPECT_TRUE(r.shifted);
  EXPECT_FALSE(r.engaged());
  EXPECT_TRUE(ticks(199).engaged());
  EXPECT_FALSE(ticks(1).powered);
  EXPECT_FALSE(ticks(7).chain_closed);
  r = ticks(200);
  EXPECT_TRUE(r.chain_closed);
  EXPECT_FALSE(r.powered);  // not by itself
}

TEST_F(Virtuose, AfterAnEmergencyStopPowerComesBackWhenTheHandLetsGo) {
  open("grip_at = 0\nrelay_delay = 0\n" + event("emergency_stop", 0.2, 0.1) + event("dead_man_up", 0.4, 0.1));
  EXPECT_FALSE(ticks(399).powered);
  EXPECT_FALSE(ticks(50).powered);
  EXPECT_TRUE(ticks(10).powered);  // the relays have had their 50 ms
  EXPECT_TRUE(ticks(50).engaged());
}

TEST_F(Virtuose, ShiftingMovesTheArmAndNotTheTool) {
  std::ofstream(folder_ / "hand.toml") << "grip = \"firm\"\n[[keyframe]]\ntime = 0\n[[keyframe]]\ntime = 1\n"
                                          "position = [0.1, 0, 0]\n";
  open("grip_at = 0\nhand = \"hand.toml\"\n" + event("shift", 0.1, 2));
  const DeviceReading before = ticks(110);
  DeviceReading r;
  for (int i = 0; i < 1980; ++i) {
    ASSERT_TRUE(tick(r));
    ASSERT_LT((r.state.x - before.state.x).norm(), 1e-6);
    ASSERT_EQ(r.state.v.norm(), 0);
  }
  EXPECT_LT((ticks(500).state.x - before.state.x).norm(), 2e-3);
}

TEST_F(Virtuose, BoundsAndHeatStrainTheArm) {
  open("grip_at = 0\n" + event("bound", 0.1, 0.1, "value = 4") + event("alarm", 0.3, 0.1, "value = 16384") +
       event("alarm", 0.5, 0.1, "value = 1048576"));
  EXPECT_FALSE(ticks(99).strained);
  DeviceReading r = ticks(50);
  EXPECT_TRUE(r.strained);
  EXPECT_EQ(r.alarms, 4u);
  EXPECT_FALSE(ticks(100).strained);
  r = ticks(100);
  EXPECT_TRUE(r.strained);
  EXPECT_EQ(r.alarms, 0x4000u);
  r = ticks(200);
  EXPECT_FALSE(r.strained);
  EXPECT_EQ(r.alarms, 0x100000u);  // an empty battery is for the log
}

TEST_F(Virtuose, MotorsThatRunHotForceAreReducedAndTold) {
  open("grip_at = 0\nrelay_delay = 0\ncontinuous_force = 3\n");
  ticks(100);
  EXPECT_FALSE(ticks(500, {{8, 0, 0}, {0, 0, 0}}).strained);
  EXPECT_TRUE(ticks(3000, {{8, 0, 0}, {0, 0, 0}}).strained);
  EXPECT_NEAR(trace().back()[7], 4, 1e-5);
}

TEST_F(Virtuose, ButtonsAreRead) {
  open("grip_at = 0\n" + event("button", 0.1, 0.1, "value = 1"));
  EXPECT_EQ(ticks(99).buttons, 0u);
  EXPECT_EQ(ticks(50).buttons, 2u);
  EXPECT_EQ(ticks(100).buttons, 0u);
}

// ---- what goes wrong in a tick

const std::vector<std::string> kInATick{"virtGetAvatarPosition", "virtGetSpeed",          "virtGetDeadMan",
                                        "virtGetPowerOn",        "virtIsInShiftPosition", "virtGetEmergencyStop",
                                        "virtIsInBounds",        "virtGetAlarm",          "virtGetFailure",
                                        "virtGetButton",         "virtSetForce"};

TEST_F(Virtuose, EveryErrorOfTheLinkIsWaitedOut) {
  for (const std::string& call : kInATick) {
    for (const int code : {2, 6, 8}) {
      SCOPED_TRACE(call + " " + std::to_string(code));
      open("grip_at = 0\nrelay_delay = 0\n" +
           event("error", 0.1995, 0.007, "call = \"" + call + "\"\nvalue = " + std::to_string(code)));
      ticks(199);
      DeviceReading reading;
      int bad = 0;
      for (int i = 0; i < 7; ++i) {
        now_ += kTickNs;
        const bool read = device_->read(now_, reading), written = device_->write({{1, 0, 0}, {0, 0, 0}});
        bad += !read || !written;
      }
      EXPECT_GT(bad, 0);
      expect_sentence(device_->trouble(), {call + " failed", "(error " + std::to_string(code) + ")"});
      EXPECT_TRUE(ticks(100).engaged());
    }
  }
}

TEST_F(Virtuose, EveryOtherErrorTakesForceAndPowerOffForGood) {
  for (const std::string& call : kInATick) {
    for (const int code : {1, 3, 7, 9, 11, 12, 14, 17, 19, 20, 22, 99}) {
      SCOPED_TRACE(call + " " + std::to_string(code));
      open("grip_at = 0\nrelay_delay = 0\n" +
           event("error", 0.1995, 0.007, "call = \"" + call + "\"\nvalue = " + std::to_string(code)));
      ticks(199, {{1, 0, 0}, {0, 0, 0}});
      DeviceReading reading;
      for (int i = 0; i < 50; ++i) {
        const bool good = tick(reading, {{1, 0, 0}, {0, 0, 0}});
        if (i >= 8) {
          EXPECT_FALSE(good);
        }
      }
      expect_sentence(device_->trouble(), {call + " failed", "(error " + std::to_string(code) + ")"});
      const std::vector<LoggedCall> all = calls();
      const auto failed = std::find_if(all.begin(), all.end(), [](const LoggedCall& c) { return c.code != 0; });
      ASSERT_NE(failed, all.end());
      // the next calls are no force and no power; then nothing until the arm is closed
      EXPECT_EQ(std::vector<std::string>({(failed + 1)->name, (failed + 2)->name}),
                std::vector<std::string>({"virtSetForce", "virtSetPowerOn"}));
      EXPECT_EQ(failed + 6, all.end()) << (failed + 3)->name;
      EXPECT_EQ(all.back().name, "virtClose");
    }
  }
}

TEST_F(Virtuose, FailedMotorsAndAWrongPositionEndTheUseOfTheArm) {
  for (const auto& [name, value, text] : {std::tuple{"failure", 5, "motors; failure 0x5"},
                                          std::tuple{"alarm", 0x40000, "position, calibrate it anew; alarm 0x40000"}}) {
    SCOPED_TRACE(name);
    open("grip_at = 0\n" + event(name, 0.1, 0.02, "value = " + std::to_string(value)));
    DeviceReading reading;
    for (int i = 0; i < 200; ++i) tick(reading);
    EXPECT_FALSE(tick(reading));
    expect_sentence(device_->trouble(), {text});
    EXPECT_EQ(names(calls()).back(), "virtClose");
  }
}

TEST_F(Virtuose, MalformedPosesAreNoReadings) {
  for (const char* name : {"nan_position", "bad_quaternion"}) {
    SCOPED_TRACE(name);
    open("grip_at = 0\n" + event(name, 0.0995, 0.005));
    ticks(99);
    DeviceReading reading;
    for (int i = 0; i < 5; ++i) EXPECT_FALSE(tick(reading));
    expect_sentence(device_->trouble(), {"no number"});
    ticks(100);
  }
}

TEST_F(Virtuose, AStateThatIsNoLongerUpdatedIsNoticedInMotion) {
  std::ofstream(folder_ / "hand.toml") << "grip = \"firm\"\n[[keyframe]]\ntime = 0\n[[keyframe]]\ntime = 1\n"
                                          "position = [0.1, 0, 0]\n";
  open("grip_at = 0\nhand = \"hand.toml\"\n" + event("freeze", 0.5, 0));
  ticks(500);
  DeviceReading reading;
  int good = 0;
  while (good < 200 && tick(reading)) ++good;
  EXPECT_LE(good, 52);
  expect_sentence(device_->trouble(), {"stands still"});
}

TEST_F(Virtuose, AControllerThatGotNothingForTwoSecondsHasDroppedTheConnection) {
  open("grip_at = 0\n" + event("slow", 0.0995, 0.0001, "call = \"virtGetSpeed\"\nvalue = 0.02"));
  DeviceReading reading;
  ticks(200);
  now_ += 2'100 * kTickNs;
  for (int i = 0; i < 2100; ++i) device_->read(now_, reading);  // reads alone are no sign of life
  EXPECT_FALSE(tick(reading));
  expect_sentence(device_->trouble(), {"the controller does not answer (error 2)"});
}

TEST_F(Virtuose, ACallPastTheTimeOutIsATimeOut) {
  open("grip_at = 0\n" + event("slow", 0.0995, 0.001, "call = \"virtGetSpeed\"\nvalue = 0.5"));
  ticks(99);
  DeviceReading reading;
  EXPECT_FALSE(tick(reading));
  expect_sentence(device_->trouble(), {"virtGetSpeed failed", "(error 6)"});
  ticks(100);
}

TEST_F(Virtuose, WrenchesThatAreNoNumbersAreNotSent) {
  open("grip_at = 0\n");
  ticks(10);
  EXPECT_FALSE(device_->write({{std::nan(""), 0, 0}, {0, 0, 0}}));
  EXPECT_FALSE(device_->write({{0, 0, 0}, {0, std::numeric_limits<double>::infinity(), 0}}));
  for (const LoggedCall& c : calls()) EXPECT_EQ(c.code, 0);
}

// ---- mechanism mode

TEST_F(Virtuose, InMechanismModeTheControllerRendersTheWantedWrench) {
  VirtuoseSetup s = setup("grip_at = 0\nrelay_delay = 0\n");
  s.mode = VirtuoseMode::mechanism;
  open(s);
  device_->show(LoopState::engaged);
  ticks(100);
  const Wrench<double> wanted{{3, -1, 2}, {0.1, 0.2, -0.3}};
  ticks(3000, wanted);
  const std::vector<double> last = trace().back();
  const ArmVector expected = ArmFrame(default_arm_axes(), kStart).to_arm(wanted.force, wanted.torque);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(last[static_cast<std::size_t>(6 + i)], expected[i], 0.01) << i;
}

TEST_F(Virtuose, InMechanismModeTheCouplingIsOffUnlessTheLoopIsEngaged) {
  VirtuoseSetup s = setup("grip_at = 0\nrelay_delay = 0\n");
  s.mode = VirtuoseMode::mechanism;
  open(s);
  device_->show(LoopState::idle);
  ticks(500, {{3, 0, 0}, {0, 0, 0}});
  for (const std::vector<double>& row : trace())
    for (std::size_t i = 6; i < 12; ++i) ASSERT_EQ(row[i], 0) << row[0];
}

}  // namespace
}  // namespace palp::test
