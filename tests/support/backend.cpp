#include "tests/support/backend.h"

#include <unistd.h>

namespace palp::test {
namespace {

// Lets tests that start processes, which run beside these, go first. Skips all where the device is missing.
class Surroundings : public ::testing::Environment {
 public:
  void SetUp() override {
    EXPECT_NE(nice(19), -1);
    if (tested_backend() != Backend::cuda) return;
    if (const std::string why = cuda_unavailable(); !why.empty()) GTEST_SKIP() << why;
  }
};

const ::testing::Environment* const kRegistered = ::testing::AddGlobalTestEnvironment(new Surroundings);

}  // namespace

Backend tested_backend() {
#ifdef PALP_TEST_CUDA
  return Backend::cuda;
#else
  return Backend::cpu;
#endif
}

}  // namespace palp::test
