// The keys and the actions that they ask for.
#include "viewer/controls.h"

#include <gtest/gtest.h>

namespace palp::test {
namespace {

TEST(Keys, CapitalAndSmallLettersDiffer) {
  EXPECT_EQ(action_of('r'), Action::home);
  EXPECT_EQ(action_of('R'), Action::reset);
  EXPECT_EQ(action_of(' '), Action::pause_or_resume);
  EXPECT_FALSE(action_of('q'));
}

}  // namespace
}  // namespace palp::test
