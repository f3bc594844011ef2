#include "tests/support/backend.h"

namespace palp::test {
namespace {

class NeedsDevice : public ::testing::Environment {
 public:
  void SetUp() override {
    if (tested_backend() != Backend::cuda) return;
    if (const std::string why = cuda_unavailable(); !why.empty()) GTEST_SKIP() << why;
  }
};

const ::testing::Environment* const kRegistered = ::testing::AddGlobalTestEnvironment(new NeedsDevice);

}  // namespace

Backend tested_backend() {
#ifdef PALP_TEST_CUDA
  return Backend::cuda;
#else
  return Backend::cpu;
#endif
}

}  // namespace palp::test
