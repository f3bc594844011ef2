// Which particles fly alone, and how white they get.
#include "viewer/spray.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace palp::test::spray_test {
namespace {

constexpr double kDx = 0.01;  // [m]

// Returns how much of each of these places is a drop; places are in spacings.
std::vector<float> drops(std::vector<osg::Vec4f> places, std::span<const std::span<const float>> others = {}) {
  for (osg::Vec4f& p : places) p *= static_cast<float>(kDx);
  Interior interior;
  interior.find(places, kDx, true);
  std::vector<float> alone(places.size());
  for (const Flying& drop : find_flying(places, interior, kDx, others)) {
    EXPECT_GE(drop.airy, drop.alone);
    EXPECT_GT(drop.airy, 0);
    alone[drop.place] = drop.alone;
  }
  return alone;
}

std::vector<osg::Vec4f> lattice(int nx, int ny, int nz, double displaced = 0) {
  std::vector<osg::Vec4f> places;
  for (int i = 0; i < nx * ny * nz; ++i) {
    const int at[3] = {i % nx, i / nx % ny, i / (nx * ny)};
    osg::Vec4f p;
    for (int a = 0; a < 3; ++a) p[a] = static_cast<float>(at[a] + displaced * std::sin(7919.0 * (3 * i + a)));
    places.push_back(p);
  }
  return places;
}

TEST(Spray, ALoneParticleIsADropAndAPairHalfOfOne) {
  EXPECT_EQ(drops({{0, 0, 0, 0}}), std::vector<float>{1});
  const std::vector<float> far = drops({{0, 0, 0, 0}, {1.6f, 0, 0, 0}, {0, 30, 0, 0}});
  EXPECT_EQ(far, (std::vector<float>{1, 1, 1}));
  const std::vector<float> pair = drops({{0, 0, 0, 0}, {1, 0, 0, 0}});
  EXPECT_GT(pair[0], 0.2f);
  EXPECT_LT(pair[0], 0.8f);
  EXPECT_EQ(pair[0], pair[1]);
  EXPECT_TRUE(drops({}).empty());
}

TEST(Spray, ABlockItsFacesEdgesAndCornersAreNone) {
  for (const double displaced : {0.0, 0.1, 0.25})
    for (const float alone : drops(lattice(12, 9, 7, displaced))) EXPECT_EQ(alone, 0) << displaced;
  for (const float alone : drops(lattice(3, 3, 3))) EXPECT_EQ(alone, 0) << "few of them";
}

TEST(Spray, ASheetOfOneLayerIsNoneAndOneThatIsTornIs) {
  for (const float alone : drops(lattice(12, 12, 1))) EXPECT_EQ(alone, 0);
  std::vector<osg::Vec4f> torn = lattice(12, 12, 1);
  for (osg::Vec4f& p : torn) p *= 1.55f;
  for (const float alone : drops(torn)) EXPECT_EQ(alone, 1);
}

TEST(Spray, ADropBesideABlockIsNoneOnceItTouches) {
  std::vector<osg::Vec4f> places = lattice(8, 8, 8);
  float before = 1;
  for (double gap = 1.7; gap >= 0.5; gap -= 0.01) {
    std::vector<osg::Vec4f> with = places;
    with.emplace_back(3.5f, 3.5f, static_cast<float>(7 + gap), 0.0f);
    const std::vector<float> alone = drops(with);
    for (std::size_t i = 0; i < places.size(); ++i) ASSERT_EQ(alone[i], 0) << "of the block";
    EXPECT_LE(alone.back(), before) << gap << ": it only comes nearer";
    EXPECT_LT(before - alone.back(), 0.12f) << gap << ": without a step";
    before = alone.back();
  }
  EXPECT_EQ(before, 0);
}

// A particle moves by 0.01 spacings at most, and company by 3 times that for each of a few neighbours. The cells that
// find_flying() trusts may take one for whole that is loose; that is a step, and rare: 1 of 6,000, where blocks of
// 2x2x2 alone make it 1 of 1,000.
TEST(Spray, NoParticleComesOrGoesWithAStepWhereManyMove) {
  std::mt19937 random(7);
  std::normal_distribution<float> unit;
  std::vector<osg::Vec4f> places = lattice(6, 6, 6, 0.2), motions;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const float z = unit(random), y = unit(random), x = unit(random);  // the same motions whatever the compiler
    motions.emplace_back(x, y, z, 0.0f);
  }
  std::vector<float> before;
  std::size_t steps = 0, all = 0;
  for (int step = 0; step <= 1500; ++step) {
    std::vector<osg::Vec4f> moved;
    for (std::size_t i = 0; i < places.size(); ++i)
      moved.push_back(places[i] + motions[i] * (0.003f * static_cast<float>(step)));
    const std::vector<float> alone = drops(moved);
    for (std::size_t i = 0; i < before.size(); ++i, ++all)
      if (std::abs(alone[i] - before[i]) > 0.15f) ++steps;
    before = alone;
  }
  EXPECT_LT(static_cast<double>(steps), 2.5e-4 * static_cast<double>(all));
  EXPECT_GT(std::ranges::count(before, 1.0f), 50) << "many fly in the end";
}

