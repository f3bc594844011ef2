// How long the OpenMP of real programs spins before it sleeps, in its own words.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <string>

namespace palp::test {
namespace {

// The last GOMP_SPINCOUNT that OpenMP tells of when a program is loaded with these settings; empty if there is none.
std::string spin_count(const std::string& settings, const std::string& program) {
  const std::string command =
      "env " + settings + " OMP_DISPLAY_ENV=verbose " PALP_BIN_DIR "/" + program + " --help 2>&1";
  std::string text;
  std::FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 4096> buffer;
  while (std::fgets(buffer.data(), buffer.size(), pipe)) text += buffer.data();
  pclose(pipe);
  const std::string key = "GOMP_SPINCOUNT = '";
  const std::size_t at = text.rfind(key);
  if (at == std::string::npos) return "";
  return text.substr(at + key.size(), text.find('\'', at + key.size()) - at - key.size());
}

TEST(ThreadWaits, AreShortInTheProgramsThatStepAScene) {
  for (const char* program : {"palp-sim-server", "palp-run", "palp-bench"}) {
    SCOPED_TRACE(program);
    EXPECT_EQ(spin_count("-u GOMP_SPINCOUNT -u OMP_WAIT_POLICY", program), "300");
    EXPECT_EQ(spin_count("-u OMP_WAIT_POLICY GOMP_SPINCOUNT=7", program), "7");
    EXPECT_NE(spin_count("-u GOMP_SPINCOUNT OMP_WAIT_POLICY=active", program), "300");
  }
}

}  // namespace
}  // namespace palp::test
