// The driver of the Virtuose before the simulated arm: the library, opening and closing, what its controller renders.
#include <dlfcn.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "config/error.h"
#include "tests/haptic_bridge/device/virtuose_bench.h"

namespace palp::test::virtuose_test {
namespace {

// ---- the library

using Virtuose = VirtuoseBench;

TEST_F(Virtuose, AMissingFileIsSaidToBeMissing) {
  VirtuoseSetup s = setup();
  s.library = folder_ / "none.so";
  expect_sentence(refusal<ConfigError>(s), {"none.so", "no such file", "--library"});
  s.library = "libpalp_there_is_no_such_library.so";
  expect_sentence(refusal<ConfigError>(s), {"libpalp_there_is_no_such_library.so", "cannot be loaded", "--library"});
}

TEST_F(Virtuose, AFileThatIsNoLibraryIsRefused) {
  VirtuoseSetup s = setup();
  s.library = folder_ / "text.so";
  std::ofstream(s.library) << std::string(5000, 'x');
  expect_sentence(refusal<ConfigError>(s), {"text.so", "cannot be loaded", "--library"});
}

TEST_F(Virtuose, ALibraryThatLacksAFunctionIsRefusedByItsName) {
  VirtuoseSetup s = setup();
  s.library = PALP_LIB_DIR "/libincomplete_virtuose.so";
  expect_sentence(refusal<ConfigError>(s), {"libincomplete_virtuose.so", "no function virt", "--library"});
}

TEST_F(Virtuose, AnotherVersionIsRefused) {
  const std::string file = folder_ / "old.toml";
  std::ofstream(file) << "major_version = 3\nminor_version = 98\n";
  setenv("PALP_FAKE_VIRTUOSE", file.c_str(), 1);
  expect_sentence(refusal<ConfigError>(setup()), {"version 3.98", "expected version 4", "--library"});
}

TEST_F(Virtuose, ACallWithoutAConnectionIsAnError) {
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

// Other clients let the library call them.
TEST_F(Virtuose, TheFakeCallsAClientsFunctionAtItsPeriod) {
  void* library = dlopen(kFakeLibrary.c_str(), RTLD_NOW);
  ASSERT_NE(library, nullptr);
  using Function = void (*)(VirtContext, void*);
  const auto set_function =
      reinterpret_cast<int (*)(VirtContext, Function, float*, void*)>(dlsym(library, "virtSetPeriodicFunction"));
  const auto start = reinterpret_cast<int (*)(VirtContext)>(dlsym(library, "virtStartLoop"));
  const auto stop = reinterpret_cast<int (*)(VirtContext)>(dlsym(library, "virtStopLoop"));
  ASSERT_TRUE(set_function && start && stop);
  {
    const VirtuoseApi api(kFakeLibrary);
    const VirtContext arm = api.open("");
    ASSERT_NE(arm, nullptr);
    EXPECT_NE(start(arm), 0);
    EXPECT_EQ(api.error_code(arm), 14);
    std::atomic<int> calls{0};
    static float period = 0.001F;
    EXPECT_EQ(set_function(
                  arm, [](VirtContext, void* n) { ++*static_cast<std::atomic<int>*>(n); }, &period, &calls),
              0);
    EXPECT_EQ(start(arm), 0);
    EXPECT_NE(start(arm), 0);
    EXPECT_EQ(api.error_code(arm), kVirtAlreadyCalled);
    while (calls < 5) std::this_thread::yield();
    EXPECT_EQ(stop(arm), 0);
    const int after = calls;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_EQ(calls, after);
    EXPECT_EQ(api.close.function(arm), 0);
  }
  dlclose(library);
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
}  // namespace palp::test::virtuose_test
