// How particles are drawn.
#include "viewer/medium.h"

#include <gtest/gtest.h>

namespace palp::test {
namespace {

TEST(Medium, FollowsFromWhatABodyIsAndIsCalled) {
  const auto medium = [](BodyKind kind, const char* name) {
    BodyDescription body;
    body.kind = kind;
    body.name = name;
    return usual_medium(body);
  };
  EXPECT_EQ(medium(BodyKind::fluid, "water"), Medium::clear);
  EXPECT_EQ(medium(BodyKind::fluid, "Pancake Batter"), Medium::opaque);
  EXPECT_EQ(medium(BodyKind::elastic, "water"), Medium::opaque);
  EXPECT_EQ(medium(BodyKind::rigid, "butter"), Medium::beads);
  EXPECT_EQ(medium(BodyKind::fixed, ""), Medium::beads);
}

}  // namespace
}  // namespace palp::test
