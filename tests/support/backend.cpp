#include "tests/support/backend.h"

namespace palp::testing {
namespace {

class NeedsDevice : public ::testing::Environment {
 public:
  void SetUp() override {
    if (kBackend != Backend::cuda) return;
    if (const std::string why = cuda_unavailable(); !why.empty()) GTEST_SKIP() << why;
  }
};

const ::testing::Environment* const kRegistered = ::testing::AddGlobalTestEnvironment(new NeedsDevice);

}  // namespace
}  // namespace palp::testing
