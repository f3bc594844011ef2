// Tests what a slow server advises.
#include "sim_server/status_reporter.h"

#include <gtest/gtest.h>

namespace palp::test::status_reporter_test {
namespace {

TEST(AdviceForSlow, NamesTheFactorTheLevelAndANumberOfParticles) {
  const std::string text = advice_for_slow(0.09, 11e3, {20'000, Accuracy::balanced, true, 1e3});
  EXPECT_NE(text.find("at 0.09 of real time: start palp-sim-server with --accuracy fast or --particles 3000 "),
            std::string::npos)
      << text;
}

TEST(AdviceForSlow, AdvisesNothingThatIsSetAlreadyOrThatIsNoScene) {
  const std::string fast = advice_for_slow(0.5, 2e3, {20'000, Accuracy::fast, true, 1e3});
  EXPECT_EQ(fast.find("--accuracy"), std::string::npos) << fast;
  EXPECT_NE(fast.find("--particles 10000 "), std::string::npos) << fast;
  const std::string tiny = advice_for_slow(0.01, 1e5, {800, Accuracy::fast, true, 1e3});
  EXPECT_EQ(tiny.find("--particles"), std::string::npos) << tiny;
  EXPECT_NE(tiny.find("faster machine"), std::string::npos) << tiny;
}

TEST(AdviceForSlow, TellsABusyMachineFromASlowOne) {
  const std::string text = advice_for_slow(0.3, 400, {20'000, Accuracy::balanced, true, 1e3});
  EXPECT_EQ(text.find("--"), std::string::npos) << text;
  EXPECT_NE(text.find("other programs keep this machine busy"), std::string::npos) << text;
}

}  // namespace
}  // namespace palp::test::status_reporter_test
