// The bridge with the driver of the Virtuose, before the simulated arm behind the same C interface.
#include "tests/process/running_system.h"
#include "tests/support/flight_table.h"

namespace palp::test::virtuose_test {
namespace {

class VirtuoseProcess : public RunningSystem {
 protected:
  // The bridge before a simulated arm of quick relays, to which the events happen [s since it was opened].
  void start_virtuose(const std::string& events, const std::vector<std::string>& more = {}) {
    const std::string library = PALP_LIB_DIR "/libvirtuose_sim.so";
    const std::string arm = folder_ / "arm.toml", profile = folder_ / "profile.toml";
    write_text(arm, "hand = \"" + kHere + "dip.toml\"\nrelay_delay = 0.1\n" + events);
    write_text(profile,
               "name = \"test\"\n[limits]\nforce = 10\ntorque = 1\n[safety]\noverrun_ms = 0\nlate_ticks = 0\n"
               "[workspace]\nreference = \"relative\"\n[virtuose]\ndevice_type = 3\nrelay_time = 0.15\n");
    std::vector<std::string> arguments{"--device",    "virtuose",  "--library", library, "--address",
                                       arm,           "--profile", profile,     "--log", folder_ / "flight.csv",
                                       "--self-test", "0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    bridge_ = start_tool("palp-haptic-bridge", Vendor::cyclone, arguments);
  }
};

TEST_F(VirtuoseProcess, ForceIsFeltEndsWithTheDeadManAndTheRunWithTheArmsFailure) {
  Watcher& watcher = watch();
  start_server();
  start_virtuose(
      "[[event]]\nevent = \"dead_man_up\"\ntime = 4\nduration = 0.3\n"
      "[[event]]\nevent = \"error\"\ntime = 6\ncall = \"virtGetSpeed\"\nvalue = 11\n");
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  EXPECT_TRUE(watcher.sees([&] { return watcher.has_event("virtGetSpeed failed"); })) << said();
  EXPECT_EQ(bridge_->wait(), 1) << said();
  EXPECT_NE(said().find("virtGetSpeed failed: the hardware has failed (error 11)"), std::string::npos) << said();
  EXPECT_TRUE(watcher.has_event("the hand is off the dead-man switch")) << said();
  EXPECT_NE(summary("palp-haptic-bridge").find("\"healthy\": false"), std::string::npos);
  stop_server();

  const FlightTable log(folder_ / "flight.csv");
  const std::size_t ticks = log.ticks();
  ASSERT_GT(ticks, 4000u);
  const double t_first = 1e-9 * log.number("t_ns", 0);
  double before = 0, after = 0, t_released = 0;
  for (std::size_t i = 0; i < ticks; ++i) {
    const double t = 1e-9 * log.number("t_ns", i) - t_first, force = log.felt(i);
    const bool held = log.text("hand_on", i) == "1" && log.text("good_reading", i) == "1";
    if (!held) {
      ASSERT_EQ(force, 0) << "tick " << log.text("tick", i);
    }
    if (before > 0.5 && !held && t_released == 0) t_released = t;
    (t_released == 0 ? before : after) = std::max(t_released == 0 ? before : after, force);
  }
  EXPECT_NEAR(t_released, 4, 0.5) << "the arm is opened a moment before the first tick";
  EXPECT_GT(before, 0.5);
  EXPECT_GT(after, 0.5);
  EXPECT_EQ(log.text("state", ticks - 1), "fault");
  EXPECT_EQ(log.felt(ticks - 1), 0);
}

TEST_F(VirtuoseProcess, MechanismModeIsFeltToo) {
  Watcher& watcher = watch();
  start_server();
  start_virtuose("", {"--virtuose-mode", "virtmech"});
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  stop_bridge();
  stop_server();
}

TEST_F(VirtuoseProcess, TheArmIsPoweredOffWhenTheBridgeIsKilled) {
  Watcher& watcher = watch();
  start_server();
  start_virtuose("");
  ASSERT_TRUE(force_is_felt(watcher)) << said();
  bridge_->stop(SIGKILL);
  EXPECT_TRUE(watcher.sees([&] { return said().find("the arm was powered off") != std::string::npos; })) << said();
  stop_server();
}

}  // namespace
}  // namespace palp::test::virtuose_test
