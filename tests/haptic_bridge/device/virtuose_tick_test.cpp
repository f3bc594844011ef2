// The driver of the Virtuose before the simulated arm, tick by tick: what it reads and writes, and what goes wrong.
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "tests/haptic_bridge/device/virtuose_bench.h"
#include "tests/support/count_allocations.h"
#include "tests/support/count_locks.h"

namespace palp::test::virtuose_tick_test {
namespace {

using Vec3 = Eigen::Vector3d;

constexpr double kInFloat = 1e-6;  // of metres and radians below one, as float keeps them

using VirtuoseTick = VirtuoseBench;

TEST_F(VirtuoseTick, ATickMakesFewCalls) {
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

TEST_F(VirtuoseTick, ATickAllocatesNothingAndTakesNoLock) {
  for (const VirtuoseMode mode : {VirtuoseMode::impedance, VirtuoseMode::mechanism}) {
    VirtuoseSetup s = setup();
    s.library = PALP_LIB_DIR "/libquiet_virtuose.so";
    s.mode = mode;
    open(s);
    DeviceReading reading;
    int good = 0;
    start_counting_allocations();
    start_counting_locks();
    for (int i = 0; i < 100; ++i) {
      now_ += kTickNs;
      device_->show(i < 50 ? LoopState::idle : LoopState::engaged);
      good += device_->read(now_, reading) && device_->write({{1, 2, 3}, {0.1, 0.2, 0.3}});
    }
    EXPECT_EQ(stop_counting_locks(), 0u);
    EXPECT_EQ(stop_counting_allocations(), 0u);
    EXPECT_EQ(good, 100);
    EXPECT_TRUE(reading.dead_man && reading.powered);
  }
}

TEST_F(VirtuoseTick, FollowsTheHandAlongTheWorldsAxes) {
  std::ofstream(folder_ / "hand.toml") << "grip = \"firm\"\n[[keyframe]]\ntime = 0\n[[keyframe]]\ntime = 1\n"
                                          "position = [0.1, 0.02, 0.05]\nrotation_deg = [0, 0, 40]\n";
  open("grip_at = 0\nhand = \"hand.toml\"\n");
  DeviceReading before = ticks(1), reading;
  EXPECT_LT((before.state.position - kStart.position).norm(), kInFloat);
  Vec3 way = Vec3::Zero();
  for (int i = 0; i < 3000; ++i) {
    ASSERT_TRUE(tick(reading));
    way += 1e-3 * reading.state.linear;
  }
  EXPECT_LT((reading.state.position - kStart.position - Vec3(0.1, 0.02, 0.05)).norm(), 1e-3);  // the arm's friction
  EXPECT_LT((rotation_between(kStart.orientation, reading.state.orientation) - Vec3(0, 0, 40 * M_PI / 180)).norm(),
            0.02);
  EXPECT_LT((way - Vec3(0.1, 0.02, 0.05)).norm(), 2e-3);  // the speed is the pose's
}

TEST_F(VirtuoseTick, AForceOfTheWorldMovesTheHandleThatWay) {
  for (int axis = 0; axis < 3; ++axis) {
    open("grip_at = 0\nrelay_delay = 0\n");
    ticks(100);
    Wrench<double> push = zero_wrench();
    push.force[axis] = 5;
    const DeviceReading moved = ticks(2000, push);
    const Vec3 expected = 5.0 / 500 * Vec3::Unit(axis);  // the hand's spring
    EXPECT_LT((moved.state.position - kStart.position - expected).norm(), 0.03 * expected.norm());

    open("grip_at = 0\nrelay_delay = 0\n");
    ticks(100);
    push = zero_wrench();
    push.torque[axis] = 0.5;
    const Vec3 turned = rotation_between(kStart.orientation, ticks(2000, push).state.orientation);
    EXPECT_LT((turned - 0.5 / (500 * 0.01) * Vec3::Unit(axis)).norm(), 0.005);
  }
}

TEST_F(VirtuoseTick, PowerCountsOnceTheRelaysHaveHadTheirTime) {
  VirtuoseSetup s = setup("grip_at = 0\n");
  s.relay_time = 3;
  open(s);
  EXPECT_FALSE(ticks(3000).powered);
  EXPECT_TRUE(ticks(2).powered);
}

TEST_F(VirtuoseTick, SwitchesAreSeenInTheirTick) {
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

TEST_F(VirtuoseTick, AfterAnEmergencyStopPowerComesBackWhenTheHandLetsGo) {
  open("grip_at = 0\nrelay_delay = 0\n" + event("emergency_stop", 0.2, 0.1) + event("dead_man_up", 0.4, 0.1));
  EXPECT_FALSE(ticks(399).powered);
  EXPECT_FALSE(ticks(50).powered);
  EXPECT_TRUE(ticks(10).powered);  // the relays have had their 50 ms
  EXPECT_TRUE(ticks(50).engaged());
}

// Someone else took it off, and knows why.
TEST_F(VirtuoseTick, PowerThatWasTakenOffIsNotAskedForAgain) {
  open("grip_at = 0\nrelay_delay = 0\n" + event("power_off", 0.2, 0.2) + event("dead_man_up", 0.25, 0.05));
  EXPECT_FALSE(ticks(350).powered);
  ticks(200);
  int asked = 0;
  for (const LoggedCall& c : calls()) asked += c.name == "virtSetPowerOn" && c.arguments.substr(0, 2) == " 1";
  EXPECT_EQ(asked, 1);
}

TEST_F(VirtuoseTick, ShiftingMovesTheArmAndNotTheTool) {
  std::ofstream(folder_ / "hand.toml") << "grip = \"firm\"\n[[keyframe]]\ntime = 0\n[[keyframe]]\ntime = 1\n"
                                          "position = [0.1, 0, 0]\n";
  open("grip_at = 0\nhand = \"hand.toml\"\n" + event("shift", 0.1, 2));
  const DeviceReading before = ticks(110);
  DeviceReading r;
  for (int i = 0; i < 1980; ++i) {
    ASSERT_TRUE(tick(r));
    ASSERT_LT((r.state.position - before.state.position).norm(), 1e-6);
    ASSERT_EQ(r.state.linear.norm(), 0);
  }
  EXPECT_LT((ticks(500).state.position - before.state.position).norm(), 2e-3);
}

TEST_F(VirtuoseTick, BoundsAndHeatStrainTheArm) {
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

TEST_F(VirtuoseTick, MotorsThatRunHotForceAreReducedAndTold) {
  open("grip_at = 0\nrelay_delay = 0\ncontinuous_force = 3\n");
  ticks(100);
  EXPECT_FALSE(ticks(500, {{8, 0, 0}, {0, 0, 0}}).strained);
  EXPECT_TRUE(ticks(3000, {{8, 0, 0}, {0, 0, 0}}).strained);
  EXPECT_NEAR(trace().back()[7], 4, 1e-5);
}

TEST_F(VirtuoseTick, ButtonsAreRead) {
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

TEST_F(VirtuoseTick, EveryErrorOfTheLinkIsWaitedOut) {
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

TEST_F(VirtuoseTick, EveryOtherErrorTakesForceAndPowerOffForGood) {
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

TEST_F(VirtuoseTick, FailedMotorsAndAWrongPositionEndTheUseOfTheArm) {
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

TEST_F(VirtuoseTick, MalformedPosesAreNoReadings) {
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

TEST_F(VirtuoseTick, AStateThatIsNoLongerUpdatedIsNoticedInMotion) {
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

TEST_F(VirtuoseTick, AControllerThatGotNothingForTwoSecondsHasDroppedTheConnection) {
  open("grip_at = 0\n" + event("slow", 0.0995, 0.0001, "call = \"virtGetSpeed\"\nvalue = 0.02"));
  DeviceReading reading;
  ticks(200);
  now_ += 2'100 * kTickNs;
  for (int i = 0; i < 2100; ++i) device_->read(now_, reading);  // reads alone are no sign of life
  EXPECT_FALSE(tick(reading));
  expect_sentence(device_->trouble(), {"the controller does not answer (error 2)"});
}

TEST_F(VirtuoseTick, ACallPastTheTimeOutIsATimeOut) {
  open("grip_at = 0\n" + event("slow", 0.0995, 0.001, "call = \"virtGetSpeed\"\nvalue = 0.5"));
  ticks(99);
  DeviceReading reading;
  EXPECT_FALSE(tick(reading));
  expect_sentence(device_->trouble(), {"virtGetSpeed failed", "(error 6)"});
  ticks(100);
}

TEST_F(VirtuoseTick, WrenchesThatAreNoNumbersAreNotSent) {
  open("grip_at = 0\n");
  ticks(10);
  EXPECT_FALSE(device_->write({{std::nan(""), 0, 0}, {0, 0, 0}}));
  EXPECT_FALSE(device_->write({{0, 0, 0}, {0, std::numeric_limits<double>::infinity(), 0}}));
  for (const LoggedCall& c : calls()) EXPECT_EQ(c.code, 0);
}

}  // namespace
}  // namespace palp::test::virtuose_tick_test
