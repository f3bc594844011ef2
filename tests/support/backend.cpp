#include "tests/support/backend.h"

#include <unistd.h>

namespace palp::test {
namespace {

class NeedsDevice : public ::testing::Environment {
 public:
  void SetUp() override {
    if (tested_backend() != Backend::cuda) return;
    if (const std::string why = cuda_unavailable(); !why.empty()) GTEST_SKIP() << why;
  }
};

// Lets the tests that start processes go first, which run beside these.
class GivesWay : public ::testing::Environment {
 public:
  void SetUp() override { EXPECT_NE(nice(19), -1); }
};

const ::testing::Environment* const kRegistered = ::testing::AddGlobalTestEnvironment(new NeedsDevice);
const ::testing::Environment* const kAlsoRegistered = ::testing::AddGlobalTestEnvironment(new GivesWay);

}  // namespace

Backend tested_backend() {
#ifdef PALP_TEST_CUDA
  return Backend::cuda;
#else
  return Backend::cpu;
#endif
}

}  // namespace palp::test
