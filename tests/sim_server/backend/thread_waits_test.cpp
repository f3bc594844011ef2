// How long the OpenMP of real programs spins before it sleeps, in its own words.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/process.h"

namespace palp::test {
namespace {

// Returns the last GOMP_SPINCOUNT that OpenMP tells of when a program is loaded with these settings, as env takes them;
// empty if there is none.
std::string spin_count(std::vector<std::string> settings, const std::string& program) {
  settings.insert(settings.begin(), "env");
  settings.insert(settings.end(), {"OMP_DISPLAY_ENV=verbose", PALP_BIN_DIR "/" + program, "--help"});
  const std::string text = run_program(settings).output;
  const std::string key = "GOMP_SPINCOUNT = '";
  const std::size_t at = text.rfind(key);
  if (at == std::string::npos) return "";
  return text.substr(at + key.size(), text.find('\'', at + key.size()) - at - key.size());
}

TEST(ThreadWaits, AreShortInTheProgramsThatStepAScene) {
  for (const char* program : {"palp-sim-server", "palp-run", "palp-bench"}) {
    SCOPED_TRACE(program);
    EXPECT_EQ(spin_count({"-u", "GOMP_SPINCOUNT", "-u", "OMP_WAIT_POLICY"}, program), "300");
    EXPECT_EQ(spin_count({"-u", "OMP_WAIT_POLICY", "GOMP_SPINCOUNT=7"}, program), "7");
    EXPECT_NE(spin_count({"-u", "GOMP_SPINCOUNT", "OMP_WAIT_POLICY=active"}, program), "300");
  }
}

}  // namespace
}  // namespace palp::test