TEST(Spray, OtherLiquidsAreCompany) {
  std::vector<float> other;
  for (const osg::Vec4f& p : lattice(6, 6, 6))
    for (int a = 0; a < 3; ++a) other.push_back(static_cast<float>(kDx) * p[a]);
  other.insert(other.end(), {std::nanf(""), 0, 0, 1e30f, 0, 0});
  const std::span<const float> others[] = {other};
  EXPECT_EQ(drops({{2.5f, 2.5f, 2.5f, 0}})[0], 1);
  EXPECT_EQ(drops({{2.5f, 2.5f, 2.5f, 0}}, others)[0], 0) << "it is within the other";
  EXPECT_EQ(drops({{2.5f, 2.5f, 9, 0}}, others)[0], 1) << "it flies above it";
}

TEST(Spray, FallsWithCompanySmoothly) {
  EXPECT_EQ(aloneness(0), 1);
  EXPECT_EQ(airiness(0), 1);
  for (float company = 0; company < 8; company += 0.01f) {
    const float fall = aloneness(company) - aloneness(company + 0.01f);
    EXPECT_TRUE(fall >= 0 && fall < 0.02f) << company;
    EXPECT_GE(airiness(company), aloneness(company));
  }
  EXPECT_EQ(aloneness(3), 0) << "the company of a lattice's corner";
  EXPECT_EQ(airiness(5), 0) << "that of its face";
}

TEST(Spray, OnlyWhatIsFastIsWhite) {
  EXPECT_EQ(whiteness(1, 0), 0);
  EXPECT_EQ(whiteness(1, 5), 1);
  EXPECT_EQ(whiteness(0, 5), 0);
  EXPECT_EQ(whiteness(1, std::numeric_limits<float>::quiet_NaN()), 0);
  for (float speed = 0; speed < 3; speed += 0.01f) {
    const float rise = whiteness(0.5f, speed + 0.01f) - whiteness(0.5f, speed);
    EXPECT_TRUE(rise >= 0 && rise < 0.02f) << speed;
  }
}

TEST(Spray, VelocitiesFollowFromTwoFrames) {
  ParticleFrame a, b;
  a.sim_time = 1;
  b.sim_time = 1.5 / 60 + 1;
  a.positions = {0, 0, 0, 1, 1, 1, std::nanf(""), 0, 0};
  b.positions = {0.025f, 0, -0.05f, 9, 1, 1, 0, 0, 0};
  const osg::Vec3f v = velocity_of(0, b, &a);
  EXPECT_NEAR(v.x(), 1, 1e-5);
  EXPECT_NEAR(v.z(), -2, 1e-5);
  EXPECT_EQ(velocity_of(1, b, &a), osg::Vec3f()) << "it was put elsewhere";
  EXPECT_EQ(velocity_of(2, b, &a), osg::Vec3f()) << "it was nowhere";
  EXPECT_EQ(velocity_of(3, b, &a), osg::Vec3f()) << "there is none";
  EXPECT_EQ(velocity_of(0, b, nullptr), osg::Vec3f());
  EXPECT_EQ(velocity_of(0, a, &b), osg::Vec3f()) << "that is later";
  b.sim_time = 2;
  EXPECT_EQ(velocity_of(0, b, &a), osg::Vec3f()) << "that is long ago";
  b.positions.pop_back();
  b.sim_time = 1.02;
  EXPECT_EQ(velocity_of(0, b, &a), osg::Vec3f()) << "that is of other particles";
}

}  // namespace
}  // namespace palp::test::spray_test
