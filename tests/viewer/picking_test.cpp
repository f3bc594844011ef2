// Rays that meet spheres and triangles, a plane that cuts things away, and a camera that follows: cases with known
// answers.
#include "viewer/picking.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "viewer/follow.h"

namespace palp::test::picking_test {
namespace {

constexpr double kTiny = 1e-6;  // positions are floats
const Ray kAlongX{{-1, 0, 0}, {1, 0, 0}};

TEST(Picking, FindsTheNearestSphereWhereTheRayEntersIt) {
  const std::vector<float> p{3, 0, 0, 1, 0, 0, 2, 0, 0};
  const auto hit = pick_particle(kAlongX, p, 0, 3, 0.1, kNoClip);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->index, 1u);
  EXPECT_NEAR(hit->distance, 1.9, kTiny);
  const std::vector<float> aside{1, 0.06f, 0.08f, 2, 0.0f, 0.0f};
  EXPECT_EQ(pick_particle(kAlongX, aside, 0, 2, 0.099, kNoClip)->index, 1u);
  const auto grazed = pick_particle(kAlongX, aside, 0, 2, 0.125, kNoClip);
  EXPECT_EQ(grazed->index, 0u);
  EXPECT_NEAR(grazed->distance, 2 - 0.075, kTiny);
}

TEST(Picking, PassesOverWhatIsBehindCutAwayOrNoPlace) {
  const float nan = std::nanf(""), infinite = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(pick_particle(kAlongX, std::vector<float>{-3, 0, 0}, 0, 1, 0.1, kNoClip));
  const std::vector<float> bad{nan, 0, 0, infinite, 0, 0, 0, nan, 0, 2, 0, 0};
  EXPECT_EQ(pick_particle(kAlongX, bad, 0, 4, 0.1, kNoClip)->index, 3u);
  const std::vector<float> two{1, 0, 0, 2, 0, 0};
  EXPECT_EQ(pick_particle(kAlongX, two, 0, 2, 0.1, osg::Vec4d(1, 0, 0, -1.5))->index, 1u);
  EXPECT_EQ(pick_particle(kAlongX, two, 1, 1, 0.1, kNoClip)->index, 1u) << "of the others";
  EXPECT_FALSE(pick_particle(kAlongX, two, 2, 5, 0.1, kNoClip)) << "a body may claim more than has come";
  EXPECT_FALSE(pick_particle(kAlongX, two, 0xffffffffu, 0xffffffffu, 0.1, kNoClip));
}

TEST(Picking, MeetsTheNearestTriangleOfAPlacedSurface) {
  const std::vector<float> v{0, -1, -1, 0, 1, -1, 0, 0, 1, 0.5f, -1, -1, 0.5f, 1, -1, 0.5f, 0, 1};
  const std::vector<std::uint32_t> t{3, 4, 5, 0, 1, 2, 0, 1, 99, 0, 0, 0};
  const auto hit = pick_surface(kAlongX, v, t, osg::Matrixd::identity(), kNoClip);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->index, 1u);
  EXPECT_NEAR(hit->distance, 1, kTiny);
  // turned by half a circle about z and moved: the other triangle comes first
  const osg::Matrixd pose = osg::Matrixd::rotate(M_PI, osg::Vec3d(0, 0, 1)) * osg::Matrixd::translate(2, 0, 0);
  const auto turned = pick_surface(kAlongX, v, t, pose, kNoClip);
  EXPECT_EQ(turned->index, 0u);
  EXPECT_NEAR(turned->distance, 2.5, kTiny);
  EXPECT_EQ(pick_surface(kAlongX, v, t, pose, osg::Vec4d(1, 0, 0, -1.8))->index, 1u) << "cut away";
  EXPECT_FALSE(pick_surface({{-1, 5, 0}, {1, 0, 0}}, v, t, pose, kNoClip));
  EXPECT_FALSE(pick_surface({{3, 0, 0}, {1, 0, 0}}, v, t, pose, kNoClip)) << "behind";
}

TEST(ClipPlane, KeepsTheFarSideOfTheHomeViewOrTheOther) {
  const osg::BoundingBoxd box(-1, -2, 0, 1, 2, 4);
  ClipPlane clip;
  EXPECT_EQ(equation_of(clip, box), kNoClip);
  EXPECT_TRUE(keeps(kNoClip, {9, 9, 9}));
  clip.on = true;
  clip.share = 0.75;  // y = 1
  EXPECT_NEAR(position_of(clip, box), 1, kTiny);
  EXPECT_TRUE(keeps(equation_of(clip, box), {0, 1.1, 0}));
  EXPECT_FALSE(keeps(equation_of(clip, box), {0, 0.9, 0}));
  clip.flipped = true;
  EXPECT_TRUE(keeps(equation_of(clip, box), {0, 0.9, 0}));
  for (const int axis : {0, 2}) {
    clip = {true, axis, 0.5, false};
    osg::Vec3d low = box.center(), high = box.center();
    low[axis] -= 0.1;
    high[axis] += 0.1;
    EXPECT_TRUE(keeps(equation_of(clip, box), low)) << axis;
    EXPECT_FALSE(keeps(equation_of(clip, box), high)) << axis;
  }
  EXPECT_NEAR(share_at(3, 2, box), 0.75, kTiny);
  EXPECT_EQ(share_at(99, 2, box), 1);
  EXPECT_EQ(share_at(1, 0, osg::BoundingBoxd(1, 1, 1, 1, 1, 1)), 0.5);
}

TEST(Follow, ComesNearSmoothlyAndAlikeAtAnyRate) {
  const osg::Vec3d target(1, 0, 0);
  osg::Vec3d fast, slow;
  for (int i = 0; i < 60; ++i) fast = followed(fast, target, 1 / 60.0);
  for (int i = 0; i < 5; ++i) slow = followed(slow, target, 1 / 5.0);
  EXPECT_NEAR(fast.x(), slow.x(), 1e-9);
  EXPECT_GT(fast.x(), 0.9);
  EXPECT_LT(followed({}, target, 1 / 60.0).x(), 0.06) << "no jump";
  EXPECT_EQ(followed({1, 2, 3}, {std::nan(""), 0, 0}, 1), osg::Vec3d(1, 2, 3));
  EXPECT_EQ(followed({1, 2, 3}, target, -1), osg::Vec3d(1, 2, 3));
}

}  // namespace
}  // namespace palp::test::picking_test
