// Tests that what tools/examples shows runs: beside a real server, in C++ and, where its module is built, in Python.
// Also tests that every program says its name and version.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <sstream>

#include "config/version.h"
#include "tests/process/running_system.h"

namespace palp::test::examples_test {
namespace {

// Returns the number behind `word` in each line that has both.
std::vector<double> numbers_behind(const std::string& text, const std::string& word) {
  std::vector<double> numbers;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find(word);
    double number = 0;
    if (at != std::string::npos && std::sscanf(line.c_str() + at + word.size(), "%lf", &number) == 1)
      numbers.push_back(number);
  }
  return numbers;
}

class Examples : public RunningSystem, public testing::WithParamInterface<std::string> {
 protected:
  // Runs an example, which must succeed, and returns what it printed.
  std::string run(const std::string& name, const std::vector<std::string>& arguments) {
    std::vector<std::string> command{PALP_EXAMPLES_DIR "/" + name};
    if (GetParam() == "python")
      command = {"/usr/bin/env", "PYTHONPATH=" PALP_LIB_DIR "/python", "/usr/bin/python3",
                 PALP_SOURCE_DIR "/tools/examples/python/" + name + ".py"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    ChildProcess example(command, folder_ / (name + ".txt"));
    EXPECT_EQ(example.wait(60s), 0) << example.output();
    return example.output();
  }
};

TEST_P(Examples, ABridgeOfOnesOwnFeelsTheFluid) {
  start_server();
  const std::string said = run("own_bridge", {"2", std::to_string(domain_)});
  double largest = 0;  // upward
  std::istringstream lines(said);
  for (std::string line; std::getline(lines, line);) {
    double t = 0, x = 0, y = 0, z = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf s: force %lf %lf %lf", &t, &x, &y, &z), 4) << said;
    largest = std::max(largest, std::abs(z));
  }
  EXPECT_GT(largest, 0.01) << said;
  EXPECT_LT(largest, 100) << said;
  stop_server();
}

TEST_P(Examples, ASubscriberSeesEachParticle) {
  start_server();
  const std::string said = run("particle_subscriber", {"5", std::to_string(domain_)});
  const std::vector<double> counts = numbers_behind(said, " s:"), heights = numbers_behind(said, "mean height");
  ASSERT_EQ(counts.size(), 5u) << said;
  ASSERT_EQ(heights.size(), 5u) << said;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    EXPECT_GT(counts[i], 50) << said;
    EXPECT_NEAR(heights[i], 0.1, 0.1) << said;
  }
  stop_server();
}

TEST_P(Examples, ASimulationIsSteppedWithoutABus) {
  const std::string said = run("step_simulation", {kHere + "small_tray.toml", "0.1"});
  EXPECT_EQ(said.find("cpu ("), 0u) << said;
  const std::vector<double> forces = numbers_behind(said, "force");
  ASSERT_EQ(forces.size(), 5u) << said;
  for (const double force : forces) EXPECT_TRUE(std::isfinite(force)) << said;
}

INSTANTIATE_TEST_SUITE_P(Languages, Examples, testing::Values(PALP_EXAMPLE_LANGUAGES),
                         [](const auto& of) { return of.param; });

TEST(Programs, SayTheirNameAndVersion) {
  const ScratchFolder folder;
  for (const std::string name : {PALP_PROGRAM_NAMES}) {
    ChildProcess program({kBin + name, "--version"}, folder / "said.txt");
    EXPECT_EQ(program.wait(), 0) << name;
    EXPECT_EQ(program.output(), version_of(name) + "\n");
  }
}

}  // namespace
}  // namespace palp::test::examples_test
