// How particles are drawn.
#include "viewer/medium.h"

#include <gtest/gtest.h>

namespace palp::test {
namespace {

TEST(Medium, FollowsFromWhatABodyIsAndLooksLike) {
  const auto medium = [](BodyKind kind, bool clear) {
    BodyDescription body;
    body.kind = kind;
    body.look.clear = clear;
    return usual_medium(body);
  };
  for (const BodyKind kind : {BodyKind::fluid, BodyKind::elastic}) {
    EXPECT_EQ(medium(kind, true), Medium::clear);
    EXPECT_EQ(medium(kind, false), Medium::opaque);
  }
  EXPECT_EQ(medium(BodyKind::rigid, false), Medium::beads);
  EXPECT_EQ(medium(BodyKind::fixed, true), Medium::beads);
}

}  // namespace
}  // namespace palp::test
