// Mirror images in the walls of trays, and in other solids.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/viewer/synthetic_scene.h"
#include "viewer/mesh.h"
#include "viewer/mirror_images.h"
#include "viewer/surface_loader.h"

namespace palp::test::mirror_images_test {
namespace {

constexpr double kThick = 3 * kSpacing;
constexpr auto kHalf = static_cast<float>(0.5 * kSpacing);

std::vector<osg::Vec3f> images_in(const BodyDescription& body, const osg::Vec3f& x) {
  const LoadedSurface loaded = load_surface(body, kSpacing);
  std::vector<osg::Vec3f> images;
  if (loaded.mesh.images->box().contains(x)) loaded.mesh.images->add_of(x, images);
  return images;
}

bool among(const std::vector<osg::Vec3f>& images, const osg::Vec3f& image) {
  for (const osg::Vec3f& i : images)
    if ((i - image).length() < 1e-6f) return true;
  return false;
}

TEST(MirrorImages, AWallHasOneAnEdgeThreeACornerSeven) {
  const BodyDescription body = tray(kThick);
  const auto x = static_cast<float>(-kHalfX) + kHalf, y = static_cast<float>(kHalfY) - kHalf;
  const std::vector<osg::Vec3f> on_floor = images_in(body, {0.01f, 0.02f, kHalf});
  EXPECT_EQ(on_floor.size(), 1u);
  EXPECT_TRUE(among(on_floor, {0.01f, 0.02f, -kHalf}));

  const std::vector<osg::Vec3f> at_edge = images_in(body, {x, 0.02f, kHalf});
  EXPECT_EQ(at_edge.size(), 3u);
  for (const osg::Vec3f image : {osg::Vec3f(x - 2 * kHalf, 0.02f, kHalf), osg::Vec3f(x, 0.02f, -kHalf),
                                 osg::Vec3f(x - 2 * kHalf, 0.02f, -kHalf)})
    EXPECT_TRUE(among(at_edge, image)) << image.x() << " " << image.y() << " " << image.z();

  const std::vector<osg::Vec3f> in_corner = images_in(body, {x, y, kHalf});
  EXPECT_EQ(in_corner.size(), MirrorImages::kMost);
  EXPECT_TRUE(among(in_corner, {x - 2 * kHalf, y + 2 * kHalf, -kHalf}));
}

TEST(MirrorImages, WhatDoesNotTouchHasNone) {
  const BodyDescription body = tray(kThick);
  EXPECT_TRUE(images_in(body, {0, 0, 3 * kHalf}).empty()) << "the second layer";
  EXPECT_TRUE(images_in(body, {0, 0, -kHalf}).empty()) << "within the floor";
  EXPECT_TRUE(images_in(body, {static_cast<float>(-kHalfX) + kHalf, 0, static_cast<float>(kRim) + kHalf}).empty())
      << "above the rim";
  EXPECT_TRUE(images_in(body, {5, 5, 5}).empty());
  const float nowhere = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(images_in(body, {nowhere, 0, kHalf}).empty());
}

// The picture ends a medium at the walls of what is hollow and fixed; elsewhere images would stick out.
TEST(MirrorImages, AThinWallHoldsThemWhereItIsAVessels) {
  BodyDescription thin = tray(0.1 * kSpacing);
  EXPECT_EQ(images_in(thin, {0, 0, kHalf}).size(), 1u);
  std::vector<osg::Vec3f> images;
  EXPECT_TRUE(load_surface(thin, kSpacing).mesh.images->add_of({0, 0, kHalf}, images));
  EXPECT_FALSE(load_surface(thin, kSpacing).mesh.images->add_of({0, 0, 3 * kHalf}, images));
  const osg::Vec3f beneath(0, 0, static_cast<float>(-0.1 * kSpacing) - kHalf);
  EXPECT_TRUE(images_in(thin, beneath).empty()) << "on the outer side";
  BodyDescription carried = tray(kSpacing);
  carried.kind = BodyKind::rigid;
  EXPECT_TRUE(images_in(carried, {0, 0, kHalf}).empty());
  carried = tray(1.5 * kSpacing);
  carried.kind = BodyKind::rigid;
  EXPECT_EQ(images_in(carried, {0, 0, kHalf}).size(), 1u);
  images.clear();
  EXPECT_FALSE(load_surface(carried, kSpacing).mesh.images->add_of({0, 0, kHalf}, images));
}

TEST(MirrorImages, ARoundWallMirrorsAlongItsRadius) {
  BodyDescription body;
  body.kind = BodyKind::rigid;
  constexpr int kSides = 64;
  constexpr double kRadius = 0.05, kHeight = 0.04;
  for (int i = 0; i < kSides; ++i) {
    const double p = 2 * M_PI * i / kSides, q = 2 * M_PI * (i + 1) / kSides;
    const double cp = kRadius * std::cos(p), sp = kRadius * std::sin(p);
    const double cq = kRadius * std::cos(q), sq = kRadius * std::sin(q);
    add_quad(body, {{{cp, sp, -kHeight}, {cq, sq, -kHeight}, {cq, sq, kHeight}, {cp, sp, kHeight}}});
  }
  for (int k = 0; k < 100; ++k) {
    const double turn = 0.0611 * k;
    const osg::Vec3d out(std::cos(turn), std::sin(turn), 0);
    const std::vector<osg::Vec3f> images = images_in(body, out * (kRadius + 0.5 * kSpacing));
    ASSERT_EQ(images.size(), 1u) << turn;
    // a facet is up to R (1 - cos(pi / 64)) within the circle
    EXPECT_NEAR((osg::Vec3d(images[0]) - out * (kRadius - 0.5 * kSpacing)).length(), 0, 5e-4) << turn;
  }
}

// Each of these would have to be looked for in two million cells.
TEST(MirrorImages, VeryManyLargeFacesHaveNone) {
  BodyDescription body;
  body.kind = BodyKind::rigid;
  for (int i = 0; i < 500; ++i) {
    const double t = 0.001 * i;
    add_quad(body, {{{-1, -1, -1 - t}, {1, -1, 1 - t}, {1, 1, 1 + t}, {-1, 1, -1 + t}}});
  }
  const LoadedSurface loaded = load_surface(body, kSpacing);
  ASSERT_TRUE(loaded.mesh.images);
  EXPECT_FALSE(loaded.mesh.images->box().valid());
}

}  // namespace
}  // namespace palp::test::mirror_images_test
